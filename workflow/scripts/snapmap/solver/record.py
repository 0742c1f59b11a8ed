"""The motion of one cell, as a time loop records it."""

from typing import NamedTuple

import numpy as np


class Motion(NamedTuple):
    """Samples over time of the beam's n coordinates u, of y = z_M - rise, and of the ledger.

    time: us
    u, u_velocity: (samples, n); the others (samples,)
    work, lost: work of the pulse and energy lost to damping, pJ
    """

    time: np.ndarray
    u: np.ndarray
    u_velocity: np.ndarray
    y: np.ndarray
    y_velocity: np.ndarray
    work: np.ndarray
    lost: np.ndarray


class Form(NamedTuple):
    """The matrices that the coordinates u of a motion belong to, as in `Basis` and `ModalBeam`."""

    inertia: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    midpoint: np.ndarray
    residual: float

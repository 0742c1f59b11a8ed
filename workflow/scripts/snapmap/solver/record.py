"""The motion of one cell, as a time loop records it."""

from typing import NamedTuple

import numpy as np

from ..numerics.linalg import dot, multiply


class Motion(NamedTuple):
    """Samples over time of the beam's n coordinates u, the mass's displacement y, and the ledger.

    At instants; the kernel's half way between two, where its energies are known.

    time: us
    u, u_velocity: (samples, n); the others (samples,)
    stretch: u.G u + 2 u.G q0, um
    work of the pulse, energy lost to damping: pJ
    """

    time: np.ndarray
    u: np.ndarray
    u_velocity: np.ndarray
    y: np.ndarray
    y_velocity: np.ndarray
    stretch: np.ndarray
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
    shapes: np.ndarray

    def stretch(self, u: np.ndarray) -> np.ndarray:
        """u.G u + 2 u.G q0 of coordinates, (samples, n); um."""
        return dot(u, multiply(u, self.geometric) + 2 * self.slope_start)

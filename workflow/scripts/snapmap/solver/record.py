"""The motion of one cell, as a time loop records it."""

from typing import NamedTuple

import numpy as np

from ..device import Device
from ..numerics.linalg import dot, multiply


class Motion(NamedTuple):
    """Samples over time of the beam's n coordinates u, of the mass's way y, and of the ledger.

    At instants; the conserving scheme's half way between two, where its energies are known.

    time: us
    u, u_velocity: (samples, n); the others (samples,)
    stretch: u.G u + 2 u.G q0, um; overlap: of mass and beam where positive, um
    bending_energy, spring_energy, work of the pulse, energy lost to damping: pJ
    """

    time: np.ndarray
    u: np.ndarray
    u_velocity: np.ndarray
    y: np.ndarray
    y_velocity: np.ndarray
    stretch: np.ndarray
    overlap: np.ndarray
    bending_energy: np.ndarray
    spring_energy: np.ndarray
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


def at_instants(device: Device, form: Form, **samples: np.ndarray) -> Motion:
    """The motion of coordinates at instants; samples: what only the time loop knows, by name."""
    u, y = samples["u"], samples["y"]
    return Motion(
        stretch=dot(u, multiply(u, form.geometric) + 2 * form.slope_start),
        overlap=dot(u, form.midpoint) - y - device.gap,
        bending_energy=dot(u, multiply(u, form.bending)) / 2,
        spring_energy=device.spring * y**2 / 2,
        **samples,
    )

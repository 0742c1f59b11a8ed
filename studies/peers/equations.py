"""The equations that all peers solve: modes of the beam and the mass, as plain numbers."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from snapmap.beam.modal import contact_stiffness
from snapmap.solver.cells import Cells
from snapmap.solver.models import Model

Follow = Callable[[Cells], np.ndarray]
"""A function of cells (n,) that returns t_snap, us, or NaN for a cell that does not snap."""


class Equations(NamedTuple):
    """The equations of a device at rest in its first shape, without stops and beam damping.

    With k modes p and the displacement y of the mass, both from rest, in internal units:

        P = penalty <midpoint.p - y - gap>+,  s = geometric p + slope_start
        p'' = -axial p.(s + slope_start) s - stiffness p - load a - midpoint P
        y'' = (P - spring y - C y')/mass - a,  a = N g (1 - cos 2 pi f0 t)/2 until 1/f0
        w(L/2) = midpoint.p - residual P; the beam snaps when this falls to target

    stiffness, slope_start, load, midpoint: (k,); geometric: (k, k); the others are numbers
    """

    stiffness: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    geometric: np.ndarray
    axial: float
    residual: float
    penalty: float
    gap: float
    mass: float
    spring: float
    target: float

    @property
    def modes(self) -> int:
        """Number of modes k."""
        return self.load.size


def equations_of(model: Model) -> Equations:
    """Return the equations of a model of one device."""
    modal, device = model.modal, model.device
    arrays = (np.ascontiguousarray(getattr(modal, name)) for name in Equations._fields[:5])
    penalty = contact_stiffness(device, modal.residual)
    numbers = modal.axial, modal.residual, penalty, device.gap, device.mass, device.spring
    return Equations(*arrays, *map(float, (*numbers, model.snap_target("first"))))


def shocks(cells: Cells) -> tuple[np.ndarray, ...]:
    """Return amplitude (um/us^2), f0 (1/us), C (uN us/um) and t_end (us) of cells, each (n,)."""
    return cells.amplitude, cells.f0, cells.damping, cells.t_end

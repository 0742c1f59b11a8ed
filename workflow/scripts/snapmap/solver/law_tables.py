"""Tables of a user's laws of contact and force, of a batch of devices."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..beam.modal import ModalBeam
from ..device.device import Device
from .kernel.tables import CELLS, least_energy, potentials
from .laws import REACH, Laws, fault_of, forces

CHORDS = 64
"""Chords of a law of the force from the first to the second shape, for its stiffness."""
PASSES = 4
"""Passes for the overlap that a law leaves to a flexibility in series."""


@dataclass(frozen=True, eq=False)
class Tables:
    """Potentials of the laws of contact and force of a batch, in place of the device's.

    values: (tables, CELLS, 4), as `potentials` makes them; the first is of no force at all
    contact, force: number of the table of each device, 0 if the device's own acts, (devices,)
    reach: of the tables of each device, um, (devices,)
    bounded: whether the energy of the contact is nowhere below 0, (devices,)
    apart: whether the contact does nothing across a gap, (devices,)
    """

    values: np.ndarray
    contact: np.ndarray
    force: np.ndarray
    reach: np.ndarray
    bounded: np.ndarray
    apart: np.ndarray

    def pick(self, which: int | np.ndarray) -> "Tables":
        """Return the tables of a device of the batch, or of several."""
        columns = {key: np.atleast_1d(a[which]) for key, a in vars(self).items() if key != "values"}
        return replace(self, **columns)


def tabulate(laws: Laws, device: Device, modal: ModalBeam) -> Tables:
    """Tabulate the laws of contact and force of a batch; ValueError, one line, for wrong ones.

    modal: of `well_as_mode` if there is a law of the force
    """
    bending = modal.stiffness[..., 0] / modal.midpoint[..., 0] ** 2
    columns = device.contact, modal.residual, REACH * device.beam.rise, bending
    stacked = np.stack(np.broadcast_arrays(*map(np.atleast_1d, columns)))
    kinds, kind = np.unique(stacked, axis=1, return_inverse=True)
    values, rows = [np.zeros((CELLS, 4))], []
    for stiffness, residual, reach, bending in kinds.T.tolist():
        contact, force, bounded, apart = 0, 0, True, True
        if laws.contact or laws.force:
            law = partial(laws.contact or _one_sided, stiffness)
            table = potentials(_in_series(law, residual), reach)
            least = least_energy(table)
            contact, bounded = len(values), np.isfinite(least)
            apart = not table[: CELLS // 2, 1:].any()
            table[:, 0] -= least if bounded else 0.0
            values.append(table)
        if laws.force:
            force = len(values)
            values.append(potentials(partial(_beyond, laws.force, bending), reach))
        rows.append((contact, force, reach, bounded, apart))
    of_devices = [np.array(column)[kind.ravel()] for column in zip(*rows, strict=True)]
    return Tables(np.array(values), *of_devices)


def well_as_mode(modal: ModalBeam, force: Callable, second: float) -> ModalBeam:
    """Return the modal beam of a law of the force: one mode, as stiff as the law is at most.

    A table has the difference of the law to this mode.
    """
    x = np.linspace(0.0, second, CHORDS + 1)
    stiffness = abs(np.diff(forces("force", force, x))).max() / x[1]
    parts = {key: 0.0 * getattr(modal, key) for key in ("geometric", "slope_start", "axial")}
    return modal._replace(stiffness=stiffness * modal.midpoint**2, **parts)


def _one_sided(stiffness, overlap):
    return stiffness * max(0.0, overlap)


def _beyond(law, bending, w):
    """Return the slope of the potential of a law over w, less that of a bending stiffness."""
    return -forces("force", law, -w) - bending * w


def _in_series(law, residual):
    """The contact of mass and kept modes, whose overlap is x = s + residual P(s)."""

    push = partial(forces, "contact", law)

    def of_both(x):
        s = np.sort(x)
        both = s + residual * push(s)
        rises = np.diff(both) / np.diff(s)
        if not (rises > 0).all():
            needs = "write elements without modes, or a law that falls less"
            raise fault_of(law, "contact", f"falls too steeply for modes left out; {needs}")
        rise = rises[np.clip(np.searchsorted(both, x) - 1, 0, rises.size - 1)]
        s = np.interp(x, both, s)
        for _ in range(PASSES):
            s = s - (s + residual * push(s) - x) / rise
        return push(s)

    return of_both if residual else push

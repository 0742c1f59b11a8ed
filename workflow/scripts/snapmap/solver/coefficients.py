"""The table of devices that the kernels read."""

import numpy as np

from ..beam.modal import contact_stiffness
from .kernel import rows as R
from .settings import FIRST, SECOND

SIDE = {FIRST: 1.0, SECOND: -1.0}
"""Factor of w, by which the midpoint of every run begins above its target."""


def coefficients(model, target: np.ndarray | float, start: str = FIRST) -> np.ndarray:
    """Tabulate what `kernel.lanes.load` takes of each device: (devices, coefficients).

    A row has numbers in the order of the kernel's rows, up to SIDE, then the vectors from KAPPA on,
    and the modes at the start.
    model: a `Model`; start: as in `Run`; target: as `Model.snap_target`, or -inf for no snap
    """
    device, modal, barrier = model.device, model.modal, model.barrier
    side, n, k, tables = SIDE[start], len(device), model.modes, model.tables
    numbers = {
        R.AXIAL: modal.axial,
        R.RESIDUAL: modal.residual,
        R.CONTACT: contact_stiffness(device, modal.residual),
        R.M: device.mass,
        R.K: device.spring,
        R.TARGET: target,
        R.BARRIER: barrier.energy,
        R.BARRIER_APART: barrier.energy,
        R.SADDLE: side * barrier.midpoint,
        R.Z0: device.gap,
        R.ALPHA: device.beam.damping,
        R.STOP_TOWARD: device.stop_toward,
        R.STOP_AWAY: device.stop_away,
        R.RESTITUTION: device.restitution,
        R.TABLE: 0,
        R.TABLE + 1: 0,
        R.REACH: 0,
        R.SIDE: side,
    }
    if tables:
        numbers[R.TABLE], numbers[R.TABLE + 1] = tables.contact, tables.force
        numbers[R.REACH] = tables.reach
        numbers[R.BARRIER] = np.where(tables.bounded, barrier.energy, -np.inf)
        numbers[R.BARRIER_APART] = np.where(tables.bounded & tables.apart, barrier.energy, -np.inf)
    vectors = modal.stiffness, modal.slope_start, modal.load, modal.midpoint  # KAPPA, SQ0, F, E
    columns = [np.broadcast_to(numbers[row], n)[:, np.newaxis] for row in sorted(numbers)]
    columns += [np.reshape(vector, (n, k)) for vector in vectors]
    columns += [np.reshape(modal.geometric, (n, k * k)), np.reshape(model.rest(start), (n, k))]
    return np.concatenate(columns, axis=1)

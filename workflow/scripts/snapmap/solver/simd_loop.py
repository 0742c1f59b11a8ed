"""Calls of the SIMD kernels for the cells of a model."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np

from ..beam.modal import contact_stiffness
from ..pulse.pulse import table
from .cells import Cells, no_observations
from .kernel import rows as R
from .kernel.lanes import Facts, Task, follow_all, load
from .kernel.laws import CONTACT, FORCE, LaneLaws
from .kernel.pulse import BLOCK, begin_pulse, no_pulse
from .kernel.rows import LANES, Shape
from .kernel.trace import keep_midpoints
from .lane_laws import lane_laws, raise_error
from .settings import FIRST, MOVE, SECOND, Run

SIDE = {FIRST: 1.0, SECOND: -1.0}
"""Factor of w, by which the midpoint of every run begins above its target."""
WINDOW = 64 * BLOCK
"""Steps whose midpoints are in memory at once."""


def march(model, cells: Cells, dt: np.ndarray, settings: Run) -> Facts:
    """Follow cells, (cells,), of a `Model`, as `Run` say, in steps dt, us, (cells,).

    Returns `Facts`.
    """
    nothing = no_observations(cells.f0.shape)
    facts = Facts(*(getattr(nothing, key) for key in Facts._fields))
    task = Task(
        devices=_coefficients(model, settings.start),
        pulses=table(cells.pulses),
        device=cells.device,
        pulse=cells.pulse,
        amplitude=cells.amplitude,
        f0=cells.f0,
        damping=cells.damping,
        t_end=cells.t_end,
        dt=dt,
        stop_at_snap=settings.until in ("snap", "edge"),
        jumps=settings.question != MOVE and any(pulse.waits.size for pulse in cells.pulses),
        tolerance=settings.energy_tolerance,
        facts=facts,
    )
    lanes = empty_lanes(model)
    follow_all(*lanes, task)
    raise_error(model.laws, lanes[2])
    return facts


@lru_cache(maxsize=1)
def _coefficients(model, start):
    """Return `coefficients` of runs that may snap, and keep them for the next call of a batch."""
    return coefficients(model, model.snap_target(start), start)


def midpoints(
    model, cells: Cells, dt: np.ndarray, steps: int, start: str = FIRST
) -> Iterator[tuple[int, np.ndarray]]:
    """Follow up to LANES cells; yield the first step of each WINDOW, and w(L/2) from rest in it.

    dt: us, (cells,); steps: number for all cells
    w(L/2) is half way through each step, um, (steps, cells).
    """
    lanes, state, pulses = empty_lanes(model), no_pulse(), table(cells.pulses)
    rows = coefficients(model, -np.inf, start)
    for l in range(dt.size):
        load(*lanes, l, rows[cells.device[l]], cells.damping[l], cells.amplitude[l], dt[l])
        begin_pulse(lanes[0], l, state, pulses, cells.pulse[l], cells.f0[l] * dt[l])
    for first in range(0, steps, WINDOW):
        w = np.empty((min(WINDOW, steps - first), LANES))
        keep_midpoints(*lanes, state, pulses, first, w)
        raise_error(model.laws, lanes[2])
        yield first, w[:, : dt.size]


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
        R.TABLE + CONTACT: 0,
        R.TABLE + FORCE: 0,
        R.REACH: 0,
        R.SIDE: side,
    }
    if tables:
        numbers[R.TABLE + CONTACT], numbers[R.TABLE + FORCE] = tables.contact, tables.force
        numbers[R.REACH] = tables.reach
        numbers[R.BARRIER] = np.where(tables.bounded, barrier.energy, -np.inf)
        numbers[R.BARRIER_APART] = np.where(tables.bounded & tables.apart, barrier.energy, -np.inf)
    vectors = modal.stiffness, modal.slope_start, modal.load, modal.midpoint  # KAPPA, SQ0, F, E
    columns = [np.broadcast_to(numbers[row], n)[:, np.newaxis] for row in sorted(numbers)]
    columns += [np.reshape(vector, (n, k)) for vector in vectors]
    columns += [np.reshape(modal.geometric, (n, k * k)), np.reshape(model.rest(start), (n, k))]
    return np.concatenate(columns, axis=1)


def in_lanes(follow: Callable[[np.ndarray], None], lengths: np.ndarray, threads: int) -> None:
    """Call `follow` with indices of LANES cells at a time, in order of their lengths, (cells,)."""
    # Lanes run together until the longest ends: those of a call should be of equal length.
    order = np.argsort(lengths, kind="stable")
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(LANES, order.size, LANES))))


def empty_lanes(model) -> tuple[np.ndarray, Shape, LaneLaws | None]:
    """Make the first arguments of kernels: an empty work array, a tuple of a length, and the laws.

    The length of the tuple tells kernels the number of modes.
    """
    padded = np.zeros((R.VECTORS + (R.S + model.modes) * model.modes) * LANES + 8)
    # Wide vector loads are fastest from the start of a cache line.
    X = padded[(-padded.ctypes.data // 8) % 8 :][: padded.size - 8]
    return X, (0,) * model.modes, lane_laws(model.laws, model.tables)

"""Calls of the SIMD kernels for the cells of a model."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np

from ..pulse.pulse import table
from .cells import Cells, no_observations
from .coefficients import coefficients
from .kernel import rows as R
from .kernel.lanes import Facts, Task, follow_all, load
from .kernel.laws import LaneLaws
from .kernel.pulse import BLOCK, begin_pulse, no_pulse
from .kernel.rows import LANES, Shape
from .kernel.trace import keep_midpoints
from .lane_laws import lane_laws, raise_error
from .settings import FIRST, MOVE, Run

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
        stop_at_snap=settings.until in ("snap", "edge", "pulse"),
        stop_after_pulse=settings.until == "pulse",
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

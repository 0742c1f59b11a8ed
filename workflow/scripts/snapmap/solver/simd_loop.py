"""Calls of the SIMD kernels for the cells of a model."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..files.counting import count
from ..pulse.pulse import table
from .cells import Cells, no_observations
from .coefficients import coefficients
from .kernel import rows as R
from .kernel.lanes import Facts, Task, follow_all, load
from .kernel.laws import LaneLaws
from .kernel.pulse import BLOCK, Pulses, PulseState, begin_pulse, no_pulse
from .kernel.rows import LANES, Shape
from .kernel.trace import keep_seen, leap
from .lane_laws import lane_laws, raise_error
from .settings import FIRST, SHOWN, Run

WINDOW = 64 * BLOCK
"""Most steps whose records are in memory at once."""
MODELS = 16
"""Most models whose coefficients are kept: the levels and steps of the search for a threshold."""


def march(model, cells: Cells, dt: np.ndarray, settings: Run) -> Facts:
    """Follow cells, (cells,), of a `Model`, as `Run` say, in steps dt, us, (cells,).

    Returns `Facts`.
    """
    nothing = no_observations(cells.f0.shape)
    dt_excited, dt_calm = model.steps_after_snap(cells, dt, settings)
    facts = Facts(*(getattr(nothing, key) for key in Facts._fields))
    task = Task(
        devices=_coefficients(model, settings.start),
        **cells._asdict() | {"pulses": table(cells.pulses)},
        dt=dt,
        dt_excited=dt_excited,
        dt_calm=dt_calm,
        stop_at_snap=settings.until in ("snap", "edge"),
        tolerance=settings.energy_tolerance,
        facts=facts,
    )
    lanes = empty_lanes(model)
    leaps = () if settings.until != SHOWN and may_jump(model, cells) else None
    follow_all(*lanes, leaps, task)
    raise_error(model.laws, lanes[2])
    return facts


@lru_cache(maxsize=MODELS)
def _coefficients(model, start):
    """Return `coefficients` of runs that may snap, and keep them for the next calls of a batch."""
    return coefficients(model, model.snap_target(start), start)


class Lanes(NamedTuple):
    """Running cells, up to LANES: the first arguments of recorders, those of `kernel.trace`."""

    work: np.ndarray
    shape: Shape
    laws: LaneLaws | None
    state: PulseState
    pulses: Pulses


def begin(model, cells: Cells, dt: np.ndarray, start: str) -> tuple[Lanes, np.ndarray]:
    """Put up to LANES cells at rest into lanes, to follow without an end; dt: us, (cells,).

    Returns them, and the modes p of `ModalBeam` over the kernel's, (LANES, modes).
    """
    lanes = Lanes(*empty_lanes(model), no_pulse(), table(cells.pulses))
    rows = coefficients(model, -np.inf, start)
    for l in range(dt.size):
        device = rows[cells.device[l]]
        load(*lanes[:3], l, device, cells.damping[l], cells.amplitude[l], dt[l])
        begin_pulse(lanes.work, l, *lanes[3:], cells.pulse[l], cells.f0[l] * dt[l])
    stretches = lanes.work.reshape(-1, LANES)[R.VECTORS + R.U * model.modes :][: model.modes]
    return lanes, stretches.T.copy()


def in_windows(
    model, lanes: Lanes, steps: np.ndarray, keep: Callable[[int], np.ndarray], jumps: bool
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Follow lanes; yield the first step of each lane in each window, and what `keep` kept of it.

    steps: number of steps of each cell, after which its lane goes on beside longer ones, (cells,)
    keep: a call of a recorder for a number of steps; jumps: whether windows leave out quiet time
    """
    left = most = steps.max()
    while left > 0:
        first = lanes.state.steps[: steps.size].copy()
        kept = keep(min(WINDOW, BLOCK * -(-left // BLOCK)))
        raise_error(model.laws, lanes.laws)
        yield first, kept
        if jumps:
            leap(lanes.work, lanes.shape, lanes.state, lanes.pulses)
        before, left = left, max(0, (steps - lanes.state.steps[: steps.size]).max())
        count(steps.size * float(before - left) / float(most))


def watch(
    model,
    cells: Cells,
    dt: np.ndarray,
    steps: np.ndarray,
    start: str = FIRST,
    stress: np.ndarray | None = None,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Follow up to LANES cells in windows; yield what is seen half way through each step.

    dt: us; steps: as in `in_windows`; both (cells,)
    stress: `motion.stress_rows` of each cell, if it is wanted, (cells, PLACES + 1, modes + 2)
    Yields the first step of each cell, and w(L/2) from rest, um, and the largest stress in the
    beam, MPa, (2, steps, cells). Windows leave out quiet time.
    """
    (lanes, stretches), rows = begin(model, cells, dt, start), np.empty((0, 1, model.modes + 2))
    if stress is not None:
        rows = stress.copy()
        rows[:, :-1, : model.modes] *= stretches[: dt.size, np.newaxis]
        rows[:, :-1, model.modes] /= (dt * dt)[:, np.newaxis]

    def keep(size):
        seen = np.empty((2, size, LANES))
        keep_seen(*lanes, rows, *seen)
        return seen[..., : dt.size]

    return in_windows(model, lanes, steps, keep, may_jump(model, cells))


def may_jump(model, cells: Cells) -> bool:
    """Whether cells may have quiet time."""
    return not model.laws and any(pulse.waits.size for pulse in cells.pulses)


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

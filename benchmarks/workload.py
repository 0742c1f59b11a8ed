"""Workload A, and how whoever follows its cells is timed and checked."""

from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from snapmap.cells import Cells, follow_cells, to_cells
from snapmap.device import Device
from snapmap.models import Model
from snapmap.protocol import Protocol
from snapmap.wells import Barrier

HORIZON = 1500.0
DAMPING = 0.025
PROTOCOL = Protocol(HORIZON, until="snap", repeat=False)
N_RANGE = 600.0, 2400.0
F0_RANGE = 300.0, 20e3
"""Hz."""

Follow = Callable[[Cells], np.ndarray]
"""Cells to t_snap, us, NaN for a cell that does not snap."""


class Run(NamedTuple):
    """A task's result, and the shortest time that it took, s."""

    result: Any
    seconds: float


def map_cells(device: Device, side: int = 16) -> Cells:
    """Workload A: side x side cells, N spaced evenly and f0 by ratio."""
    N, f0 = np.meshgrid(np.linspace(*N_RANGE, side), np.geomspace(*F0_RANGE, side))
    return to_cells(device, N.ravel(), f0.ravel(), np.full(side**2, DAMPING), HORIZON)


def random_cells(device: Device, count: int) -> Cells:
    """As many cells as wished, strewn over the map."""
    rng = np.random.default_rng(count)
    N = rng.uniform(*N_RANGE, count)
    f0 = np.exp(rng.uniform(*np.log(F0_RANGE), count))
    return to_cells(device, N, f0, np.full(count, DAMPING), HORIZON)


def pick(cells: Cells, which: slice) -> Cells:
    """Some of the cells."""
    return Cells(*(values[which] for values in cells))


def without_proofs(model: Model) -> Model:
    """Under a barrier of no height nothing is proven: each cell goes on to its snap or horizon."""
    return model._replace(barrier=Barrier(0.0, 0.0))


def by_model(model: Model, threads: int = 1) -> Follow:
    """Follow cells as a sweep does."""
    return lambda cells: follow_cells(model, cells, PROTOCOL, threads).t_snap


def take_turns(tasks: dict, rounds: int) -> dict[Any, Run]:
    """Run every task `rounds` times, in turns, A B C A B C ..."""
    runs = {}
    for _ in range(rounds):
        for name, task in tasks.items():
            start = perf_counter()
            result = task()
            seconds = perf_counter() - start
            runs[name] = Run(result, min(seconds, runs[name].seconds if name in runs else np.inf))
    return runs


def count_steps(model: Model, cells: Cells, t_snap: np.ndarray) -> float:
    """Steps that the cells need to their snaps or horizons."""
    return float(np.sum(np.where(np.isnan(t_snap), cells.t_end, t_snap)) / model.dt)


def same_labels(some: np.ndarray, others: np.ndarray) -> int:
    """How many cells snap in both, or in neither."""
    return int(np.sum(np.isnan(some) == np.isnan(others)))


def threshold(device: Device, follow: Follow, f0: float) -> float:
    """Lowest N that snaps within 300 us of the pulse, to 1e-6, by refining a grid of 16."""
    low, high = 700.0, 1100.0
    while high - low > 1e-6 * high:
        N = np.linspace(low, high, 18)
        inner = np.full(16, f0), np.full(16, DAMPING)
        snaps = np.isfinite(follow(to_cells(device, N[1:-1], *inner, 300.0)))
        first = 1 + int(np.argmax(snaps)) if snaps.any() else 17
        low, high = N[first - 1], N[first]
    return high

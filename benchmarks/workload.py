"""Workload A, and how whoever follows its cells is asked and checked."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from snapmap.device import Device
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.model import Model
from snapmap.solver.settings import Settings
from studies.few import few

HORIZON = 1500.0
DAMPING = 0.025
SETTINGS = Settings(HORIZON, until="snap", repeat=False)
SIDE, FEWEST = 16, 4
"""Cells of the map along N and f0, all and in a small run."""
N_RANGE = 600.0, 2400.0
F0_RANGE = 300.0, 20e3
"""Hz."""

Follow = Callable[[Cells], np.ndarray]
"""Cells to t_snap, us, NaN for a cell that does not snap."""


def map_cells(device: Device) -> Cells:
    """Workload A: N spaced evenly and f0 by ratio."""
    side = few(SIDE, FEWEST)
    N, f0 = np.meshgrid(np.linspace(*N_RANGE, side), np.geomspace(*F0_RANGE, side))
    return to_cells(device, 0, N.ravel(), f0.ravel(), DAMPING, HORIZON)


def without_proofs(model: Model) -> Model:
    """Under a barrier of no height nothing is proven: each cell goes on to its snap or horizon."""
    return replace(model, barrier=model.barrier._replace(energy=0.0, midpoint=0.0))


def by_model(model: Model) -> Follow:
    """Follow cells as a sweep does."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def count_steps(model: Model, cells: Cells, t_snap: np.ndarray) -> float:
    """Steps that the cells need to their snaps or horizons."""
    dt = model.steps.of(cells, SETTINGS.question)
    return float(np.sum(np.where(np.isnan(t_snap), cells.t_end, t_snap) / dt))


def same_labels(some: np.ndarray, others: np.ndarray) -> int:
    """How many cells snap in both, or in neither."""
    return int(np.sum(np.isnan(some) == np.isnan(others)))


def threshold(device: Device, follow: Follow, f0: float) -> float:
    """Lowest N that snaps within 300 us of the pulse, to 1e-6, by refining a grid of 16."""
    low, high = 700.0, 1100.0
    while high - low > 1e-6 * high:
        N = np.linspace(low, high, 18)
        snaps = np.isfinite(follow(to_cells(device, 0, N[1:-1], f0, DAMPING, 300.0)))
        first = 1 + int(np.argmax(snaps)) if snaps.any() else 17
        low, high = N[first - 1], N[first]
    return high

"""The plan of a study: the slabs of its grid, and what the job of each may cost."""

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from ..applications import gather
from ..config.study import Config
from ..solver.adaptive import choose_model
from ..solver.cells import to_cells
from ..solver.cost import MOST_SECONDS, steps_and_seconds
from ..study.axes import DEVICE
from ..sweeps.slabs import SINGLE, Slab, cells_in

JOB_SECONDS = 30
"""Largest expected time of a slab, long against a job's start, and short enough to lose. Most slabs
take over a third of it."""
SHARED_SECONDS = 0.2
"""Largest expected time of a study that is a single job, as it takes less than a job's start."""
SLAB_CELLS = 3_000_000
"""Most cells of a slab, for its memory, but for a row that stays together."""
MOST_CELLS, MOST_SINGLE = 10**10, 1000
"""Most cells of a grid, and most values of C, each of which makes a slab; more are a slip."""
START_MB, CELL_MB = 1000, 5e-4
"""Memory requested for a job's start and for each cell; 700 MB and 300 B were measured."""
START_MINUTES, CAUTION = 2, 20
"""Minutes requested for a job's start, and factor on its time; 15 s and a factor of 3 to 12 were
measured."""


class Request(NamedTuple):
    """What a job requests of a cluster: memory in MB, run time in minutes."""

    mem_mb: int
    runtime: int


class Plan(NamedTuple):
    """The slabs of a study, the request of each slab's job, and the expected core time, s."""

    slabs: tuple[Slab, ...]
    requests: tuple[Request, ...]
    seconds: float


def make_plan(study: Config) -> Plan:
    """Cut the grid of a study into regular slabs, along boundaries that do not move if it grows.

    Raises ValueError, one line, for a model that cannot be built or a grid that takes too long.
    """
    grid, settings = study.grid, study.run
    axes, cells = grid.axes, math.prod(map(float, grid.shape))
    if cells > MOST_CELLS:
        need = f"more than {MOST_CELLS:.0e}; write fewer points"
        raise ValueError(f"sweep: {cells:.3g} cells, {need}")
    if axes["C"].size > MOST_SINGLE:
        need = f"at most {MOST_SINGLE}, as each gets a job"
        raise ValueError(f"sweep.C: {axes['C'].size} values; write {need}")
    dt, seconds = _expected(study, settings, axes["f0"])
    total = float(seconds.sum() * axes["N"].size * axes["C"].size * len(grid.pulses))
    beside, lowest = 0.0, axes["f0"][0]
    alone, moved = gather(lambda part: part.alone(study)), settings.but(until="moved")
    for f0 in alone.values():
        beside += _expected(study, moved, np.array(f0))[1].max(axis=0).sum()
    if total + beside > MOST_SECONDS:
        key = "run.horizon" if settings.horizon * lowest > 1e6 else "sweep.f0"
        if beside > total:
            key = min(alone, key=lambda key: min(alone[key]))
            lowest = min(alone[key])
        raise ValueError(
            f"{key}: up to {(total + beside) / 3600:.2g} core hours from f0 = {lowest:g} Hz "
            f"with horizon {settings.horizon:g} us and steps of {dt:.2g} us, more than "
            f"{MOST_SECONDS / 3600:g}; write fewer points, a higher f0 or a shorter horizon"
        )
    known = np.where(grid.device_of < 0, 0, grid.device_of)
    cost = np.where(grid.device_of[..., np.newaxis] < 0, 0.0, seconds[known])
    if DEVICE in axes:
        cost = cost.max(axis=[*axes].index(DEVICE))
    runs = _runs(axes, cost, study.model.name == "auto")
    # Many slabs share one copy of their N.
    parts = [[(run, tuple(axes[key][run].tolist())) for run in runs[key]] for key in axes]
    slabs, requests = [], []
    for runs_of_slab in product(*parts):
        sides = zip(*runs_of_slab, strict=True)
        places, values = (dict(zip(axes, side, strict=True)) for side in sides)
        slabs.append(values)
        *rows, N = (run for key, run in places.items() if key not in SINGLE)
        cells = cells_in(values)
        minutes = START_MINUTES + CAUTION * float(cost[np.ix_(*rows)].sum()) * N.size / 60
        requests.append(Request(int(START_MB + CELL_MB * cells), math.ceil(minutes)))
    return Plan(tuple(slabs), tuple(requests), total + float(beside))


def _runs(axes, cost, keeps_N):
    """Cut each axis into runs of places, f0 first, until slabs are within JOB_SECONDS, SLAB_CELLS.

    cost: expected time of a cell, s, (axes of the device, f0)
    keeps_N: whether rows along N stay whole, as `auto` looks at neighbours
    """
    runs = {key: list(np.arange(axes[key].size)[:, np.newaxis]) for key in axes}
    if cost.sum() * axes["N"].size * axes["C"].size <= SHARED_SECONDS:
        runs["C"] = [np.arange(axes["C"].size)]
    cut = [key for key in axes if key not in SINGLE]
    # Shares of what a slab may have, of a whole row along N.
    left = (np.maximum(cost / JOB_SECONDS, 1 / SLAB_CELLS) * axes["N"].size)[..., np.newaxis]
    for key in ("f0", *cut[:-2], "N"):
        axis, size = cut.index(key), axes[key].size
        others = tuple(other for other in range(len(cut)) if other != axis)
        share = np.broadcast_to(left.sum(axis=others) * (left.shape[axis] / size), size)
        if left.sum() <= 1 or (key == "N" and keeps_N):
            runs[key] = [np.arange(size)]
        else:
            runs[key] = _halved(np.arange(size), axes[key].view(np.uint64), share)
            left = left.max(axis=axis, keepdims=True)
    return runs


def _halved(run, bits, share):
    """Halve a run of places, octaves first, until no part has a share above 1.

    The halves belong to a fixed binary tree over all floating-point numbers: if a grid grows, runs
    without a new value stay.
    bits: of the values on the axis; share: of each value, of what a slab may have
    """
    if run.size == 1 or share[run].sum() <= 1:
        return [run]
    highest = int(np.bitwise_or.reduce(bits[run] ^ bits[run[0]])).bit_length() - 1
    upper = (bits[run] >> np.uint64(highest)) & np.uint64(1) == 1
    return _halved(run[~upper], bits, share) + _halved(run[upper], bits, share)


def _expected(study, settings, f0):
    """Estimate the shortest time step, us, and the mean time of a cell, s, (devices, f0)."""
    grid = study.grid
    built = choose_model(grid.device, study.model, settings.start).levels[0]
    device, pulse = np.arange(len(grid.device)), np.arange(len(grid.pulses))[:, np.newaxis]
    at = device[:, np.newaxis, np.newaxis], 0.0, f0, 0.0, settings.horizon, pulse, grid.pulses
    cells = to_cells(grid.device, *at)
    dt, seconds = steps_and_seconds(built, cells, settings)
    return dt.min(), seconds.mean(axis=1)

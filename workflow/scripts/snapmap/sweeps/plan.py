"""The plan of a study: its grid cut into slabs, and what the job of each may cost."""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np

from ..axes import DEVICE, Grid
from ..solver.adaptive import choose_model
from ..solver.cells import to_cells
from ..solver.cost import MOST_SECONDS, steps_and_seconds
from ..solver.settings import Settings
from .partition import SINGLE, Slab

JOB_SECONDS = 30
"""At most the expected time of a slab, most take over a third: long against a job's start, and
short enough to lose."""
SLAB_CELLS = 400_000
"""At most in a slab, for its memory, but for a row that stays together."""
MOST_CELLS, MOST_SINGLE = 10**10, 1000
"""Grids beyond are taken for a slip; the latter have 1000 slabs at least."""
START_MB, CELL_MB = 1000, 5e-4
"""Asked for a job's start and for each cell; seen: 700 MB, two Snakemakes among them, and 300 B."""
START_MINUTES, CAUTION = 2, 20
"""Asked for a job's start, and times the expected time; seen: 15 s, and SEEN times."""
SEEN = 3, 9


class Request(NamedTuple):
    """What a job asks of a cluster; memory in MB, run time in minutes."""

    mem_mb: int
    runtime: int


class Plan(NamedTuple):
    """The slabs of a study, what the job of each asks for, and the expected core time in all, s."""

    slabs: tuple[Slab, ...]
    requests: tuple[Request, ...]
    seconds: float


def make_plan(grid: Grid, model: Mapping, settings: Settings, alone: Sequence[float] = ()) -> Plan:
    """Cut a grid into slabs, along boundaries that no other value moves.

    model: name and options; alone: f0 (Hz) of cells that are followed beside the grid
    Raises ValueError, one line, for a model that cannot be built and a grid beyond all reason.
    """
    axes = grid.axes
    _check_size(grid)
    dt, seconds = _expected_of_each(grid, model, settings, axes["f0"])
    total = seconds.sum() * axes["N"].size * axes["C"].size * len(grid.pulses)
    if len(alone):
        moved = settings._replace(until="moved")
        total += _expected_of_each(grid, model, moved, np.array(alone))[1].max(axis=0).sum()
    _check_cost(axes["f0"][0], settings, dt, total)
    known = np.where(grid.device_of < 0, 0, grid.device_of)
    cost = np.where(grid.device_of[..., np.newaxis] < 0, 0.0, seconds[known])
    # `auto` looks at neighbours along N: they stay together.
    whole = ("N",) if model["name"] == "auto" else ()
    single = [key for key in SINGLE if key in axes]
    everything = {key: np.arange(axes[key].size) for key in axes if key not in single}
    slabs, requests = [], []

    @cache  # of one copy, as N is that of all slabs
    def values(key, first, last):
        return tuple(axes[key][first : last + 1].tolist())

    for place in product(*(range(axes[key].size) for key in single)):
        at = dict(zip(single, place, strict=True))
        rows = cost[at[DEVICE]] if DEVICE in at else cost
        for box in _boxes(everything, axes, rows, whole):
            chosen = box | {key: [at[key]] for key in single}
            slabs.append({key: values(key, chosen[key][0], chosen[key][-1]) for key in axes})
            requests.append(_request(box, rows))
    return Plan(tuple(slabs), tuple(requests), float(total))


def _boxes(box, axes, cost, whole):
    """Halve a box, octaves first, until none is beyond JOB_SECONDS or SLAB_CELLS.

    The halves are those of a fixed binary tree over all floating-point numbers, so that a grid
    that grows keeps every box without a new value.
    box: places on each axis that is cut; cost: of the cells there
    whole: axes that are not halved
    """
    levels = {key: _level(axes[key][places]) for key, places in box.items() if key not in whole}
    axis = max(levels, key=levels.get)
    small = math.prod(places.size for places in box.values()) <= SLAB_CELLS
    if (small and _expected(box, cost) <= JOB_SECONDS) or not levels[axis]:
        return [box]
    upper = _is_upper(axes[axis][box[axis]], levels[axis])
    halves = [box | {axis: box[axis][side]} for side in (~upper, upper)]
    return [part for half in halves for part in _boxes(half, axes, cost, whole)]


def _expected(box, cost):
    *places, N = box.values()
    return float(cost[np.ix_(*places)].sum()) * N.size


def _level(ascending):
    """The highest bit in which the numbers differ, counted from 1; 0 for a single number."""
    bits = ascending.view(np.uint64)
    return int(bits[0] ^ bits[-1]).bit_length()


def _is_upper(ascending, level):
    return (ascending.view(np.uint64) >> np.uint64(level - 1)) & np.uint64(1) == 1


def _check_size(grid: Grid):
    cells = int(np.prod([float(size) for size in grid.shape]))
    if cells > MOST_CELLS:
        need = f"more than {MOST_CELLS:.0e}; write fewer points"
        raise ValueError(f"sweep: {cells:.3g} cells, {need}")
    if grid.axes["C"].size > MOST_SINGLE:
        need = f"at most {MOST_SINGLE}, as each gets a job"
        raise ValueError(f"sweep.C: {grid.axes['C'].size} values; write {need}")


def _check_cost(lowest_f0, settings, dt, seconds):
    if seconds > MOST_SECONDS:
        raise ValueError(
            f"sweep: up to {seconds / 3600:.2g} core hours from f0 = {lowest_f0:g} Hz with horizon "
            f"{settings.horizon:g} us and steps of {dt:.2g} us, more than "
            f"{MOST_SECONDS / 3600:g}; write fewer points, a higher f0 or a shorter horizon"
        )


def _expected_of_each(grid, model, settings, f0):
    """Shortest step, us, and the time of one cell of each device and f0, s; mean over pulses."""
    built = choose_model(grid.device, model).levels[0]
    device, pulse = np.arange(len(grid.device)), np.arange(len(grid.pulses))[:, np.newaxis]
    at = device[:, np.newaxis, np.newaxis], 0.0, f0, 0.0, settings.horizon, pulse
    settings = settings._replace(pulses=grid.pulses)
    dt, seconds = steps_and_seconds(
        built, to_cells(grid.device, *at), settings, model["name"] == "reference"
    )
    return dt.min(), seconds.mean(axis=1)


def _request(box, cost):
    cells = math.prod(places.size for places in box.values())
    minutes = START_MINUTES + CAUTION * _expected(box, cost) / 60
    return Request(int(START_MB + CELL_MB * cells), int(np.ceil(minutes)))

"""The plan of a study: the slabs of its grid, its figures, and what all that may cost."""

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from ..applications import attached, gather, merge
from ..config.study import Config
from ..config.views import MAPS
from ..solver.adaptive import choose_model
from ..solver.cells import to_cells
from ..solver.cost import MOST_SECONDS, OF_THRESHOLD, steps_and_seconds
from ..study.axes import DIRECTION, NAMES, SHAPE
from ..sweeps.slabs import Slab, cells_in

JOB_SECONDS = 30
"""Largest expected time of a slab, long against a job's start, and short enough to lose. Most slabs
take over a third of it."""
FEW_SECONDS = 3
"""Expected time up to which a slab has several C, shapes, directions or named devices, as the start
of its job takes a second."""
SHARED_SECONDS = 0.2
"""Largest expected time of a study that is a single job, as it takes less than a job's start."""
SLAB_CELLS = 3_000_000
"""Most cells of a slab, for its memory, but for a row that stays together."""
MOST_CELLS = 10**10
"""Most cells of a grid; more are a slip."""
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
    # Axes of the pulse and C, of which it is the mean, come between the device's and f0.
    cost = np.expand_dims(cost, (*range(cost.ndim - 1, len(axes) - 2),))
    runs = _runs(axes, cost, study.model.name == "auto")
    # Many slabs share one copy of their N.
    parts = [[(run, tuple(axes[key][run].tolist())) for run in runs[key]] for key in axes]
    slabs, requests = [], []
    for of_slab in product(*parts):
        places, values = zip(*of_slab, strict=True)
        slabs.append(dict(zip(axes, values, strict=True)))
        cells = cells_in(slabs[-1])
        at = (run % size for run, size in zip(places, cost.shape, strict=False))
        minutes = START_MINUTES + CAUTION * cells * float(cost[np.ix_(*at)].mean()) / 60
        requests.append(Request(int(START_MB + CELL_MB * cells), math.ceil(minutes)))
    return Plan(tuple(slabs), tuple(requests), total + float(beside))


def _runs(axes, cost, keeps_N):
    """Cut each axis into runs of places until slabs are within their times and SLAB_CELLS.

    cost: expected time of a cell, s, (axes but N), 1 long where it is the same for all values
    keeps_N: whether rows along N stay whole, as `auto` looks at neighbours
    """
    keys, runs, most = [*axes], {}, FEW_SECONDS
    few = [key for key in keys if key in (*NAMES, "C")]
    left = np.maximum(cost, JOB_SECONDS / SLAB_CELLS)[..., np.newaxis]
    left *= math.prod(values.size for values in axes.values()) / left.size
    for key in (*reversed(few), "f0", *(key for key in keys[:-2] if key not in few), "N"):
        if key == "f0":
            most = JOB_SECONDS
        axis, size = keys.index(key), axes[key].size
        single = left * (left.shape[axis] / size)
        rest = tuple(other for other in range(len(keys)) if other != axis)
        share = np.broadcast_to(single.sum(axis=rest), size) / most
        if left.sum() <= most or (key == "N" and keeps_N):
            runs[key] = [np.arange(size)]
        else:
            runs[key] = _halved(np.argsort(axes[key]), _bits(axes[key]), share)
            left = single.max(axis=axis, keepdims=True)
    return runs


def _bits(values):
    """Give whole numbers in the order of values: bits of numbers from 0, letters of names."""
    if values.dtype.kind == "f":
        return values.view(np.uint64)
    longest = max(len(name.encode()) for name in values)
    padded = [name.encode().ljust(longest, b"\0") for name in values]
    return np.array([int.from_bytes(name) for name in padded], object)


def _halved(run, bits, share):
    """Halve a run of places, octaves first, until no part has a share above 1.

    The halves belong to a fixed binary tree over all numbers, or names: if a grid grows, runs
    without a new value stay.
    run: places in the order of their values
    bits: of the values on the axis; share: of each value, of what a slab may have
    """
    if run.size == 1 or share[run].sum() <= 1:
        return [run]
    highest = int(np.bitwise_or.reduce(bits[run] ^ bits[run[0]])).bit_length() - 1
    upper = (bits[run] >> highest) & 1 == 1
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


RUNS = {
    "cells": 1,
    "thresholds": OF_THRESHOLD,
    "thresholds of devices as made": 4,
    "verdicts": 1500,
    "histories": 700,
}
"""Runs that each takes, each as long as the mean run of a cell to its horizon."""
START, FIGURE = 2.5, 0.5
"""Core time of a job's start, and of a figure, s."""


def amounts(study: Config) -> dict[str, int]:
    """Count what a study computes, by the words of RUNS."""
    cells = math.prod(study.grid.shape)
    counts = {"cells": cells, "thresholds": cells // study.axes["N"].size}
    return counts | merge(lambda part: part.counts(study))


def core_seconds(study: Config, plan: Plan) -> float:
    """Estimate the core time of all jobs, s; runs that end early take less."""
    counts = amounts(study)
    runs = sum(RUNS[what] * count for what, count in counts.items())
    products = gather(lambda part: part.outputs(study))
    figures = sum(map(len, gather(lambda part: part.drawn(study)).values()))
    jobs = len(plan.slabs) + len(products)
    return START * jobs + FIGURE * figures + runs * plan.seconds / counts["cells"]


WORDS = {"snaps": "snap", "times": "time", "ends": "map"}
"""Word with which the name of a figure's file begins, by what its maps of cells show."""


class Views(NamedTuple):
    """The figures of cells and thresholds, in plain values.

    maps: figures of cells: `name`, what each `shows` (a key of WORDS), and its views as `panels`
    fields: maps of thresholds; curves: thresholds over an axis; own_points: as a `Config` has them
    """

    maps: list[dict]
    fields: list[dict]
    curves: list[dict]
    own_points: list

    @property
    def stems(self) -> dict[str, list[str]]:
        """Names of figures by their caption in the report."""
        snaps = [figure for figure in self.maps if figure["shows"] == "snaps"]
        others = [figure for figure in self.maps if figure not in snaps]
        parts = {"snap_maps": snaps + self.fields, "maps": others, "thresholds": self.curves}
        return {part: [figure["name"] for figure in figures] for part, figures in parts.items()}


def choose_views(study: Config) -> Views:
    """Choose the figures of the cells and thresholds of a study."""
    of_cells = [_with_shocks(view, study) for view in study.maps if view.is_of_cells]
    shown = [key for key in WORDS if key != "ends" or study.until == "settled"]
    maps = []
    for name in dict.fromkeys(view.name for view in of_cells):
        panels = [view._asdict() for view in of_cells if view.name == name]
        of_panels = ({"name": _called(name, WORDS[shows]), "shows": shows} for shows in shown)
        maps += [figure | {"panels": panels} for figure in of_panels]
    fields = [view._asdict() for view in study.maps if not view.is_of_cells]
    curves = [view._asdict() for view in study.curves]
    return Views(maps, fields, curves, list(study.own_points))


def _called(name, word):
    """Name a figure by the name of its views, with another word in place of `map`."""
    if word == "map":
        return name
    return f"{word}_{name}" if name == MAPS else f"{word}{name.removeprefix('map')}"


def _with_shocks(view, study):
    """Add the required shocks to a map, each with whether it has the pulse of the map's cells."""
    shape = list(study.shocks.shapes.values())[view.at.get(SHAPE, 0)]
    direction = study.shocks.directions[view.at.get(DIRECTION, 0)]
    of_map = shape.section, direction, study.start
    marks = [mark for part in attached().values() for mark in part.marks(study)]
    required = [(name, f0, N, of_map in pushed) for name, f0, N, pushed in marks]
    return view._replace(required_shocks=tuple(required))

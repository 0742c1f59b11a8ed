"""Forecasts of a study's core time, from a sample of its cells and thresholds that is followed.

How long a run takes depends on how it ends, and on the machine. The formulas of the cost, which
know steps and modes, tell how parts of a study compare; the sample tells how long they take here.
"""

import time
import warnings

import numpy as np

from ..applications import attached, gather, observers
from ..config.study import Config
from ..solver.adaptive import choose_model
from ..solver.cost import steps_and_seconds
from ..study.axes import NAMES, Grid, rows_of
from ..sweeps.grid import follow_rows
from ..thresholds.cost import survey_seconds
from ..thresholds.surface import search_of, thresholds_of
from ..thresholds.verified import split_rows
from .products import choose_views

OF_CELLS, OF_THRESHOLDS = 0.1, 0.6
"""Core time of a sample by the formulas, s."""
MOST = 4
"""Factor on this, above which a sample of single points is not followed."""
FIGURE = 0.5
"""Core time of a figure, s; 0.4 to 0.7 were measured."""
VERIFIED = 0.25
"""Time to verify a threshold on a surface over that to search one."""


def forecast(study: Config) -> dict[str, float]:
    """Forecast the core time of cells, thresholds, and what applications make, s, by name."""
    searching = study.of_thresholds()
    with warnings.catch_warnings(action="ignore"):
        cells = _scaled(study, _cell_seconds, _follow, OF_CELLS)
        thresholds = _scaled(searching, search_seconds, _search, OF_THRESHOLDS)
    drawn = FIGURE * count_figures(study)
    costs = gather(lambda part: part.cost(study))
    return {"cells": cells, "thresholds": thresholds, **costs, "figures": drawn}


def count_figures(study: Config) -> int:
    """Count the figures of a study, the page among them."""
    of_applications = gather(lambda part: part.drawn(study)).values()
    return sum(map(len, [*choose_views(study).stems.values(), *of_applications]))


def _scaled(study, expected, do, sample):
    """Time two samples of a study; returns the forecast for all of it, s.

    expected: the formula, for the rows of a grid, s; do: follows axes of a study
    sample: core time of the larger sample by the formula, s
    The difference of the two leaves out what a call takes that is not spent on rows.
    """
    axes = {key: values for key, values in study.axes.items() if key not in (*NAMES, "N")}

    def by_formula(points):
        return expected(study, study.set_out(points))

    larger = axes
    while by_formula(larger) > sample and max(map(len, larger.values())) > 1:
        larger = _thinned(larger)
    smaller = _thinned(larger)
    total, seconds, fewer = map(by_formula, (axes, larger, smaller))
    if seconds > MOST * sample:
        return total
    do(study, smaller)  # compiles kernels
    short, long = (_timed(do, study, points) for points in (smaller, larger))
    factor = max(long - short, 0.0) / (seconds - fewer) if seconds > fewer else long / seconds
    return long + factor * (total - seconds)


def _thinned(axes):
    """Leave out every other value of the longest axis, the first of an even number."""
    longest = max(axes, key=lambda key: axes[key].size)
    return axes | {longest: axes[longest][(axes[longest].size + 1) % 2 :: 2]}


def _timed(do, *arguments):
    begun = time.process_time()
    do(*arguments)
    return time.process_time() - begun


def _cell_seconds(study, grid):
    """Estimate the core time of the cells of a grid, at all N of the study, s."""
    built = choose_model(grid.device, study.model, study.start).levels[0]
    rows = rows_of(grid)
    cells = rows.take(rows.device >= 0).cells(built.device, 0.0, study.horizon)
    seconds = steps_and_seconds(built, cells, study.run)[1].sum()
    for part in attached().values():
        seconds += np.sum(part.observing(built, cells, study.run))
    return float(seconds) * study.axes["N"].size


def _follow(study, axes):
    grid = study.set_out(axes)
    built = choose_model(grid.device, study.model, study.start)
    follow_rows(built, rows_of(grid), study.axes["N"], study.run, observers())


def search_seconds(study: Config, grid: Grid) -> float:
    """Estimate the core time of the thresholds of a grid, without what each call takes, s."""
    search = search_of(study, grid)
    _, searched = split_rows(grid, search.rows)
    verified = ~searched & (search.rows.device >= 0)
    parts = (survey_seconds(search.take(of)) for of in (searched, verified))
    return next(parts) + VERIFIED * next(parts)


def _search(study, axes):
    thresholds_of(study, axes, study.threshold_tolerance, float(study.axes["N"][-1]))

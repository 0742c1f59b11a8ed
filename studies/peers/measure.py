"""Two tables: speed and error on a map, and the price of a single threshold."""

from collections.abc import Callable, Iterator
from functools import partial
from time import process_time
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from snapmap import Study, threshold
from snapmap.files.text import DASH
from snapmap.solver.options import Cosines

from ..common import few, number, ratio, take_turns
from ..tables import Table
from .contenders import NO_PROOFS, OURS, Contender, missing
from .equations import Follow
from .scene import COSINES, HORIZON, TOLERANCE, Scene, lowest_snap
from .starts import starts

ROUNDS = 3
"""Rounds of which the least time counts."""
HEAD = ["solver", "setting", "equations"]
ERRORS = ["error, median", "error, largest"]
MAP_HEAD = [*HEAD, "cells/s", *ERRORS, "snapmap faster at this median", "at this largest error"]
ALONE_HEAD = [*HEAD, "CPU ms", "runs", *ERRORS, "error bar, median"]


class Measured(NamedTuple):
    """A contender, its solver, cells per second on the map, and errors of the rows, (rows,)."""

    contender: Contender
    follow: Follow
    speed: float
    errors: np.ndarray


def measure(contenders: list[Contender], scenes: dict[str, Scene]) -> list[Measured]:
    """Measure each contender on its scene, the fast ones in turns."""
    follows = {one: one.make(scenes[one.equations]) for one in contenders}
    tasks, errors, runs = {}, {}, {}
    for one, follow in follows.items():
        scene = scenes[one.equations]
        errors[one] = scene.take(one.rows).errors(follow)
        cells = scene.map.take(np.arange(0, scene.map.f0.size, one.stride))
        tasks[one] = partial(follow, cells)
    for is_slow in (False, True):
        some = {one: task for one, task in tasks.items() if (one.stride > 1) == is_slow}
        runs |= take_turns(some, 1 if is_slow else 1 + few(ROUNDS), process_time)
    speeds = {one: run.result.size / run.seconds for one, run in runs.items()}
    return [Measured(one, follow, speeds[one], errors[one]) for one, follow in follows.items()]


def map_table(measured: list[Measured]) -> Table:
    """Make the table of speeds and errors on the map."""
    rows = []
    for one in measured:
        ours = [other for other in measured if is_ours(other, one)]
        gains = [DASH, DASH] if one in ours else [gain(one, ours, of) for of in (np.median, np.max)]
        cells = *one.contender[:2], one.contender.equations, number(one.speed)
        rows.append([*cells, *error_words(one.errors), *gains])
    rows += ([package, "not installed"] for package in missing())
    return Table("peers_map", MAP_HEAD, rows)


def is_ours(one: Measured, peer: Measured) -> bool:
    """Whether one is snapmap on the peer's equations."""
    return one.contender.solver == OURS and one.contender.equations == peer.contender.equations


def gain(peer: Measured, ours: list[Measured], of_errors: Callable) -> str:
    """Write the speed of the fastest of ours with no more error, over that of the peer."""
    bound = of_errors(peer.errors)
    speeds = [one.speed for one in ours if of_errors(one.errors) <= bound]
    return ratio(max(speeds) / peer.speed) if speeds else DASH


def error_words(errors: np.ndarray) -> list[str]:
    """Write the median and the largest of relative errors."""
    return [f"{of(errors):.1e}" for of in (np.median, np.max)]


def alone_table(measured: list[Measured], scenes: dict[str, Scene]) -> Table:
    """Make the table of thresholds that are asked for one at a time."""
    rows = [*own_calls(scenes[COSINES])]
    for one in loosest(measured):
        contender = one.contender
        scene, width = scenes[contender.equations].take(contender.rows), contender.width
        asks = [scene.take(slice(i, i + 1)).asked(one.follow) for i in range(scene.N.size)]
        lowest_snap(asks[0], width)  # compiles for so many cells
        start = process_time()
        N, runs = np.transpose([lowest_snap(ask, width) for ask in asks])
        words = each(process_time() - start, runs.sum(), N.size)
        errors = error_words(np.abs(N / scene.N - 1))
        rows.append([*contender[:2], contender.equations, *words, *errors, DASH])
    rows += starts()
    return Table("peers_threshold", ALONE_HEAD, rows)


def loosest(measured: list[Measured]) -> list[Measured]:
    """Return of each solver its first setting whose median error is within TOLERANCE."""
    able = [
        one
        for one in measured
        if np.median(one.errors) <= TOLERANCE and one.contender.solver != NO_PROOFS
    ]
    first = {(one.contender.solver, one.contender.equations): one for one in reversed(able)}
    return [*first.values()][::-1]


def own_calls(scene: Scene) -> Iterator[list[str]]:
    """Yield rows of calls of `snapmap.threshold`, which gives error bars and islands, too."""
    grid = np.unique(scene.f0), np.unique(scene.C)
    for equations, model in ((COSINES, Cosines(modes=3)), ("auto", "auto")):
        study = Study(scene.device, model, horizon=HORIZON)
        alone = [([f0], [C]) for f0, C in zip(scene.f0, scene.C, strict=True)]
        for way, calls in (("one a call", alone), ("all in one call", [grid])):
            threshold(study, *calls[0])  # compiles
            start, runs = process_time(), []
            with patch("snapmap.solver.models.count", runs.append):
                found = [threshold(study, *axes) for axes in calls]
            words = each(process_time() - start, sum(runs), scene.N.size)
            N, bars = (
                np.concatenate([edges[key].values.ravel() for edges in found])
                for key in ("N_first", "N_error")
            )
            errors = [DASH, DASH]
            if equations == COSINES:
                errors = error_words(np.abs(N / scene.N - 1))
            bar = f"{np.median(bars / N):.1e}"
            yield ["snapmap.threshold", way, equations, *words, *errors, bar]


def each(seconds: float, runs: float, count: int) -> list[str]:
    """Write the CPU time, ms, and the number of runs of one of so many thresholds."""
    return [number(1e3 * seconds / count), number(runs / count)]

"""Prints README.md: ensembles of small systems with impacts, by everyone who can follow them.

./run python -m studies impacts [--small] > studies/impacts/README.md
"""

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median
from time import process_time
from typing import NamedTuple

import numpy as np

from snapmap.files.text import DASH, table

from ..common import command_device, few, machine, rate, take_turns, versions
from ..speed import FEWEST, SIDE
from . import snap_map as snaps
from . import solvers
from .page import TEXT
from .problems import BALL, RIGID, make_ball, make_bilinear, make_oscillator, make_valve

ROUNDS = 3
SOME = slice(4, None, 9)
"""Trajectories, strewn over an ensemble, for those too slow for all."""
FEWER = slice(4, None, 29)
"""Likewise of the map."""
TOLERANCES = (1e-4,), (1e-6,), (1e-9,), (1e-12,)
LONGEST = (1e-4, 0.1), (1e-6, 0.1), *((*one, np.inf) for one in TOLERANCES[1:])
"""Tolerances, and longest steps: an event twice within a step is none."""
PLAIN = (0.1,), (0.03,), (0.01,), (0.003,), (0.001,)
STEPS = (500,), (2000,), (8000,), (32_000,), (128_000,)
FACTORS = (2.0,), (1.0,), (0.5,), (0.25,), (0.125,)
"""Of the step that our own rule chooses."""
MAP_STEPS = (0.4,), (0.2,), (0.1,)
OURS, SCIPY, PLAIN_LOOP = "snapmap", "SciPy", "plain loop"
HEAD = "problem", "contender", "loose: /s", "setting", "tight: /s", "setting"
CHECKS = "problem", "parameters", "t_end", "x(t_end)"


class Contender(NamedTuple):
    """Who follows an ensemble: made for it, then called with each of the settings.

    which: the trajectories that it follows
    """

    make: Callable
    settings: tuple[tuple[float, ...], ...]
    which: slice = slice(None)


def main():
    warnings.filterwarnings("ignore", "compiling the kernel")  # said of any compiled tuple
    device, rows, checks = command_device(), [], []
    for problem in ensembles():
        rows += measure(problem, contenders(problem, device))
        checks += answers(problem)
    the_map = snaps.make_map(device)
    rows += measure(the_map, map_contenders())
    facts = {"machine": machine(), "versions": versions("numpy", "numba", "scipy")}
    cells, snap = the_map.exact.size, int(the_map.exact.sum())
    counts = {"cells": cells, "snap": snap, "contested": few(SIDE, FEWEST) ** 2 - cells}
    found = {"table": table(HEAD, rows), "answers": table(CHECKS, checks)}
    print(TEXT.format(**facts, **counts, **found, fine=snaps.FINE, rounds=few(ROUNDS)), end="")


def ensembles():
    """The problems whose answers are places, one by one."""
    for make in few((make_ball, make_oscillator, make_bilinear, make_valve), 2):
        problem = make()
        if np.isnan(problem.exact).all():
            problem = replace(problem, exact=solvers.by_scipy(problem)(1e-13, np.inf))
        yield problem


def contenders(problem, device) -> dict[str, Contender]:
    """Who can follow a problem, and is here."""
    kernel = partial(solvers.by_kernel, device=device)
    found = {
        SCIPY: Contender(solvers.by_scipy, LONGEST, SOME),
        PLAIN_LOOP: Contender(solvers.by_plain_loop, PLAIN),
    }
    if problem.name in (BALL, RIGID):
        found[OURS] = Contender(kernel, STEPS)
    return found


def map_contenders() -> dict[str, Contender]:
    """Who labels the map."""
    found = {
        SCIPY: Contender(snaps.map_by_scipy, TOLERANCES[:3], FEWER),
        PLAIN_LOOP: Contender(snaps.map_by_plain_loop, MAP_STEPS),
    }
    found[OURS] = Contender(snaps.map_by_kernel, FACTORS)
    found[f"{OURS}, with proofs"] = Contender(snaps.map_by_proofs, FACTORS)
    return found


def measure(problem, of: dict[str, Contender]) -> list[list[str]]:
    """A row for each contender: its fastest setting that meets each bound."""
    tasks, parts = {}, {}
    for name, contender in of.items():
        parts[name] = problem.some(contender.which)
        solve = contender.make(parts[name])
        tasks |= {(name, one): partial(solve, *one) for one in contender.settings}
    first = take_turns(tasks, 1)  # compiles
    good = {key: task for key, task in tasks.items() if _meets(parts[key[0]], first[key].result, 0)}
    runs = take_turns(good, few(ROUNDS), process_time, median)
    columns = {name: [] for name in of}
    for level in (0, 1):
        for name, part in parts.items():
            columns[name] += _columns(_fastest(name, part, runs, level), part.exact.size)
    shown = {SCIPY: problem.name}  # by its first row
    return [[shown.get(name, ""), name, *found] for name, found in columns.items()]


def _meets(part, found, level):
    return part.wrong(found, level) <= part.allowed[level] * part.exact.size


def _fastest(name, part, runs, level):
    """Setting and run; None if none meets the bound."""
    mine = [(one, run) for (who, one), run in runs.items() if who == name]
    good = [(one, run) for one, run in mine if _meets(part, run.result, level)]
    return min(good, key=lambda pair: pair[1].seconds, default=None)


def _columns(best, count):
    if best is None:
        return [DASH, DASH]
    setting, run = best
    return [rate(count, run.seconds), ", ".join(f"{v:g}" for v in setting if v < np.inf)]


def answers(problem) -> list[list[str]]:
    """The first and the last trajectory of an ensemble, to check one's own by."""
    return [
        [
            problem.name,
            ", ".join(f"{value:.12g}" for value in problem.q[i]),
            f"{problem.t_end[i]:.12g}",
            f"{problem.exact[i]:.9f}",
        ]
        for i in (0, -1)
    ]


if __name__ == "__main__":
    main()

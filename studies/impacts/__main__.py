"""The tables of README.md: ensembles of small systems with impacts, by several solvers.

./run python -m studies impacts [--small]
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from statistics import median
from time import process_time
from typing import NamedTuple

import numpy as np

from snapmap.files.text import DASH

from ..common import command_device, few, number, take_turns
from ..tables import Table, write
from . import solvers
from .problems import BALL, RIGID, make_ball, make_bilinear, make_oscillator, make_valve

ROUNDS = 3
"""Rounds of which the median counts."""
SOME = slice(4, None, 9)
"""Trajectories, spread over an ensemble, for a solver that is too slow for all."""
LONGEST = (1e-4, 0.1), (1e-6, 0.1), (1e-6, np.inf), (1e-9, np.inf), (1e-12, np.inf)
"""Tolerances and longest steps; two events within a step would remain unseen."""
PLAIN = (0.1,), (0.03,), (0.01,), (0.003,), (0.001,)
STEPS = (500,), (2000,), (8000,), (32_000,), (128_000,)
OURS, SCIPY, PLAIN_LOOP = "snapmap", "SciPy", "plain loop"
HEAD = "problem", "contender", "loose: /s", "setting", "tight: /s", "setting"
CHECKS = "problem", "parameters", "t_end", "x(t_end)"


class Contender(NamedTuple):
    """A solver of an ensemble.

    make: makes it for an ensemble; settings: arguments of its calls
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
    write("impacts", Table("impacts", HEAD, rows), Table("impacts_answers", CHECKS, checks))


def ensembles():
    """Yield the problems whose answers are places."""
    for make in few((make_ball, make_oscillator, make_bilinear, make_valve), 2):
        problem = make()
        if np.isnan(problem.exact).all():
            problem = replace(problem, exact=solvers.by_scipy(problem)(1e-13, np.inf))
        yield problem


def contenders(problem, device) -> dict[str, Contender]:
    """Return the solvers that can follow a problem."""
    able = {
        SCIPY: Contender(solvers.by_scipy, LONGEST, SOME),
        PLAIN_LOOP: Contender(solvers.by_plain_loop, PLAIN),
    }
    if problem.name in (BALL, RIGID):
        able[OURS] = Contender(partial(solvers.by_kernel, device=device), STEPS)
    return able


def measure(problem, of: dict[str, Contender]) -> list[list[str]]:
    """Make a row for each contender, with its fastest setting that meets each bound."""
    tasks, parts = {}, {}
    for name, contender in of.items():
        parts[name] = problem.some(contender.which)
        solve = contender.make(parts[name])
        tasks |= {(name, setting): partial(solve, *setting) for setting in contender.settings}
    first = take_turns(tasks, 1)  # compiles
    meeting = {key: tasks[key] for key in tasks if parts[key[0]].is_met(first[key].result, 0)}
    runs = take_turns(meeting, few(ROUNDS), process_time, median)
    columns = {name: [] for name in of}
    for level in (0, 1):
        for name, part in parts.items():
            columns[name] += _fastest(name, part, runs, level)
    shown = {SCIPY: problem.name}  # by its first row
    return [[shown.get(name, ""), name, *cells] for name, cells in columns.items()]


def _fastest(name, part, runs, level):
    """Write the speed of the fastest setting that meets a bound, and the setting."""
    meeting = {
        setting: run.seconds
        for (who, setting), run in runs.items()
        if who == name and part.is_met(run.result, level)
    }
    if not meeting:
        return [DASH, DASH]
    best = min(meeting, key=meeting.get)
    setting = ", ".join(f"{value:g}" for value in best if value < np.inf)
    return [number(part.exact.size / meeting[best]), setting]


def answers(problem) -> Iterator[list[str]]:
    """Yield rows of the first and the last trajectory of an ensemble, as checks for others."""
    for i in (0, -1):
        *parameters, end = (f"{value:.12g}" for value in (*problem.q[i], problem.t_end[i]))
        yield [problem.name, ", ".join(parameters), end, f"{problem.exact[i]:.9f}"]

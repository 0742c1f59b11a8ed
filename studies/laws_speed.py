"""Speed and error of a user's laws in the kernel, beside SciPy, for docs/own-physics.md.

./run python -m studies laws_speed [--small]

The laws of examples/laws on the handout's device: labels of 500 cells and 20 thresholds, against
SciPy at a tolerance of 1e-9.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

import snapmap
from snapmap.device.device import Device
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.laws import load_laws
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.settings import THRESHOLD_TOLERANCE, Run

from .common import ROOT, asking, command_device, cpu_seconds, few, number, threshold_near
from .peers.equations import equations_of
from .peers.scipy_ivp import by_scipy
from .tables import Table, write

SETTINGS = Run(horizon=300.0, repeat=False).but(until="edge")
CELLS, F0_RANGE, ROWS = (6, 5), (500.0, 10e3), 6
"""Numbers of N and f0; Hz; number of thresholds."""
METHOD, EXACT, USUAL = "DOP853", 1e-9, 1e-6
"""Of `solve_ivp`, and its relative tolerances: of the exact snaps, and of those that are timed."""
AROUND, TOLERANCE = 0.02, 1e-7
"""Relative distance within which thresholds are sought, and how close."""
HEAD = ["law", "C", "cells/s", "SciPy", "times", "times at 1e-4", "other labels"]
HEAD += ["error of N, median", "9 of 10 within", "SciPy, 9 of 10", "over its bar, largest"]
STEPS = (1.0, 0.5, 0.25, 0.125)
"""Steps of the kernel, over its own, in which error and time are measured."""


class Example(NamedTuple):
    """A law, the model that takes it, the model whose equations SciPy solves with it, and C."""

    law: str
    model: type
    peer: Cosines | Elements
    C: float


EXAMPLES = (
    Example("cubic_damping", Elements, Elements(), 3e4),
    Example("squeeze_film", Elements, Elements(), 200.0),
    Example("hertzian_contact", Elements, Elements(), 25.0),
    Example("fixed_mass", Elements, Elements(), 25.0),
    Example("double_well", Cosines, Cosines(modes=1), 25.0),
)


def main():
    device = command_device()
    write("laws_speed", Table("laws_speed", HEAD, [row(device, each) for each in few(EXAMPLES)]))


def row(device: Device, example: Example) -> list[str]:
    """Measure speed and error of a law."""
    laws = load_laws(str(ROOT / "examples" / "laws" / f"{example.law}.py"))
    model = build_model(device, example.model(laws=laws))
    equations = equations_of(build_model(device, example.peer))
    f0, shares = np.geomspace(*F0_RANGE, few(CELLS[1], 2)), np.linspace(0.81, 1.6, few(CELLS[0], 4))
    rows = np.geomspace(*F0_RANGE, few(ROWS, 2)), np.full(few(ROWS, 2), example.C)
    study = snapmap.Study(device, example.model(laws=laws))
    edges = snapmap.threshold(study, rows[0], [example.C]).squeeze("C")
    exact, scipy = (by_scipy(equations, METHOD, tolerance, laws) for tolerance in (EXACT, USUAL))
    ours = [partial(_t_snap, model.with_step(step)) for step in STEPS]
    asks = (asking(device, follow, rows, SETTINGS.horizon) for follow in (exact, scipy, *ours))
    N = [threshold_near(ask, edges.N_first.values, 1 + AROUND, TOLERANCE) for ask in asks]
    off = [abs(each / N[0] - 1) for each in N[1:]]
    N_cells = np.multiply.outer(np.interp(f0, rows[0], N[0]), shares)
    cells = to_cells(device, 0, N_cells, f0[:, np.newaxis], example.C, SETTINGS.horizon).flat()
    tasks = [partial(follow, cells) for follow in (scipy, *ours)]
    each_second = [cells.f0.size / cpu_seconds(task, few(3)) for task in tasks]
    snapped = [np.isfinite(follow(cells)) for follow in (exact, ours[0])]
    wrong = (snapped[1] != snapped[0]).sum()
    over = abs(edges.N_first.values - N[0]) / edges.N_error.values
    median, most = (np.nanpercentile(off, share, axis=1) for share in (50, 90))
    # As errors fall with the steps, the time at an error of THRESHOLD_TOLERANCE lies between.
    logs = np.log(np.maximum(median, TOLERANCE)[:0:-1]), np.log(each_second[:0:-1])
    enough = np.exp(np.interp(np.log(THRESHOLD_TOLERANCE), *logs))
    return [
        f"`{example.law}.py`",
        number(example.C),
        number(each_second[1]),
        number(each_second[0]),
        number(each_second[1] / each_second[0]),
        number(enough / each_second[0]),
        f"{wrong} of {cells.f0.size}",
        f"{median[1]:.0e}",
        f"{most[1]:.0e}",
        f"{most[0]:.0e}",
        f"{np.nanmax(over):.2f}",
    ]


def _t_snap(model: Model, cells: Cells) -> np.ndarray:
    """Return when cells snap, us; NaN if they do not."""
    return model.follow(cells, SETTINGS).t_snap

"""Speed and error of a user's laws in the kernel, beside the plain loop, for docs/own-physics.md.

./run python -m studies laws_speed [--small]

The laws of examples/laws on the handout's device: labels of 500 cells and 20 thresholds, against
the plain loop in a quarter of its step.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

import snapmap
from snapmap.device.device import Device
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.laws import load_laws
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements, Reference
from snapmap.solver.settings import THRESHOLD_TOLERANCE, Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import ROOT, command_device, cpu_seconds, few, number
from .tables import Table, write

SETTINGS = Run(300.0, repeat=False).but(until="edge")
CELLS, F0_RANGE, ROWS = (25, 20), (500.0, 10e3), 20
"""Numbers of N and f0; Hz; number of thresholds."""
FINE, TOLERANCE = 0.25, 1e-7
"""Step of the plain loop over its own, for comparison; tolerance of its thresholds."""
AROUND = 0.02
"""Relative distance within which the plain loop's thresholds are sought."""
HEAD = ["law", "C", "cells/s", "plain loop", "times", "times at 1e-4", "other labels"]
HEAD += ["error of N, median", "9 of 10 within", "plain loop, 9 of 10", "over its bar, largest"]
STEPS = (1.0, 0.5, 0.25, 0.125)
"""Steps of the kernel, over its own, in which error and time are measured."""


class Example(NamedTuple):
    """A law, the model beside `reference`, and C."""

    law: str
    model: type
    C: float


EXAMPLES = (
    Example("cubic_damping", Elements, 3e4),
    Example("squeeze_film", Elements, 200.0),
    Example("hertzian_contact", Elements, 25.0),
    Example("fixed_mass", Elements, 25.0),
    Example("double_well", Cosines, 25.0),
)


def main():
    device = command_device()
    write("laws_speed", Table("laws_speed", HEAD, [row(device, each) for each in few(EXAMPLES)]))


def row(device: Device, example: Example) -> list[str]:
    """Measure speed and error of a law."""
    laws = load_laws(str(ROOT / "examples" / "laws" / f"{example.law}.py"))
    model = build_model(device, example.model(laws=laws))
    plain = build_model(device, Reference(laws=laws))
    exact = plain.with_step(FINE)
    f0, shares = np.geomspace(*F0_RANGE, few(CELLS[1], 2)), np.linspace(0.81, 1.6, few(CELLS[0], 4))
    rows = to_rows(0, np.geomspace(*F0_RANGE, few(ROWS, 2)), example.C)
    study = snapmap.Study(device, example.model(laws=laws))
    edges = snapmap.threshold(study, rows.f0, [example.C]).squeeze("C")
    N = edges.N_first.values
    around = N * (1 - AROUND), N * (1 + AROUND)
    steps = [model.with_step(step) for step in STEPS]
    probes = (Probe(each, rows, SETTINGS) for each in (exact, plain, *steps))
    N = [lowest_snap(probe, around, TOLERANCE, AROUND) for probe in probes]
    off = [abs(each / N[0] - 1) for each in N[1:]]
    N_cells = np.multiply.outer(np.interp(f0, rows.f0, N[0]), shares)
    cells = to_cells(device, 0, N_cells, f0[:, np.newaxis], example.C, SETTINGS.horizon)
    tasks = [partial(each.follow, cells, SETTINGS) for each in (plain, *steps)]
    each_second = [cells.f0.size / cpu_seconds(task, few(3)) for task in tasks]
    snapped = [np.isfinite(each.follow(cells, SETTINGS).t_snap) for each in (exact, model)]
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

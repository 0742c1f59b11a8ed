"""Speed and error of a user's laws in the kernel, beside the plain loop, for docs/own-physics.md.

./run python -m studies laws_speed [--small]

The laws of examples/laws on the handout's device: labels of 500 cells and 20 thresholds, against
the plain loop in a quarter of its step, and snaps against SciPy at a tolerance of 1e-9.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import snapmap
from snapmap.device.device import Device
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.laws import load_laws
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines, Elements, Reference
from snapmap.solver.plain_loop import starting
from snapmap.solver.settings import FIRST, Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import ROOT, command_device, cpu_seconds, few, number
from .tables import Table, write

SETTINGS = Run(horizon=300.0, repeat=False).but(until="edge")
CELLS, F0_RANGE, ROWS = (25, 20), (500.0, 10e3), 20
"""Numbers of N and f0; Hz; number of thresholds."""
FINE, SNAPS, TOLERANCE = 0.25, 5, 1e-7
"""Step of the plain loop over its own, for comparison; cells that SciPy follows; of thresholds."""
AROUND = 0.02
"""Relative distance within which the plain loop's thresholds are sought."""
HEAD = ["law", "C", "cells/s", "plain loop", "times", "at equal error", "other labels"]
HEAD += ["error of N, 9 of 10 within", "plain loop", "over its bar, largest", "off SciPy, us"]
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
    t_snap = [each.follow(cells, SETTINGS).t_snap.ravel() for each in (exact, plain, model)]
    snapped = np.isfinite(t_snap)
    wrong = (snapped[2] != snapped[0]).sum()
    some = np.flatnonzero(snapped.all(axis=0))
    some = some[:: max(1, some.size // few(SNAPS))]
    scipy = np.array([scipy_snap(exact, cells.flat().take([i])) for i in some])
    moved = model.follow(cells.flat().take(some), SETTINGS.but(until="moved")).t_snap
    over = abs(edges.N_first.values - N[0]) / edges.N_error.values
    most = np.array([np.nanpercentile(each, 90) for each in off])
    # As errors fall with the steps, times at equal errors lie between.
    logs = np.log(np.maximum(most, TOLERANCE)[:0:-1]), np.log(each_second[:0:-1])
    equal = np.exp(np.interp(np.log(max(most[0], TOLERANCE)), *logs))
    return [
        f"`{example.law}.py`",
        number(example.C),
        number(each_second[1]),
        number(each_second[0]),
        number(each_second[1] / each_second[0]),
        number(equal / each_second[0]),
        f"{wrong} of {cells.f0.size}",
        f"{most[1]:.0e}",
        f"{most[0]:.0e}",
        f"{np.nanmax(over):.2f}",
        f"{np.nanmax(abs(moved - scipy)):.0e}",
    ]


def scipy_snap(model: Model, cell) -> float:
    """When a cell of a `reference` with laws snaps, us, by SciPy; NaN if it does not."""
    system, laws, n = starting(model, FIRST), model.laws, model.basis.load.size
    damping = laws.damping.py_func if laws.damping else lambda C, v, y: C * v
    contact = laws.contact.py_func if laws.contact else lambda k, s: k * max(0.0, s)
    force, target = laws.force and laws.force.py_func, model.snap_target(FIRST)
    a0, f0, C, end = (column.item() for column in cell[2:6])

    def rate(t, x):
        u, y, v = x[:n], x[n], x[-1]
        a = a0 * (1 - np.cos(2 * np.pi * f0 * t)) / 2 if t < 1 / f0 else 0.0
        w = system.midpoint @ u
        P = contact(float(system.penalty), w - y - system.gap)
        if force:
            hold = system.midpoint * force(-w)
        else:
            slope = system.geometric @ u + system.slope_start
            hold = -system.axial * u @ (slope + system.slope_start) * slope - system.bending @ u
        of_beam = system.inverse_inertia @ (hold - system.load * a - system.midpoint * P)
        of_mass = -a + (P - system.spring * y - damping(C, v, y)) / system.mass
        return np.concatenate([x[n + 1 :], of_beam, [of_mass]])

    def snaps(t, x):
        return system.midpoint @ x[:n] - target

    snaps.terminal = True
    start, tolerance = np.zeros(2 * n + 2), {"rtol": 1e-9, "atol": 1e-9}
    times = solve_ivp(rate, (0, end), start, "DOP853", events=snaps, **tolerance).t_events[0]
    return times[0] if times.size else np.nan

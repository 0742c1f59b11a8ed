"""Shocks followed in the browser, against the kernel."""

import numpy as np
import pytest
from small_results import swept
from varied import varied

from snapmap.applications import page as page_of
from snapmap.applications.page import forms
from snapmap.device.device import ALONE
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import FIRST, SECOND, Run
from snapmap.solver.simd_loop import watch
from snapmap.study.axes import rows_of
from snapmap.study.study import Study

HORIZON = 300.0
NUDGE, MUCH = 1e-12, 20.0
AFTER = 50.0
"""us after a snap, for which runs agree to 1e-6; then the ringing beam makes much of rounding."""
RUN = """({ names, limits, rows, pulses, cells, side, horizon }) => cells.map((cell) => {
    const form = formOf(names, Float64Array.from(rows[cell.device]));
    const known = pulses[cell.pulse];
    const pulse = { ...known, pieces: Float64Array.from(known.pieces) };
    const dt = stepOf(form, pulse, cell, limits);
    const course = follow(form, pulse, cell, horizon, side, dt);
    for (;;) {
        const { done, value } = course.next();
        if (done) return value;
    }
})"""


@pytest.fixture(scope="module")
def alone(browser):
    """`simulate.js` in a page of its own."""
    tab = browser.new_page()
    folder = next(iter(page_of.__path__))
    tab.add_script_tag(path=f"{folder}/simulate.js")
    yield tab
    tab.close()


def follow_both(tab, study, axes, start=FIRST):
    """What the page makes of all cells; of the kernel's runs the steps, and w of each, (steps,).

    Twice: also of shocks that are stronger by NUDGE.
    """
    grid, settings = study.set_out(axes), Run(start=start).but(until="moved")
    rows, N = rows_of(grid), grid.axes["N"]
    cells = rows.cells(grid.device, N, HORIZON).flat()
    columns = {"device": cells.device, "pulse": cells.pulse, "f0": cells.f0}
    columns |= {"N": np.tile(N, rows.C.size), "C": np.repeat(rows.C, N.size)}
    known = [pulse | {"pieces": pulse["pieces"].ravel().tolist()} for pulse in forms.pulses(study)]
    shocks = zip(*(column.tolist() for column in columns.values()), strict=True)
    data = {
        "names": forms.NUMBERS,
        "limits": forms.LIMITS,
        "rows": forms.forms(grid, start).tolist(),
        "pulses": known,
        "cells": [dict(zip(columns, shock, strict=True)) for shock in shocks],
        "side": 1 if start == FIRST else -1,
        "horizon": HORIZON,
    }
    runs = tab.evaluate(RUN, data)
    model = build_model(grid.device, Cosines(modes=forms.COSINES))
    twin = cells._replace(amplitude=cells.amplitude * (1 + NUDGE))
    dt, kernels = np.empty(len(runs)), [[None] * len(runs) for _ in range(2)]
    for members, part in model.split(cells.device):
        at = np.flatnonzero(members)
        dt[at] = part.time_steps(cells.take(at), settings)
        for some in np.split(at, range(LANES, at.size, LANES)):
            steps = np.array([runs[i]["steps"] for i in some])
            for kernel, group in zip(kernels, (cells, twin), strict=True):
                parts = watch(part, group.take(some), dt[some], steps, start)
                w = np.concatenate([w for _, (w, _) in parts])
                for lane, i in enumerate(some):
                    kernel[i] = w[:, lane]
    return runs, dt, *kernels


def bins_of(run, w):
    """The extremes of w in each whole bin of a run, (2, bins)."""
    every, bins = run["every"], run["steps"] // run["every"]
    w = w[: bins * every].reshape(bins, every)
    return np.stack([w.min(axis=1), w.max(axis=1)])


def check(runs, dt, kernel, twin):
    """The page is nearer to the kernel than that is to itself after a nudge."""
    for run, step, w, nudged in zip(runs, dt, kernel, twin, strict=True):
        assert run["dt"] == pytest.approx(step, rel=1e-14) and not run["failed"]
        extremes = bins_of(run, w)
        shown = np.array([run["low"], run["high"]])[:, : extremes.shape[1]]
        ours, theirs = (
            np.maximum.accumulate(abs(other - extremes).max(axis=0)) / abs(w).max()
            for other in (shown, bins_of(run, nudged))
        )
        assert ours[0] < 1e-9 and ((ours < 1e-9) | (ours < MUCH * theirs)).all(), run["snap"]
        ends = (1 + np.arange(ours.size)) * run["every"] * step
        if run["snap"] > 0:
            assert ours[ends <= run["snap"]].max() < 1e-9
            assert ours[ends <= run["snap"] + AFTER].max() < 1e-6


@pytest.mark.parametrize("C", [0.025, 200.0])
def test_shocks_end_as_the_cube_says_and_move_as_the_kernel_does(alone, handout, C):
    """As a cube of the same cosines, whose runs take other steps, does where two of them agree."""
    axes = {"C": [C], "f0": np.geomspace(300, 2e4, 10)[::2], "N": np.linspace(700, 2400, 10)}
    runs, *kernels = follow_both(alone, Study(device=handout), axes)
    check(runs, *kernels)
    cube = swept(handout, **axes, modes=5)
    keys = "snap", "settled", "isAcross"
    snap, settled, across = (np.array([run[key] for run in runs]) for key in keys)
    expected = cube.t_snap.values.ravel()
    assert (np.isfinite(snap) == np.isfinite(expected)).all() and np.isfinite(snap).any()
    assert np.nanmax(abs(snap / expected - 1)) < 0.01
    sure = np.isfinite(cube.t_settled.values.ravel()) & (cube.well_reproduced.values.ravel() == 1)
    assert (
        sure.any()
        and (across == (cube.well.values.ravel() == 2))[sure & np.isfinite(settled)].all()
    )


STOPS = {"stop_toward": 12.0, "stop_away": 2.0, "restitution": 0.6}
TRAIN = {"train": [{"duration": 300.0}, {"wait": 50.0}, {"repeat": 2}]}
TILTING = {"free": 1.0, "imperfection": 0.05, "thickness": 1.4}
STRESSED = {"residual_stress": -8.0, "damping": 4e-3}
VARIANTS = {
    "hard": ({"contact": np.inf}, "sawtooth", "+z", FIRST),
    "gap": ({"gap": 1.0}, "half sine", "both", FIRST),
    "stops": (STOPS, TRAIN, "-z", FIRST),
    "free": (TILTING, "trapezoid", "+z", FIRST),
    "second": ({}, "versed sine", "-z", SECOND),
    "stressed": (STRESSED, "versed sine", "+z", FIRST),
    "beam alone": (ALONE, "half sine", "+z", FIRST),
}
"""Devices unlike the handout's, each with its shocks and the shape in which it starts."""


@pytest.mark.parametrize("name", VARIANTS)
def test_all_that_the_kernel_knows_of_a_device_is_followed(alone, handout, monkeypatch, name):
    monkeypatch.setattr(forms, "COSINES", 2)
    values, pulse, direction, start = VARIANTS[name]
    study = Study(varied(handout, **values), pulse=pulse, direction=direction)
    axes = {"C": [0.025, 50.0], "f0": [700.0, 6000.0], "N": [900.0, 1500.0, 2400.0]}
    *followed, kernel, twin = follow_both(alone, study, axes, start)
    check(*followed, kernel, twin)
    assert max(abs(w).max() for w in kernel) > 1e-3


def test_steps_are_as_short_as_a_hard_strike_from_the_second_shape_needs(alone, handout):
    study = Study(handout, pulse="versed sine", direction="-z")
    axes = {"C": [50.0], "f0": [6000.0], "N": [1000.0, 2e4]}
    runs, dt, *kernels = follow_both(alone, study, axes, SECOND)
    check(runs, dt, *kernels)
    assert dt[1] < 0.9 * dt[0]

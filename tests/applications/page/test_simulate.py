"""Shocks followed in the browser, against the kernel."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_results import swept
from small_studies import cases_of
from varied import varied

from snapmap.applications import page as page_of
from snapmap.applications.histories.history import simulate
from snapmap.applications.page import figure as forms
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import FIRST, SECOND, Run
from snapmap.solver.simd_loop import watch
from snapmap.study.axes import rows_of
from snapmap.study.study import Study

CASES, HORIZON = cases_of(__file__), 300.0
NUDGE, MUCH = 1e-12, 20.0
AFTER = 50.0
"""us after a snap, for which runs agree to 1e-6; then the ringing beam makes much of rounding."""
RUN = Path(__file__).with_name("run.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def alone(browser):
    """`simulate.js` in a page of its own."""
    tab = browser.new_page()
    folder = next(iter(page_of.__path__))
    tab.add_script_tag(path=f"{folder}/simulate.js")
    yield tab
    tab.close()


def follow_both(tab, study, axes, start=FIRST):
    """What the page makes of all cells; of the kernel's runs w of each, (steps,).

    Twice: also of shocks that are stronger by NUDGE.
    """
    grid = study.set_out(axes)
    table, steps = forms.forms(grid, start)
    rows, N = rows_of(grid), grid.axes["N"]
    cells, dt = rows.cells(grid.device, N, HORIZON).flat(), steps.ravel()
    columns = {"device": cells.device, "pulse": cells.pulse, "f0": cells.f0, "end": cells.t_end}
    columns |= {"N": np.tile(N, rows.C.size), "C": np.repeat(rows.C, N.size), "dt": dt}
    known = [pulse | {"pieces": pulse["pieces"].ravel().tolist()} for pulse in forms.pulses(study)]
    shocks = zip(*(column.tolist() for column in columns.values()), strict=True)
    data = {"places": forms.PLACES, "rows": table.tolist(), "pulses": known}
    data["cells"] = [dict(zip(columns, shock, strict=True)) for shock in shocks]
    runs = tab.evaluate(RUN, data)
    model = build_model(grid.device, Cosines(modes=forms.COSINES))
    twin = cells._replace(amplitude=cells.amplitude * (1 + NUDGE))
    kernels = [[None] * len(runs) for _ in range(2)]
    for members, part in model.split(cells.device):
        for some in np.split(at := np.flatnonzero(members), range(LANES, at.size, LANES)):
            steps = np.array([runs[i]["steps"] for i in some])
            for kernel, group in zip(kernels, (cells, twin), strict=True):
                parts = watch(part, group.take(some), dt[some], steps, start)
                w = np.concatenate([w for _, (w, _) in parts])
                for lane, i in enumerate(some):
                    kernel[i] = w[:, lane]
    return runs, *kernels


def bins_of(run, w):
    """The extremes of w in each whole bin of a run, (2, bins)."""
    every, bins = run["every"], run["steps"] // run["every"]
    w = w[: bins * every].reshape(bins, every)
    return np.stack([w.min(axis=1), w.max(axis=1)])


def check(runs, kernel, twin):
    """The page is nearer to the kernel than that is to itself after a nudge."""
    for run, w, nudged in zip(runs, kernel, twin, strict=True):
        assert not run["failed"]
        extremes = bins_of(run, w)
        shown = [[one[key] for one in run["bins"]] for key in ("low", "high")]
        shown = np.array(shown)[:, : extremes.shape[1]]
        ours, theirs = (
            np.maximum.accumulate(abs(other - extremes).max(axis=0)) / abs(w).max()
            for other in (shown, bins_of(run, nudged))
        )
        assert ours[0] < 1e-9 and ((ours < 1e-9) | (ours < MUCH * theirs)).all(), run["snap"]
        ends = (1 + np.arange(ours.size)) * run["every"] * run["dt"]
        if run["snap"] > 0:
            assert ours[ends <= run["snap"]].max() < 1e-9
            assert ours[ends <= run["snap"] + AFTER].max() < 1e-6


@pytest.mark.parametrize("C", [0.025, 200.0])
def test_shocks_end_as_the_cube_says_and_move_as_the_kernel_does(alone, handout, C):
    """As a cube of the same cosines, whose runs take longer steps, does where two of them agree.

    A cube's time of the snap is that of a run to the snap, in steps that serve the label alone; the
    page's, in the steps of a history, is that of steps a quarter as long.
    """
    axes = {"C": [C], "f0": np.geomspace(300, 2e4, 10)[::2], "N": np.linspace(700, 2400, 10)}
    runs, *kernels = follow_both(alone, study := Study(device=handout), axes)
    barrier = forms.forms(study.set_out(axes), FIRST)[0][0, forms.PLACES["BARRIER"]]
    check(runs, *kernels)
    cube = swept(handout, **axes, modes=5)
    snap, across = (np.array([run[key] for run in runs]) for key in ("snap", "isAcross"))
    expected = cube.t_snap.values.ravel()
    assert (np.isfinite(snap) == np.isfinite(expected)).all() and np.isfinite(snap).any()
    cells = rows_of(grid := study.set_out(axes)).cells(grid.device, grid.axes["N"], HORIZON)
    fine = build_model(grid.device, Cosines(modes=forms.COSINES)).with_step(0.25)
    seen = fine.follow(cells, Run(horizon=HORIZON).but(until="moved"))
    np.testing.assert_allclose(snap, seen.t_snap.ravel(), rtol=1e-3)
    sure = np.isfinite(cube.t_settled.values.ravel()) & (cube.well_reproduced.values.ravel() == 1)
    # This one has settled, too.
    sure &= [run["bins"][-1]["energy"] < 0.99 * barrier for run in runs]
    assert sure.any() and (across == (cube.well.values.ravel() == 2))[sure].all()


@pytest.mark.parametrize("variant", CASES)
def test_all_that_the_kernel_knows_of_a_device_is_followed(alone, handout, monkeypatch, variant):
    """Of devices unlike the handout's, each with its shocks and the shape in which it starts."""
    monkeypatch.setattr(forms, "COSINES", 2)
    values, pulse, direction, start = CASES[variant]
    study = Study(varied(handout, **values), pulse=pulse, direction=direction)
    axes = {"C": [0.025, 50.0], "f0": [700.0, 6000.0], "N": [900.0, 1500.0, 2400.0]}
    runs, kernel, twin = follow_both(alone, study, axes, start)
    check(runs, kernel, twin)
    assert max(abs(w).max() for w in kernel) > 1e-3


def test_steps_are_those_of_a_history_and_none_where_no_device_exists(handout):
    """A hard strike from the second shape needs short ones."""
    study = Study(handout, pulse="versed sine", direction="-z", skip=True)
    axes = {"thickness": [2.0, 4.4], "C": [50.0], "f0": [6000.0], "N": [1000.0, 2e4]}
    _, steps = forms.forms(study.set_out(axes), SECOND)
    assert steps.shape == (2, 1, 1, 2) and np.isnan(steps[1]).all()
    settings = Run(horizon=0.0, start=SECOND)
    for N, step in zip(axes["N"], steps[0].ravel(), strict=True):
        run = replace(study, model=Cosines(modes=forms.COSINES), **vars(settings))
        assert simulate(run, N, 6000.0, 50.0).time_step == step
    assert steps[0, ..., 1] < 0.9 * steps[0, ..., 0]

"""The traces of cells, against their histories."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_results import AXES, SETTINGS, swept

import snapmap
from snapmap.applications.page import traces as envelopes
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.trace import SAMPLE
from snapmap.solver.models import build_model
from snapmap.solver.settings import MOVE
from snapmap.study.study import Study

MODEL = {"name": "cosines", "modes": 3}


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


def trace(device, cube, model, settings):
    """The traces of a study of one device."""
    return envelopes.trace(Study(device=device, model=model, settings=settings), cube)


@pytest.fixture(scope="module")
def traced(handout, cube):
    return trace(handout, cube, MODEL, SETTINGS._replace(threads=2))


def test_traces_have_the_largest_stress_of_each_cell(handout, cube, traced):
    found = trace(replace(handout, strength=1500.0), cube, MODEL, SETTINGS)
    xr.testing.assert_equal(found.drop_vars(["stress_max", "strength"]), traced)
    assert found.strength == 1500
    for N in (cube.N[0], cube.N[-1]):
        cell = found.isel(C=0, f0=0).sel(N=N)
        N, f0, C = (cell[key].item() for key in ("N", "f0", "C"))
        run = snapmap.simulate(handout, N, f0, C, model=MODEL, horizon=SETTINGS.horizon)
        shown = run.stress.sel(time=slice(0, found.sizes["bin"] * cell.bin_length.item()))
        assert cell.stress_max.item() == pytest.approx(shown.max().item(), rel=0.05)


def history_of(device, cell):
    """The cell's history at the steps that a trace looks at, and the time between two looks."""
    run = snapmap.simulate(device, **cell, model=MODEL, horizon=SETTINGS.horizon)
    model = build_model(device, **MODEL)
    dt = model.steps.of(to_cells(device, 0, *cell.values(), 0.0), MOVE).item()
    assert float(run.time[1] - run.time[0]) == pytest.approx(dt), "the history leaves out steps"
    return run.isel(time=slice(None, None, SAMPLE)), SAMPLE * dt


@pytest.mark.parametrize(("N", "f0", "C"), [(800.0, 9000.0, 200.0), (2200.0, 1000.0, 0.025)])
def test_traces_are_the_history(handout, traced, monkeypatch, N, f0, C):
    """The band ends at the extremes of each bin."""
    monkeypatch.setattr("snapmap.applications.histories.history.SAMPLES", 10**6)
    run, look = history_of(handout, {"N": N, "f0": f0, "C": C})
    cell = traced.sel(N=N, f0=f0, C=C)
    per_bin = round(float(cell.bin_length) / look)
    bins = min(cell.sizes["bin"], run.sizes["time"] // per_bin)
    w = run.w_mid.values[: bins * per_bin].reshape(bins, per_bin)
    exact = {"rtol": 1e-6, "atol": 1e-6}
    np.testing.assert_allclose(cell.w_low[:bins], w.min(axis=1), **exact)
    np.testing.assert_allclose(cell.w_high[:bins], w.max(axis=1), **exact)
    starts = run.isel(time=slice(0, bins * per_bin, per_bin))
    np.testing.assert_allclose(cell.z_mass[:bins], starts.z_mass, **exact)
    stored = ("kinetic", "spring", "bending", "axial", "contact")
    energy = sum(starts[f"{kind}_energy"] for kind in stored) / run.attrs["barrier"]
    energy = np.minimum(energy.values, envelopes.ENERGY_REACH)
    np.testing.assert_allclose(cell.energy[:bins], energy, rtol=1e-6, atol=1e-6)
    assert (cell.beam_energy <= cell.energy).all()


def test_traces_are_the_sweeps_runs(handout, fix_step):
    """They snap when the cube says, with one step for all that is asked."""
    fix_step(0.5)
    cube = swept(handout, N=np.linspace(600, 2400, 12), f0=np.geomspace(100, 3e4, 12))
    traced = trace(handout, cube, MODEL, SETTINGS)
    snapped, w_2 = cube.t_snap.notnull(), handout.beam.second_equilibrium
    assert ((traced.w_low <= w_2).any("bin") == snapped).all()
    bin_of_snap = np.floor(cube.t_snap / traced.bin_length)
    assert not ((traced.bin < bin_of_snap) & (traced.w_low <= w_2)).any()
    soon = traced.bin <= bin_of_snap + 1
    assert ((soon & (traced.w_low <= w_2)).any("bin") == snapped).all()


def test_traces_do_not_depend_on_threads_or_order(handout, cube, traced):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    again = trace(handout, mixed, MODEL, SETTINGS)
    xr.testing.assert_equal(again, traced)


def test_devices_are_traced_as_each_alone(handout):
    """Also those of two kinds of model, with a contact that is hard and one that is not."""
    model = {**MODEL, "cosines": 4}
    points, asked = {"thickness": [1.8, 4.4], "contact": [40.0, np.inf]}, {**AXES, "cosines": 4}
    whole = trace(handout, swept(handout, **asked, **points, skip=True), model, SETTINGS)
    for contact in points["contact"]:
        device = replace(handout, beam=replace(handout.beam, thickness=1.8), contact=contact)
        alone = trace(device, swept(device, **asked), model, SETTINGS)
        there = whole.sel(thickness=1.8, contact=contact)
        for key in ("second_equilibrium", "bin_length", *envelopes.BANDS):
            np.testing.assert_array_equal(there[key], alone[key])
    assert whole.sel(thickness=4.4).energy.isnull().all()

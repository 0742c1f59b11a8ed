"""The traces of cells, against their histories."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import snapmap
from snapmap.io.netcdf import read_earlier, write
from snapmap.motion import envelopes
from snapmap.solver.adaptive import Adaptive
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.trace import SAMPLE
from snapmap.solver.models import build_model
from snapmap.solver.outcome import OUTCOMES
from snapmap.solver.settings import MOVE, Settings
from snapmap.study import Study

MODEL = {"name": "cosines", "modes": 3}
SETTINGS = Settings(horizon=300.0)
AXES = {"C": [0.025, 200.0], "f0": [1000.0, 3000.0, 9000.0], "N": [800.0, 1000.0, 1300.0, 2200.0]}


def swept(device, **changes):
    asked = {**AXES, "model": "cosines", "modes": 3, "horizon": SETTINGS.horizon, **changes}
    return snapmap.sweep(device, **asked)


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


def trace(device, cube, model, settings, earlier=None):
    """The traces of a study of one device."""
    study = Study(device=device, model=model, settings=settings)
    return envelopes.trace(study, cube, earlier)


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


def steps_of(model, N, f0, C):
    """The steps in which motions are followed, us; the axes broadcast."""
    return model.steps.of(to_cells(model.device, 0, N, f0, C, 0.0), MOVE)


def history_of(device, cell):
    """The cell's history at the steps that a trace looks at, and the time between two looks."""
    run = snapmap.simulate(device, **cell, model="cosines", modes=3, horizon=SETTINGS.horizon)
    dt = steps_of(build_model(device, "cosines", modes=3), **cell).item()
    assert float(run.time[1] - run.time[0]) == pytest.approx(dt), "the history leaves out steps"
    return run.isel(time=slice(None, None, SAMPLE)), SAMPLE * dt


@pytest.mark.parametrize(("N", "f0", "C"), [(800.0, 9000.0, 200.0), (2200.0, 1000.0, 0.025)])
def test_traces_are_the_history(handout, traced, monkeypatch, N, f0, C):
    """The band ends at the extremes of each bin."""
    monkeypatch.setattr("snapmap.motion.history.SAMPLES", 10**6)
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


def test_traces_are_the_sweeps_runs(handout):
    """They snap when the cube says, with one step for all that is asked."""
    N, f0, step = np.linspace(600, 2400, 12), np.geomspace(100, 3e4, 12), {"step": 0.5}
    cube = swept(handout, N=N, f0=f0, **step)
    traced = trace(handout, cube, MODEL | step, SETTINGS)
    snapped, w_2 = cube.t_snap.notnull(), handout.beam.second_equilibrium
    assert ((traced.w_low <= w_2).any("bin") == snapped).all()
    bin_of_snap = np.floor(cube.t_snap / traced.bin_length)
    assert not ((traced.bin < bin_of_snap) & (traced.w_low <= w_2)).any()
    soon = traced.bin <= bin_of_snap + 1
    assert ((soon & (traced.w_low <= w_2)).any("bin") == snapped).all()


def test_traces_show_the_proofs(cube, traced):
    """What is proven by all its energy ends below the saddle, and all that is proven is shown.

    Traces have steps of their own, in which a cell may end elsewhere if it does so in other steps.
    """
    outcome = cube.outcome.copy(data=np.array(OUTCOMES)[cube.outcome.values])
    proven = outcome.isin(["never", "returned"]) & (cube.reproduced == 1)
    assert proven.any() and (traced.energy.isel(bin=-1) < 1).where(proven, True).all()
    shown = traced.bin_length * traced.sizes["bin"]
    assert (shown >= 1e6 / cube.f0).all() and (shown >= cube.t_settled.fillna(0)).all()


def test_traces_end_where_the_sweep_did(handout):
    """A sweep that ends at the snap has proven its step good enough up to there, not beyond."""
    cube = swept(handout, until="snap")
    traced = trace(handout, cube, MODEL, SETTINGS._replace(until="snap"))
    shown = (traced.bin_length * traced.sizes["bin"]).where(cube.t_snap.notnull())
    assert shown.notnull().any() and (shown >= cube.t_snap).where(shown.notnull(), True).all()
    dt = build_model(handout, **MODEL).steps.longest[MOVE].item()
    look = SAMPLE * dt * traced.sizes["bin"]
    assert (shown - cube.t_snap).max() <= look
    # At the step of a trace the snap may come a bin later than in the sweep.
    second = traced.second_equilibrium
    left = (traced.w_low.min("bin") - second) / (handout.beam.rise - second)
    assert left.where(cube.t_snap.notnull()).max() < 0.05


def test_traces_do_not_depend_on_threads_or_order(handout, cube, traced):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    again = trace(handout, mixed, MODEL, SETTINGS)
    xr.testing.assert_equal(again, traced)


def test_a_large_grid_is_thinned_by_whole_strides(cube):
    axes = {"C": np.arange(5.0), "f0": np.arange(1.0, 211), "N": np.arange(301.0)}
    large = xr.Dataset({"outcome": (tuple(axes), np.zeros((5, 210, 301), np.int8))}, axes)
    thinned = envelopes.thin(large)
    assert np.unique(np.diff(thinned.f0)).size == np.unique(np.diff(thinned.N)).size == 1
    assert thinned.sizes["C"] == 5 and envelopes.CELLS / 2 < thinned.outcome.size <= envelopes.CELLS
    assert envelopes.thin(cube).sizes == cube.sizes


def test_a_failed_cell_is_kept_as_far_as_numbers_go(handout):
    """What blew up, or is beyond the largest numbers, has no trace."""
    failed = swept(handout, N=[800.0, 2200.0, 1e200], f0=[1000.0], C=[0.025])
    assert failed.outcome.values.ravel()[-1] == OUTCOMES.index("failed")
    found = trace(handout, failed, MODEL, SETTINGS)
    last = found.isel(N=-1)
    assert not last.isel(bin=0).energy.isnull()
    assert last.energy.isnull().any()
    assert float(abs(found.w_low).max()) <= 1.001 * envelopes.MOST


def test_an_adaptive_cell_is_traced_by_the_level_that_decided(handout, cube, monkeypatch):
    models = [{**MODEL, "step": step} for step in (0.5, 0.3)]

    def choose_model(device, model):
        base, top = (build_model(device, **one) for one in models)
        is_auto = model["name"] == "auto"
        return Adaptive(base, top, top) if is_auto else build_model(device, **model)

    monkeypatch.setattr(envelopes, "choose_model", choose_model)
    level = (cube.N > 900).astype(np.int8).broadcast_like(cube.outcome)
    found = trace(handout, cube.assign(level=level), {"name": "auto"}, SETTINGS)
    alone = [trace(handout, cube, model, SETTINGS).bin_length for model in models]
    assert (alone[0] != alone[1]).any()
    xr.testing.assert_equal(found.bin_length, xr.where(level == 0, *alone))


def test_devices_are_traced_as_each_alone(handout):
    """Also those of two kinds of model, with a contact that is hard and one that is not."""
    model = {**MODEL, "cosines": 4}
    asked = {**AXES, **model, "model": model["name"], "horizon": SETTINGS.horizon}
    del asked["name"]
    points = {"thickness": [1.8, 4.4], "contact": [40.0, np.inf]}
    cube = snapmap.sweep(handout, **asked, **points, skip=True)
    traced = trace(handout, cube, model, SETTINGS)
    assert traced.second_equilibrium.dims == ("thickness", "contact")
    for contact in points["contact"]:
        thin = replace(handout.beam, thickness=1.8)
        device = replace(handout, beam=thin, contact=contact)
        own = snapmap.sweep(device, **asked)
        alone = trace(device, own, model, SETTINGS)
        there = traced.sel(thickness=1.8, contact=contact)
        assert float(there.second_equilibrium) == device.beam.second_equilibrium
        np.testing.assert_array_equal(there.bin_length, alone.bin_length)
        for key in envelopes.BANDS:
            np.testing.assert_array_equal(there[key], alone[key])
    absent = traced.sel(thickness=4.4)
    assert absent.energy.isnull().all() and absent.second_equilibrium.isnull().all()


def test_what_follows_the_horizon_spoils_no_range(handout, cube, traced, monkeypatch):
    """Bins go on beyond it, where a run that was believed may blow up."""
    follow = envelopes._follow

    def blow_up(model, cells, window, bins, threads):
        values, bin_length, stress = follow(model, cells, window, bins, threads)
        begins = np.arange(bins)[:, np.newaxis] * bin_length
        values[:, begins > window] = 1e280
        assert (begins > window).any()
        return values, bin_length, stress

    monkeypatch.setattr(envelopes, "_follow", blow_up)
    found = trace(handout, cube, MODEL, SETTINGS)
    for key in ("w_high", "z_mass", "energy"):
        np.testing.assert_array_equal(found[key].max("bin") <= traced[key].max("bin"), True)


def test_traces_that_grow_are_those_followed_at_once(handout, cube, traced, tmp_path, monkeypatch):
    """As files: what is kept of a number does not hang on how often it was written."""
    part = trace(handout, cube.isel(f0=[0, 2], C=[1]), MODEL, SETTINGS)
    write(part, tmp_path / "part.nc")
    write(traced, tmp_path / "whole.nc")
    follow, followed = envelopes._follow, []

    def counted(model, cells, *asked):
        followed.append(cells.f0.size)
        return follow(model, cells, *asked)

    monkeypatch.setattr(envelopes, "_follow", counted)
    grown = trace(handout, cube, MODEL, SETTINGS, earlier=read_earlier(tmp_path / "part.nc"))
    assert sum(followed) == cube.outcome.size - 8
    write(grown, tmp_path / "grown.nc")
    with (
        xr.open_dataset(tmp_path / "grown.nc") as one,
        xr.open_dataset(tmp_path / "whole.nc") as other,
    ):
        xr.testing.assert_identical(one, other)


def test_the_reference_is_traced_by_its_elements_in_modes(handout, cube):
    model = {"name": "reference", "elements": 2}
    as_reference = trace(handout, cube, model, SETTINGS)
    as_handout = trace(handout, cube, {**model, "name": "handout"}, SETTINGS)
    xr.testing.assert_equal(as_reference, as_handout)


def test_weak_shocks_are_traced_without_steps(handout, tmp_path):
    """A thousandth of the usual shock, too, has as many steps as the page can show."""
    weak = swept(handout, N=[1.0], f0=[3000.0], C=[25.0])
    write(trace(handout, weak, MODEL, SETTINGS), tmp_path / "traces.nc")
    with xr.open_dataset(tmp_path / "traces.nc") as kept:
        for key in ("w_low", "w_high", "z_mass"):
            values = np.unique(kept[key].values[np.isfinite(kept[key].values)])
            assert np.diff(values).min() < np.ptp(values) / 50

"""Runs that start in the second shape: exact facts, other integrators, what is proven and told."""

import json

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp
from varied import alone, varied

import snapmap
from snapmap.applications.datasheet.datasheet import reset_force
from snapmap.applications.requirements import shocks_of
from snapmap.applications.requirements.check import check
from snapmap.applications.whole import load_config
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import batch
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.study.shock import Shock
from snapmap.study.study import Study
from studies.peers.equations import equations_of
from studies.peers.scipy_ivp import compile_rate

BACK = {"start": "second", "direction": "-z"}
CHEAP = {"model": "3 cosines"}


def test_a_buckled_straight_beam_is_its_own_mirror_image(handout):
    """Both shapes are alike: back along -z is there along +z, to the rise of 1e-8 that it has."""
    device = alone(handout, rise=0.0, residual_stress=-60.0, damping=2e-2)
    grid, asked = (np.linspace(0.0, 1.5e5, 16), [2e4], [0.0]), CHEAP | {"horizon": 300.0}
    there, back = (snapmap.sweep(Study(device, **asked, **each), *grid) for each in ({}, BACK))
    assert len(np.unique(there.outcome)) > 2
    np.testing.assert_array_equal(back.outcome, there.outcome)
    np.testing.assert_array_equal(back.well, 3 - there.well)
    np.testing.assert_allclose(back.t_snap, there.t_snap, rtol=1e-6)
    np.testing.assert_allclose(back.pulse_work, there.pulse_work, rtol=1e-5, atol=1e-9)


@pytest.mark.equation(21)
def test_the_reset_force_is_the_closed_form(handout):
    """docs/theory.md, statics: the least root of a quadratic; the bar tells how far it is off."""
    n, beam = np.arange(3, 4001, 2), handout.beam
    curve = np.sum(1 / (n**2 * (n**2 - 4.0) ** 2))
    least = min(np.roots([1 / 9 + curve, -2 / 9, 1 / 9 - 1 + 16 / 3 / beam.bistability**2]))
    exact = -least * 2 * np.pi**4 * beam.stiffness_unit * beam.rise
    force, error = reset_force(beam)
    assert 0 < error < 1e-6 * force and force == pytest.approx(exact, abs=2 * error)


def test_the_models_snap_from_the_second_shape_when_scipy_says(handout):
    """With its mass, by the beam's own inertia: -z from the second shape."""
    model = build_model(handout, Cosines(modes=3)).with_step(0.25)
    N, (rate, w) = 5.5e4, compile_rate(equations_of(model))
    start, shock = np.append(model.second.modes, np.zeros(5)), (-N * handout.gravity, 2e-2, 25.0)
    snap = {"args": shock, "events": lambda t, x, *_: w(x)}
    run = solve_ivp(rate, (0, 50), start, "DOP853", rtol=1e-9, atol=1e-9, **snap)
    cells = to_rows(0, 2e4, 25.0).cells(handout, -N, 0.0)
    seen = model.follow(cells, Run(horizon=0.0, until="snap", start="second"))
    assert seen.t_snap.item() == pytest.approx(run.t_events[0][0], rel=1e-5)
    models = [{"name": name, "elements": 3} for name in ("elements", "reference")]
    studies = (Study(handout, model, until="snap", **BACK) for model in models)
    fast, slow = (snapmap.sweep(study, [N], [2e4], [25.0]) for study in studies)
    assert slow.t_snap.item() == pytest.approx(fast.t_snap.item(), rel=1e-3)


def test_the_ledger_closes_from_the_energy_of_the_second_shape(handout):
    device = varied(handout, stop_away=30.0, damping=4e-4)
    run = snapmap.simulate(Study(device, **CHEAP, **BACK), 6e4, 2e4, 25.0)
    parts = ("kinetic", "spring", "bending", "axial", "contact", "dissipated")
    kept = sum(run[f"{part}_energy"] for part in parts) - run.pulse_work
    depth = build_model(device, Cosines(modes=3)).second.energy
    assert depth == pytest.approx(385.96, abs=0.01)
    assert abs(kept - depth).max() < 1e-9 * run.pulse_work.max()
    assert run.w_mid.max() > run.first_equilibrium == device.beam.rise
    # An electrode that the second shape touches opens as the beam leaves, and is closed till then.
    run = snapmap.simulate(Study(varied(device, contact_at=-7.0), **CHEAP, **BACK), 6e4, 2e4, 25.0)
    rising = run.isel(time=slice(run.w_mid.values.argmax()))
    leaves = np.interp(-7.0, rising.w_mid, rising.time)
    assert run.t_closed == 0 and run.closed_for == pytest.approx(leaves, abs=0.01)


def test_what_is_proven_holds_for_longer_runs(handout):
    """Wells swapped: `never` stays in the second shape, `latched` in the first."""
    device = varied(handout, stop_away=6.0, damping=4e-3)
    grid = np.geomspace(1e3, 1.5e5, 16), [3e3, 2e4], [25.0, 500.0]
    asked = CHEAP | {"start": "second", "direction": "both"}
    cube, longer = (snapmap.sweep(Study(device, horizon=h, **asked), *grid) for h in (3e3, 6e3))
    never, latched, returned = (cube.outcome == code for code in (1, 3, 4))
    assert never.any() and latched.any()
    proven = (never | latched | returned).values
    np.testing.assert_array_equal(longer.outcome.values[proven], cube.outcome.values[proven])
    assert (cube.well == 2).where(never | returned, True).all()
    assert (cube.well == 1).where(latched, True).all()


def test_nothing_snaps_back_below_the_bound_and_results_name_their_start(handout):
    device = alone(handout, 1.0, damping=4e-3)
    edges = snapmap.threshold(Study(device, **CHEAP, **BACK), [2e4, 2e5], [0.0])
    assert (edges.N_bound < edges.N_first).all()
    assert edges.N_static.item() == pytest.approx(reset_force(device.beam)[0], rel=1e-6)
    there = snapmap.threshold(Study(device, direction="-z", **CHEAP), [2e4], [0.0])
    assert json.loads(edges.attrs["config"])["run"]["start"] == "second"
    assert "start" not in json.loads(there.attrs["config"])["run"]
    shock = {"shocks": make_shocks(direction="-z"), "f0": 2e4, "snaps": "arrives", "N": 45.0}
    study = Study(device=device, model={"name": "cosines", "modes": 3})
    asked = [Shock(name=name, start=name, **shock) for name in ("first", "second")]
    assert [line.verdict for line in check(study, asked, [0.0])] == ["failed", "met"]


def test_the_energy_above_the_second_shape_is_within_both_bounds(handout):
    """solver/bounds.py: while the beam is in that well; of a pulse of area 1/2 and variation 2."""
    for device in (handout, alone(handout)):
        run = snapmap.simulate(Study(device, horizon=0.0, **CHEAP, **BACK), 4e4, 2e4, 0.0)
        assert run.w_mid.max() < run.second_equilibrium + 6  # before the saddle
        gained, peak = run.pulse_work.max().item(), 4e4 * device.gravity
        speed, weight = peak / (2 * 2e-2), device.mass + device.beam.weight
        assert 0 < gained < weight / 2 * speed**2
        model = build_model(batch([device]), Cosines(modes=3))
        depth = (model.barrier.energy - model.second.energy).item()
        fast, slow = least_amplitudes(model, to_rows(0, [2e4, 1.0], 0.0), "second")
        assert fast == pytest.approx(np.sqrt(2 * depth / weight) * 4e-2 / device.gravity, rel=1e-6)
        assert 0 < slow < static_threshold(device, back=True)


def test_a_requirement_begins_where_it_says_or_its_study_does(root):
    whole = yaml.safe_load((root / "config" / "sensor.yaml").read_text(encoding="utf-8"))
    shock = {"N": 1000, "f0": "2 kHz", "snaps": True}
    whole["requirements"] = [{"name": "a", **shock, "start": "second"}, {"name": "b", **shock}]
    assert [shock.start for shock in shocks_of(load_config(whole))] == ["second", "first"]
    whole["run"] = {"start": "second"}
    study = load_config(whole)
    assert study.run.start == study.of_thresholds().run.start == "second"
    whole["run"] = {"start": "third"}
    with pytest.raises(ValueError, match="start: 'third' is not"):
        load_config(whole)

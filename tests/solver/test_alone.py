"""A beam that no mass meets: shaken, or pushed at its midpoint."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import snapmap
from snapmap.beam.equilibria import static_threshold
from snapmap.device import ALONE
from snapmap.pulse import Pulse
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings

F0 = 20_000.0
MODELS = "reference", "handout"
STEP = Pulse("step", np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]]))


def alone(device, force=0.0, **beam):
    return replace(device, **ALONE, force=force, beam=replace(device.beam, **beam))


def short_of_the_snap(model, N):
    """How far a run of N stays from the second shape to the end of its pulse, um; by scipy."""
    modal, k = model.modal, model.modes

    def rate(t, x):
        p, slope = x[:k], modal.geometric @ x[:k] + modal.slope_start
        force = -modal.axial * p @ (slope + modal.slope_start)
        a = N * model.device.gravity * np.sin(np.pi * F0 * 1e-6 * t) ** 2
        return np.append(x[k:], force * slope - modal.stiffness * p - modal.load * a)

    lasts = 1e6 / F0
    how = {"rtol": 1e-9, "atol": 1e-9, "dense_output": True}
    run = solve_ivp(rate, (0, lasts), np.zeros(2 * k), "DOP853", **how)
    w = modal.midpoint @ run.sol(np.linspace(0, lasts, 2001))[:k]
    return w.min() - (model.barrier.second - model.barrier.first)


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_the_threshold_is_that_of_another_integrator(handout, force):
    device = alone(handout, force)
    model = build_model(device, "cosines", modes=3, step=0.05)
    near = 1.3 * static_threshold(device)
    rows, around = to_rows(0, F0, 0.0), (0.5 * near, 2 * near)
    ours = lowest_snap(model, rows, around, Settings(0.0), 1e-8).item()
    ends = 0.999 * ours, 1.001 * ours
    theirs = brentq(lambda N: short_of_the_snap(model, N), *ends, xtol=1e-6 * ours)
    assert ours == pytest.approx(theirs, rel=1e-5)


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_slow_pulses_tend_to_the_static_threshold(handout, force):
    """With tilt: of a perfect guided beam under a force nothing wakes the second mode but time."""
    device = alone(handout, force, damping=4e-3, free=1.0, imperfection=0.05)
    found = snapmap.threshold(device, [500.0], [0.0], model="cosines", modes=3, horizon=0.0)
    assert found.N_first.item() == pytest.approx(static_threshold(device), rel=2e-3)
    assert found.N_static == static_threshold(device) and found.N_bound < found.N_first


def test_the_plain_loop_is_pushed_by_the_same_force(handout):
    device, given = alone(handout, 1.0), {"N": 60.0, "f0": F0, "C": 0.0}
    moved = [snapmap.simulate(device, **given, model=name).w_mid for name in MODELS]
    oracle, fast = ((w.max() - w.min()).item() for w in moved)
    assert oracle > 1.0 and fast == pytest.approx(oracle, rel=1e-4)


def test_static_thresholds_are_the_largest_force_and_that_of_a_mass_far_away(handout):
    assert static_threshold(alone(handout)) == static_threshold(replace(handout, gap=1e4))
    tilts = alone(handout, 1.0, free=1.0, imperfection=0.01)
    for device in (alone(handout, 1.0), tilts):
        force = snapmap.statics(device).largest_force
        assert static_threshold(device) == pytest.approx(force, rel=1e-4)


BOUNDS = {5: 318.6, 6: 326.853, 8: 336.005, 12: 343.351, 20: 347.465}


def test_a_step_below_the_energy_of_the_tilted_saddle_never_snaps(handout):
    """Proven: a force F held from rest on gives the beam F w at most, and the saddle takes more."""
    for Q, bound in BOUNDS.items():
        thickness = handout.beam.rise / Q
        made = {"free": 1.0, "thickness": thickness, "imperfection": 1e-4 * thickness}
        unit = alone(handout, **made).beam
        device = alone(handout, unit.stiffness_unit * unit.rise, **made)
        N = bound * np.array([0.6, 0.9, 0.97, 0.999, 1.3])
        shock = {"pulse": STEP, "until": "snap", "horizon": 0.0}
        cube = snapmap.sweep(device, N, [500.0], [0.0], model="cosines", modes=4, **shock)
        assert np.isnan(cube.t_snap.values.ravel()).tolist() == [True] * 4 + [False]


def test_nothing_depends_on_the_mass(handout):
    """No C, spring or contact alters a bit, and both loops agree."""
    asked = {"model": "cosines", "modes": 3, "until": "settled", "horizon": 300.0}
    device = alone(handout, damping=4e-3)
    N = np.array([1e5, 1.3e5, 1.4e5])
    first = snapmap.sweep(device, N, [F0], [0.0, 25.0], **asked)
    other = snapmap.sweep(replace(device, spring=9.0, contact=7.0), N, [F0], [0.0], **asked)
    for key in ("t_snap", "t_settled", "pulse_work", "outcome"):
        np.testing.assert_array_equal(first[key][0], first[key][1])
        np.testing.assert_allclose(first[key][0], other[key][0], rtol=1e-10)
    slow = snapmap.sweep(device, N, [F0], [0.0], model="reference")
    np.testing.assert_allclose(first.t_snap[0], slow.t_snap[0], rtol=1e-2)


def test_a_history_has_the_beam_alone(handout):
    run = snapmap.simulate(alone(handout, 1.0), 60.0, F0, 0.0, model="cosines", modes=3)
    assert run.z_mass.isnull().all() and run.midpoint_force.max() == pytest.approx(60.0, rel=1e-4)
    assert not run[["contact_force", "spring_energy", "contact_energy"]].to_array().any()
    assert "acceleration" not in run
    kept = run.kinetic_energy + run.bending_energy + run.axial_energy - run.pulse_work
    assert abs(kept).max() < 1e-3 * run.pulse_work.max()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"mass": 0.0}, "device.mass: 0.0 is not a number above 0 ng"),
        ({"gap": math.inf}, "device.gap: inf is not a number from 0 um"),
        ({"force": 1.0}, "device.force: 1 uN is of a beam alone; write mass: none"),
        ({**ALONE, "stop_away": 5.0}, "device.stops: are of a mass"),
    ],
)
def test_what_cannot_be_is_said(handout, values, said):
    with pytest.raises(ValueError, match=f"^{said}"):
        replace(handout, **values)

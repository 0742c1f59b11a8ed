"""Other units of length, mass and time, and samples more than are needed, change no result."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import snapmap
from snapmap.beam.equilibria import static_threshold
from snapmap.pulse import make_pulse, sampled
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings

FACTORS = st.floats(0.01, 100.0)
MODEL = {"model": "cosines", "modes": 3}


def scaled(device, length, mass, time):
    """A similar device: every value multiplied by the power of its unit."""
    stiffness = mass / time**2
    factors = dict.fromkeys(("span", "rise", "thickness", "depth", "imperfection"), length)
    factors |= dict.fromkeys(("youngs_modulus", "residual_stress"), stiffness / length)
    factors |= {"density": mass / length**3, "damping": 1 / time}
    beam = {key: factor * getattr(device.beam, key) for key, factor in factors.items()}
    factors = dict.fromkeys(("spring", "contact"), stiffness) | {"gap": length, "mass": mass}
    factors["gravity"] = length / time**2
    rest = {key: factor * getattr(device, key) for key, factor in factors.items()}
    return replace(device, **rest, beam=replace(device.beam, **beam))


@pytest.fixture(scope="module")
def device(handout):
    """One with a gap, residual stress and a damped beam."""
    beam = replace(handout.beam, residual_stress=-8.0, damping=4e-3)
    return replace(handout, beam=beam, gap=0.5)


def shocks(_, mass, time):
    axes = {"f0": np.array([400.0, 1500.0]) / time, "C": [200.0 * mass / time]}
    return {**axes, **MODEL, "horizon": 1500.0 * time}


@settings(max_examples=5, deadline=None, derandomize=True, phases=[Phase.generate])
@given(st.tuples(FACTORS, FACTORS, FACTORS))
def test_similar_devices_answer_alike(device, factors):
    asked = {"N": [600.0, 900.0, 1300.0, 1800.0]}
    own = snapmap.sweep(device, **shocks(1, 1, 1), **asked)
    found = snapmap.sweep(scaled(device, *factors), **shocks(*factors), **asked)
    assert 0 < own.t_snap.notnull().sum() < own.t_snap.size
    np.testing.assert_array_equal(found.outcome, own.outcome)
    for key in {"t_snap", "t_settled"} & set(own):
        np.testing.assert_allclose(found[key] / factors[2], own[key], rtol=1e-12)


def test_similar_devices_have_one_threshold(device):
    factors = 3.0, 0.2, 7.0
    one, other = (
        snapmap.threshold(scaled(device, *each), **shocks(*each)) for each in ((1, 1, 1), factors)
    )
    for key in ("N_first", "N_always", "N_static", "N_bound"):
        np.testing.assert_allclose(other[key], one[key], rtol=1e-12)
    # At its threshold the time of a snap magnifies what rounding does to N.
    np.testing.assert_allclose(other.t_snap / factors[2], one.t_snap, rtol=1e-10)


@pytest.mark.parametrize(("key", "low", "high"), [("thickness", 1.0, 4.0), ("rise", 5.0, 30.0)])
@pytest.mark.parametrize("change", [{}, {"contact": np.inf}, {"spring": 1.0}, {"spring": 20.0}])
def test_thicker_and_higher_beams_need_more(handout, change, key, low, high):
    device = replace(handout, **change)
    beams = (replace(device.beam, **{key: value}) for value in np.linspace(low, high, 7))
    found = [static_threshold(replace(device, beam=beam)) for beam in beams]
    assert (np.diff(found) > 0).all()


def test_thresholds_of_many_swings_are_those_of_a_quarter_of_the_step(handout):
    """Each swing needs its own steps: with those of one, N is wrong by 0.1 % and more."""
    x = np.linspace(0, 1, 1601)
    beats = sampled(500 * x, np.sin(np.pi * x) ** 2 * (1 - np.cos(32 * np.pi * x)) / 2)
    assert beats.variation > 15
    model = build_model(handout, "cosines", modes=4)
    rows = to_rows(0, [1000.0, 2000.0], [[0.025], [200.0]], pulses=(beats,))
    asked = Settings(300.0, until="snap")
    bracket = tuple(np.array([0.5, 6.0]) * static_threshold(handout))
    found, fine = (
        lowest_snap(one, rows, bracket, asked, 1e-5) for one in (model, model.with_step(0.25))
    )
    np.testing.assert_allclose(found, fine, rtol=2e-4)


def test_samples_on_straight_lines_change_nothing(handout):
    """Many of them within one step, and many steps within one of the others."""
    pulse, x = make_pulse("trapezoid"), np.linspace(0, 1, 5001)
    record = sampled(500 * x, pulse.at(x))
    model = build_model(handout, "cosines", modes=3)
    cells = to_cells(handout, 0, np.linspace(800, 2000, 8), [[800.0], [5000.0]], 200.0, 300.0)
    few, many = (
        model.follow(cells._replace(pulses=(one,)), Settings(300.0, until="snap"))
        for one in (pulse, record)
    )
    assert np.isfinite(few.t_snap).any() and np.isnan(few.t_snap).any()
    np.testing.assert_allclose(many.t_snap, few.t_snap, rtol=1e-9)

"""Other units of length, mass and time, and samples more than are needed, change no result."""

from dataclasses import replace

import numpy as np
import pytest

import snapmap
from snapmap.beam.limit_loads import static_threshold
from snapmap.pulse.pulse import sampled
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import lowest_snap


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


@pytest.mark.parametrize("factors", [(3.0, 0.2, 7.0), (0.02, 50.0, 0.3)])
def test_similar_devices_answer_alike(device, factors):
    def ask(verb, length, mass, time, **values):
        rows = {"f0": np.array([400.0, 1500.0]) / time, "C": [200.0 * mass / time], **values}
        how = {"model": "cosines", "modes": 3, "horizon": 1500.0 * time}
        return verb(scaled(device, length, mass, time), **rows, **how)

    N = [600.0, 900.0, 1300.0, 1800.0]
    own, found = (ask(snapmap.sweep, *each, N=N) for each in ((1, 1, 1), factors))
    assert 0 < own.t_snap.notnull().sum() < own.t_snap.size
    np.testing.assert_array_equal(found.outcome, own.outcome)
    for key in ("t_snap", "t_settled"):
        np.testing.assert_allclose(found[key] / factors[2], own[key], rtol=1e-12)
    one, other = (ask(snapmap.threshold, *each) for each in ((1, 1, 1), factors))
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
    model = build_model(handout, "cosines", modes=3)
    rows = to_rows(0, [1000.0, 2000.0], [[0.025], [200.0]], pulses=(beats,))
    asked = Settings(300.0, until="snap")
    bracket = tuple(np.array([0.5, 6.0]) * static_threshold(handout))
    found, fine = (
        lowest_snap(one, rows, bracket, asked, 1e-5) for one in (model, model.with_step(0.25))
    )
    np.testing.assert_allclose(found, fine, rtol=2e-4)

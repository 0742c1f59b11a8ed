"""Slow pulses: the dwell time above the static threshold, in closed form and by motion."""

import math

import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap.pulse.pulse import make_pulse, sampled
from snapmap.thresholds.slow import HEAVY, growth_rate, slow_factor

SWINGS = math.pi / np.array([0.002, 0.02, 0.1, 0.2])


def test_the_handouts_mass_departs_in_68_us(handout):
    """From kappa = 1/(1/s - 1/lambda) - K, s = 64 pi^2 EI/L^3; and damped it departs slower."""
    s = 64 * math.pi**2 * 2.2e6 / 600**3
    for contact, kappa in ((40.0, 2.166601), (math.inf, 0.93352)):
        assert 1 / (1 / s - 1 / contact) - 5.5 == pytest.approx(kappa, rel=1e-6)
        for C in (0.0, 0.025, 25.0, 1e4):
            sigma = growth_rate(varied(handout, contact=contact), C)
            assert 1e4 * sigma**2 + C * sigma == pytest.approx(kappa, rel=1e-6)
    assert growth_rate(handout, 0.0) == pytest.approx(0.0147194, rel=1e-5)
    assert 2 / growth_rate(handout, 0.025) == pytest.approx(135.89, rel=1e-4)


def test_a_versed_sine_follows_its_closed_form_and_any_smooth_pulse_its_curvature():
    """I = (1 - cos(2 pi x + b) cos b)/2 with tan b = 2 pi f0/sigma, until the pulse ends."""
    factor = slow_factor(make_pulse(), SWINGS)
    closed = 1 + np.tan(np.arctan(2 * np.pi / SWINGS) / 2) ** 2
    np.testing.assert_allclose(factor[:3], closed[:3], rtol=2e-7)
    for shape, bend in ("versed sine", 2 * np.pi**2), ("half sine", np.pi**2):
        excess = slow_factor(make_pulse(shape), SWINGS)[1] - 1
        assert excess == pytest.approx(bend / 2 / SWINGS[1] ** 2, rel=2e-3)
    x = np.linspace(0, 1, 2001)
    record = sampled(1e4 * x, make_pulse().at(x))
    np.testing.assert_allclose(slow_factor(record, SWINGS), factor, rtol=1e-6)
    twice = sampled(1e4 * x, 0.5 * make_pulse().at(2 * x) + make_pulse().at(2 * x - 1))
    np.testing.assert_allclose(slow_factor(twice, 2 * SWINGS), factor, rtol=1e-5)
    assert slow_factor(make_pulse("trapezoid"), SWINGS[:2]) == pytest.approx(np.ones(2), abs=1e-12)
    for pulse in (make_pulse("sawtooth"), make_pulse().reversed()):
        assert np.isnan(slow_factor(pulse, SWINGS)).all()


def test_thresholds_of_slow_pulses_are_those_of_the_dwell(handout):
    f0, C = [50.0, 100.0, 200.0], [0.025, 25.0]
    found = snapmap.threshold(handout, f0, C, model="cosines", modes=3, tolerance=1e-5)
    np.testing.assert_allclose(found.N_slow, found.N_first, rtol=1e-3)
    assert found.dwell.values.tolist() == [2 / growth_rate(handout, c) for c in C]
    # N_static of the exact beam is 2e-4 above that of three cosines.
    rise = (math.pi * 1e-6 / growth_rate(handout, 0.025)) ** 2 * 37500
    for N in (found.N_first, found.N_slow):
        assert (N[0, 2] - N[0, 0]) / found.N_static == pytest.approx(rise, rel=0.04)


def test_what_has_no_corner_has_no_dwell(handout):
    light, tilts = {"mass": 0.99 * HEAVY * handout.beam.weight}, {"free": 1.0, "imperfection": 0.1}
    none = [{"spring": 8.0}, {"contact": 6.0}, light, {"gap": 1.0}, {"stop_toward": 6.0}, tilts]
    none += [{"cosine_2": 0.01}]  # 8 uN/um are as stiff as the falling beam
    assert np.isnan([growth_rate(varied(handout, **values), 0.025) for values in none]).all()
    for values in ({"stop_toward": 60.0, "stop_away": 5.0}, {"residual_stress": -3.0}):
        assert growth_rate(varied(handout, **values), 0.025) == growth_rate(handout, 0.025)

"""The largest slow loads, static flexibility and strength: closed forms, and forces held."""

import math
from dataclasses import replace

import numpy as np
import pytest
from small_studies import cases_of
from varied import alone, varied

import snapmap
from snapmap.beam.equilibria import buckling_modes
from snapmap.beam.limit_loads import static_threshold
from snapmap.beam.stress import break_probability
from snapmap.device.device import batch


@pytest.mark.filterwarnings("error")
def test_static_thresholds_are_the_largest_forces_and_that_of_a_mass_far_away(handout):
    far, held = varied(handout, gap=1e4), varied(handout, gap=0.5, spring=1e6)
    assert static_threshold(alone(handout)) == static_threshold(far) == static_threshold(held)
    for device in (alone(handout, 1.0), alone(handout, 1.0, free=1.0, imperfection=0.01)):
        force = snapmap.statics(device).largest_force.item()
        assert static_threshold(device) == pytest.approx(force, rel=1e-4)
    for made in ({"residual_stress": -20.0}, {"cosine_2": 0.2, "residual_stress": -150.0}):
        device = alone(handout, 1.0, **made)
        least = snapmap.statics(device).least_force.item()
        assert static_threshold(device, back=True) == pytest.approx(-least, rel=1e-5)


def test_a_stop_before_the_saddle_holds_the_beam_till_it_leaves_by_its_own_inertia(handout):
    def static(**values):
        return static_threshold(varied(handout, **values))

    alone, limits = static(gap=1e4), [static(stop_toward=way) for way in (13, 12, 10, 5, 3)]
    assert limits == sorted(limits) and limits[-2] < alone == limits[-1]
    assert static(gap=2.0, stop_toward=12.0) == pytest.approx(limits[2], rel=1e-9)
    assert static(gap=2.0, stop_toward=2.0) == alone and static(stop_toward=13.4) == static()


@pytest.mark.parametrize("gap", [0.0, 0.5, 1.5])
def test_a_stiff_spring_lets_go_of_a_light_beam_at_its_saddle(handout, gap):
    """There the beam rests without the mass, 4/3 rise from the first shape: M a = K (way + gap)."""
    values = {"density": 1e-4 * handout.beam.density, "spring": 20.0, "contact": np.inf}
    device = varied(handout, **values, gap=gap)
    exact = device.spring * (4 / 3 * handout.beam.rise + gap) / (device.mass * device.gravity)
    assert static_threshold(device) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("stress", [-8.0, 0.0, 20.0])
def test_kept_and_left_out_modes_yield_as_the_exact_beam_column_does(handout, stress):
    """By (tan b - b)/(64 b^3), b = sqrt(N)/4, at an N half way from the rest's to the saddle's."""
    beam = replace(handout.beam, residual_stress=stress)
    modes, unit = buckling_modes(beam), beam.stiffness_unit
    tension = modes.buckling[0, 0] / (unit * beam.span) - 4 * np.pi**2
    b = np.sqrt((16 * np.pi**2 - tension) / 2) / 4
    kept = np.sum(modes.midpoint**2 / (modes.buckling - (16 * b**2 + tension) * unit * beam.span))
    exact = (np.tan(b) - b) / (64 * b**3) / unit
    assert kept + modes.residual == pytest.approx(exact, rel=1e-9)
    assert 0 < modes.residual < 1e-5 * abs(exact)


def test_a_batch_has_the_static_thresholds_of_its_devices(handout):
    devices = [varied(handout, **values) for values in cases_of(__file__)] * 3
    for back in (False, True):
        each = [static_threshold(device, back) for device in devices]
        assert static_threshold(batch(devices), back).tolist() == each


def test_strengths_follow_the_law_of_weibull_or_are_one_number(handout):
    """Of 63 % at the scale over the threshold; the excess of 1.5 scales to the power of 4."""
    stress, some = np.array([900.0, 1000.0, 1500.0, 1750.0]), {"strength_threshold": 1000.0}
    device = replace(handout, strength=500.0, **some, strength_modulus=4.0)
    exact = [0.0, 0.0, 1 - math.exp(-1), 1 - math.exp(-(1.5**4))]
    assert break_probability(device, stress) == pytest.approx(exact, abs=1e-9)
    sharp = break_probability(replace(device, strength_modulus=math.inf), stress + 1)
    assert sharp.tolist() == [0.0, 0.0, 1.0, 1.0]

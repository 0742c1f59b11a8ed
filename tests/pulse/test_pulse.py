"""Shapes against closed forms and other codes, recorded shocks, directions, and what is refused."""

import math
import re

import numpy as np
import pytest
from conserving_loop import assert_followed
from scipy.interpolate import CubicSpline

import snapmap
from snapmap.pulse.pulse import SHAPES, make_pulse, sampled
from snapmap.solver.models import build_model

FORMS = {
    "versed sine": lambda x: (1 - np.cos(2 * np.pi * x)) / 2,
    "half sine": lambda x: np.sin(np.pi * x),
    "sawtooth": lambda x: x,
    "trapezoid": lambda x: np.minimum(1, 10 * np.minimum(x, 1 - x)),
}
AREAS = {"versed sine": 1 / 2, "half sine": 2 / math.pi, "sawtooth": 1 / 2, "trapezoid": 0.9}


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_are_what_their_names_say(shape):
    pulse, x = make_pulse(shape), np.linspace(0, 1, 2001)
    np.testing.assert_allclose(pulse.at(x), FORMS[shape](x), atol=1e-14)
    assert pulse.area == pytest.approx(AREAS[shape], rel=1e-14)
    assert pulse.at(np.array([-0.1, 1.1])).tolist() == [0, 0]
    assert pulse.variation == pytest.approx(2) and pulse.highest == 1
    back = pulse.reversed()
    assert back.area == -pulse.area and back.highest == 0
    assert pulse.ends == (0.0, 1.0 if shape == "sawtooth" else 0.0)


def test_short_pulses_trip_by_their_velocity_change(handout):
    """Half sine : versed sine : sawtooth = pi/4 : 1 : 1; the impulsive limit is one."""
    f0 = 100 * handout.own_frequency / (2 * math.pi) * 1e6
    shapes = ["versed sine", "half sine", "sawtooth"]
    found = snapmap.threshold(handout, [f0], [60.0], model="cosines", pulse=shapes).squeeze()
    N = found.N_first.values / found.N_first.values[0]
    np.testing.assert_allclose(N, [1, math.pi / 4, 1], rtol=0.01)
    changes = found.velocity_change.values
    np.testing.assert_allclose(changes, changes[0], rtol=0.01)


def test_long_pulses_without_a_jump_trip_at_the_static_limit(handout):
    f0 = 0.01 * handout.own_frequency / (2 * math.pi) * 1e6
    asked = {"model": "cosines", "horizon": 300.0, "direction": "both", "pulse": [*SHAPES]}
    found = snapmap.threshold(handout, [f0], [25.0], **asked).squeeze()
    forward, back = found.sel(direction="+z"), found.sel(direction="-z")
    smooth = ["versed sine", "half sine", "trapezoid"]
    np.testing.assert_allclose(forward.N_first.sel(shape=smooth), forward.N_static[0], rtol=5e-3)
    np.testing.assert_allclose(forward.N_first, forward.N_static, rtol=0.02)
    assert back.N_static.sel(shape=smooth).isnull().all()
    assert back.N_static.sel(shape="sawtooth") > forward.N_static.sel(shape="sawtooth")


@pytest.mark.parametrize("shape", SHAPES)
def test_a_kink_or_a_jump_leaves_order_two(handout, fix_step, shape):
    """Of a mass that flies, after the pulse: a jump enters by its mean over a step."""
    f0, runs = 4100.0, []
    for step in (0.8, 0.4, 0.2, 0.1):
        fix_step(step)
        asked = {"pulse": shape, "direction": "-z", "horizon": 30.0}
        run = snapmap.simulate(handout, 100, f0, 25.0, "cosines", modes=3, **asked)
        runs.append((run.time.values, run.z_mass.values))
    late = 1.02e6 / f0 + np.linspace(0, 20, 100)
    *ends, exact = (CubicSpline(*run)(late) for run in runs)
    errors = [abs(one - exact).max() for one in ends]
    assert errors[0] / errors[1] > 2.5 and errors[1] / errors[2] > 2.5
    assert errors[0] < 1e-3


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("direction", ["+z", "-z"])
def test_the_kernel_follows_the_plain_loop_under_every_shape(handout, shape, direction):
    pulse = make_pulse(shape) if direction == "+z" else make_pulse(shape).reversed()
    model = build_model(handout, "cosines", modes=3)
    assert_followed(model, pulse, 500.0, 3000.0, 25.0, 0.2, 1700)


def test_shapes_and_directions_are_axes(handout):
    """Each point of them is, bit for bit, what it is alone."""
    asked = {"N": [700.0, 1100.0], "f0": [1500.0, 5000.0], "C": [0.025], "model": "cosines"}
    cube = snapmap.sweep(handout, **asked, pulse=["half sine", "sawtooth"], direction="both")
    assert cube.outcome.dims == ("shape", "direction", "C", "f0", "N")
    for shape in ("half sine", "sawtooth"):
        for way in ("+z", "-z"):
            alone = snapmap.sweep(handout, **asked, pulse=shape, direction=way)
            one = cube.sel(shape=shape, direction=way)
            np.testing.assert_array_equal(one.t_snap, alone.t_snap)
            np.testing.assert_array_equal(one.outcome, alone.outcome)


def test_a_recorded_half_sine_is_a_half_sine(handout, tmp_path):
    """Whatever its peak, with its own duration and stretched to another."""
    x = np.linspace(0, 1, 401)
    path = tmp_path / "half.csv"
    rows = (f"{0.5 * at!r},{37.0 * math.sin(math.pi * at)!r}" for at in x.tolist())
    path.write_text("\n".join(["time (ms),acceleration (g)", *map(str, rows)]), encoding="utf-8")
    pulse = snapmap.read_pulse(path)
    assert pulse.name == "half" and pulse.duration == pytest.approx(500.0) and not pulse.notes
    assert pulse.peak == pytest.approx(37 * 9.80665e-6) and np.isnan(make_pulse().peak)
    asked = {"C": [25.0], "model": "cosines"}
    exact = snapmap.threshold(handout, [2000.0, 5000.0], **asked, pulse="half sine").N_first
    own = snapmap.threshold(handout, None, **asked, pulse=pulse)
    assert own.f0.values == pytest.approx([2000.0])
    assert own.N_first.item() == pytest.approx(exact[0, 0].item(), rel=1e-3)
    other = snapmap.threshold(handout, [5000.0], **asked, pulse=pulse).N_first.item()
    assert other == pytest.approx(exact[0, 1].item(), rel=1e-3)


def test_samples_are_joined_by_straight_lines():
    pulse = sampled(np.array([3.0, 4.0, 7.0, 8.0]), np.array([0.0, -4.0, 2.0, 0.0]))
    assert pulse.duration == 5.0
    np.testing.assert_allclose(pulse.at(np.array([0.1, 0.2, 0.5, 0.9])), [-0.5, -1, -0.25, 0.25])
    assert pulse.highest == 0.5 and pulse.variation == pytest.approx(3.0)
    assert pulse.area == pytest.approx((-2.0 - 3.0 + 1.0) / 4 / 5)


def test_a_record_that_changes_no_velocity_has_no_impulsive_limit(handout):
    """Back and forth by the same: it trips all the same, and what mostly pulls must pull harder."""
    x = np.linspace(0, 1, 101)
    swing = sampled(500 * x, np.sin(2 * np.pi * x), "swing")
    pull = sampled(500 * x, np.where(x < 0.5, -1, 0.1) * np.sin(2 * np.pi * x) ** 2, "pull")
    asked = {"C": [25.0], "model": "cosines", "pulse": [swing, pull]}
    found = snapmap.threshold(handout, [500.0, 2000.0], **asked).squeeze("C")
    assert found.velocity_change.sel(shape="swing").isnull()
    assert found.velocity_change.sel(shape="pull") > 0
    assert found.N_first.sel(shape="swing").notnull().all()
    static = found.N_static.sel(shape="swing").item()
    assert found.N_static.sel(shape="pull").item() == pytest.approx(10 * static, rel=1e-2)


def test_noise_of_a_record_is_told_from_ringing():
    fine, noise = np.linspace(0, 500, 401), 0.03 * np.random.default_rng(1).standard_normal(399)
    for swings in (60, 20, 0):
        whole = np.sin(np.pi * fine / 500) * (1 + 0.3 * np.sin(2 * np.pi * swings * fine / 500))
        assert not sampled(fine, whole).notes
    (told,) = sampled(fine, whole + np.pad(noise, 1)).notes
    assert re.match(r"has noise of 2\.\d% of its peak", told)

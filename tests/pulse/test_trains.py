"""Trains of blows and drops with rebound, against closed forms and single blows."""

import math

import numpy as np
import pytest
from conserving_loop import assert_followed
from varied import varied

import snapmap
from snapmap.pulse.pulse import blow_at, make_pulse
from snapmap.pulse.trains import GRAVITY, make_drop, make_train
from snapmap.solver.models import build_model

BLOW = {"shape": "half sine", "duration": 500.0}


def train(*items):
    return {"train": [*items]}


def areas(pulse):
    """Of each blow, with what follows up to the next, us over the peak."""
    place = np.searchsorted(pulse.pieces[:, 0], pulse.blows)
    return np.add.reduceat(pulse._areas, place) * pulse.duration


def test_a_train_is_its_blows_at_their_times():
    pulse = make_train([BLOW, {"wait": 1500.0}, {**BLOW, "N": -0.5}, {"repeat": 3}])
    assert pulse.duration == 7500.0 and pulse.ends == (0.0, 0.0)
    begins = np.array([0.0, 2000.0, 2500.0, 4500.0, 5000.0, 7000.0])
    np.testing.assert_allclose(pulse.blows * pulse.duration, begins, rtol=1e-14)
    x = np.linspace(0, 1, 1001)
    for begin, N in zip(begins, [1, -0.5] * 3, strict=True):
        found = pulse.at((begin + 500.0 * x) / pulse.duration)
        np.testing.assert_allclose(found, N * make_pulse("half sine").at(x), atol=1e-11)
    one = 500.0 * 2 / math.pi
    np.testing.assert_allclose(areas(pulse), [one, -one / 2] * 3)
    assert pulse.impact * pulse.duration == pytest.approx(one)
    assert pulse.variation == pytest.approx(9) and pulse.highest == pytest.approx(1)
    assert pulse.reversed().impact == -pulse.impact
    instants = np.array([np.nan, 0.1, 1999.0, 2001.0, 1e4]) / pulse.duration
    assert blow_at([pulse], np.zeros(5, int), instants).tolist() == [0, 1, 1, 2, 6]
    ramps = make_train([{"shape": "sawtooth", "duration": 100.0, "N": 3}, {"wait": 9.0}])
    assert ramps.at(np.array([50.0, 100.5, 105.0]) / 110).tolist() == pytest.approx([0.5, 0.5, 0])


@pytest.mark.parametrize(("shape", "rebound"), [("half sine", 0.3), ("sawtooth", 0.0)])
def test_a_drop_changes_the_velocity_as_its_height_and_rebound_say(shape, rebound):
    height, lasts = 2e4, 400.0
    pulse = make_drop({"height": height, "duration": lasts, "shape": shape, "rebound": rebound})
    velocity = math.sqrt(2 * GRAVITY * height)
    one = pulse.own_N * GRAVITY
    fall = pulse.duration * pulse.pieces[0, 0], pulse.blows[0] * pulse.duration
    assert fall[1] == pytest.approx(velocity / GRAVITY, rel=1e-12)
    assert pulse.at(pulse.blows[0] - 1e-9) == pytest.approx(-1 / pulse.own_N, rel=1e-9)
    assert one * pulse.impact * pulse.duration == pytest.approx((1 + rebound) * velocity)
    changes = one * areas(pulse) / velocity
    back = rebound ** np.arange(pulse.blows.size)
    expected = (1 + rebound) * back
    expected[:-1] -= 2 * back[1:]
    np.testing.assert_allclose(changes, expected, rtol=1e-9)
    assert pulse.blows.size == (3 if rebound else 1)
    assert one * pulse.area * pulse.duration == pytest.approx(velocity * back[-1] * rebound)
    flights = np.diff(pulse.blows * pulse.duration) - lasts
    np.testing.assert_allclose(flights, 2 * back[1:] * velocity / GRAVITY, rtol=1e-3)


@pytest.mark.parametrize(("apart", "share"), [(1.0, 1.0), (0.5, 0.0), (1.25, 0.5**0.5)])
def test_a_second_blow_adds_to_the_swing_of_the_mass_or_takes_it(handout, apart, share):
    """Behind a wide gap the mass is a linear oscillator: times 2 |cos(pi apart)| in periods."""
    far = varied(handout, gap=50.0)
    period = 2 * math.pi / far.own_frequency
    lasts, N = 0.1 * period, 30
    blow = {"shape": "half sine", "duration": lasts}
    push = train(blow, {"wait": apart * period - lasts}, blow)
    asked = {"model": "cosines", "horizon": 2 * period, "pulse": push}
    run = snapmap.simulate(far, N, None, 0.0, **asked)
    after = run.z_mass.values[run.time.values > apart * period + lasts]
    p, own = math.pi / lasts, far.own_frequency
    alone = 2 * N * far.gravity * p * math.cos(own * lasts / 2) / (own * abs(own**2 - p**2))
    swing = abs(after - far.beam.rise - far.gap).max()
    assert swing == pytest.approx(2 * share * alone, abs=2e-3 * alone)
    assert run.blow == 0


def test_blows_far_apart_with_damping_are_blows_alone(handout):
    """And N_static and velocity_change are those of one blow."""
    calm = varied(handout, damping=0.02)  # the beam rings no longer than its mass
    asked = {"C": [25.0], "model": "cosines", "horizon": 500.0}
    one = snapmap.threshold(calm, [2000.0], pulse="half sine", **asked).squeeze()
    pushes = train(BLOW), train(BLOW, {"wait": 9000.0}, BLOW)
    alone, two = (snapmap.threshold(calm, None, pulse=push, **asked).squeeze() for push in pushes)
    for key in ("N_first", "N_error", "N_always", "t_snap"):
        assert alone[key] == one[key]
    assert two.N_first.item() == pytest.approx(one.N_first.item(), abs=(one + two).N_error.item())
    for key in ("N_static", "velocity_change"):
        assert two[key].item() == pytest.approx(one[key].item(), rel=1e-9)
    assert "blow" not in one and alone.blow == 1


def test_the_kernel_follows_the_plain_loop_through_a_train(handout):
    parts = {"shape": "sawtooth", "duration": 90.0}, {"wait": 60.0}, {**BLOW, "duration": 99.0}
    pulse, model = make_train(parts), build_model(handout, "cosines", modes=3)
    assert_followed(model, pulse, 700.0, 1e6 / pulse.duration, 25.0, 0.2, 1400)

"""Pulses, records, trains and drops against closed forms, single blows and other codes."""

import math
import re

import numpy as np
import pytest
from conserving_loop import assert_followed
from scipy.interpolate import CubicSpline
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.pulse.pulse import SHAPES, G, N_of_g, Pulse, blow_at, make_pulse, sampled
from snapmap.pulse.shocks import make_drop, make_shocks, make_train
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines

CASES = cases_of(__file__)
BLOW = {"shape": "half sine", "duration": 500.0}
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


@pytest.mark.parametrize("shape", CASES["shapes"])
def test_a_shape_is_smooth_steep_or_constant(shape):
    box = Pulse("box", [[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    pulse = make_pulse(shape) if shape in SHAPES else box
    told = [pulse.is_smooth, pytest.approx(pulse.steepest), pulse.is_flat, [*pulse.ends]]
    assert told == CASES["shapes"][shape] and not pulse.strikes and not pulse.waits.size


@pytest.mark.parametrize(("values", "notes"), CASES["notes"])
def test_a_record_that_may_be_no_whole_shock_is_told(values, notes):
    assert sampled(1e3 * np.arange(len(values)), values).notes == tuple(notes)


@pytest.mark.parametrize(("pulse", "line"), CASES["refused"])
def test_what_is_no_shock_is_refused_in_a_line(pulse, line):
    with pytest.raises(ValueError, match=rf"^pulse{re.escape(line)}$"):
        make_shocks(pulse)


@pytest.mark.parametrize(("pulse", "direction", "section"), CASES["sections"])
def test_a_shock_is_written_as_a_config_has_it(pulse, direction, section):
    shocks = make_shocks(pulse, direction)
    assert shocks.section() == section
    assert make_shocks(shocks.values()).pulses == shocks.pulses


def test_N_counts_multiples_of_g_where_the_unit_is_about_that():
    units = [share * G for share in (0, 0.9901, 1.0099, 1 / 1.02, 0.5)]
    assert [N_of_g(unit) for unit in units] == pytest.approx([1, 1, 1, 1.02, 2], rel=1e-9)


PIECES = [[0.0, 0.0, 2.0, 0.0, 0.0, 0.0], [0.5, 1.0, -2.0, 0.0, 0.0, 0.0]]
WRONG = {
    "rows of 6 numbers": ["abc", None, 3, [], PIECES[0], np.ones((2, 5)), [[1.0], [2.0, 3.0]]],
    "not finite": [[[0.0, np.nan, 0, 0, 0, 0]], [[0.0, 0, np.inf, 0, 0, 0]]],
    "sort them": [PIECES[::-1], [PIECES[1]], [PIECES[0]] * 2, [PIECES[0], [1.0] * 6]],
}


def test_a_pulse_made_by_hand_is_right_or_refused_in_a_line():
    assert Pulse("mine", PIECES).area == 0.5
    for fault, wrong in WRONG.items():
        for pieces in wrong:
            with pytest.raises(ValueError, match=rf"\Apulse: pieces .*{fault}.*\Z"):
                Pulse("mine", pieces)
    for value in (0.0, -1.0, np.nan, "1 kg"):
        line = r"\Apulse: duration .*(is not a number above 0|convert to us)"
        with pytest.raises(ValueError, match=line):
            Pulse("mine", PIECES, duration=value)
    with pytest.raises(ValueError, match=r"\Apulse: name 3 is not text\Z"):
        Pulse(3, PIECES)


def test_a_record_that_pulls_is_judged_as_one_that_presses():
    with pytest.raises(ValueError, match=r"ends at 5% of its peak; record until it is over"):
        sampled([0.0, 1.0, 2.0], [0.0, 1.0, -0.051])
    pull = sampled([0.0, 1.0, 2.0], [0.0, -4.0, 0.0])
    assert (pull.area, pull.gross_area, pull.highest) == (-0.5, 0.5, 0.0)
    assert sampled([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, -1.0, 0.0]).gross_area >= 0.5
    coarse = ["recorded: samples 0.898 us apart are coarse for a period of 6.28 us"]
    for samples, lines in ((9, []), (7, coarse)):
        time = np.linspace(0.0, 2 * np.pi, samples + 1)  # a period of the device
        assert sampled(time, np.sin(time / 2)).doubts(1.0, time[-1], 9.81e-6) == lines


def test_swings_are_those_of_the_shape_or_of_the_fastest_blow():
    zigzag = sampled(np.arange(6.0), [0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    train = make_train([BLOW, {"wait": 9250.0}, BLOW | {"duration": 250.0}])
    swings = [pulse.swings for pulse in (make_pulse(), zigzag, train, train.strongest)]
    assert swings == pytest.approx([1.0, 4.0, 40.0, 1.0], rel=1e-14)


@pytest.mark.parametrize("shape", SHAPES)
def test_waves_of_both_signs_add_to_the_gross_area_and_cancel_in_the_area(shape):
    blow = {"shape": shape, "duration": 500.0}
    train = make_train([blow, blow | {"N": -1.0}])
    assert train.area == pytest.approx(0.0, abs=1e-14) and train.pulls
    assert train.gross_area == pytest.approx(AREAS[shape], rel=2e-3)  # a jump ends in a short line


DIRECTIONS = "+z", "-z", "both", ("+z", "-z"), ("-z", "+z"), ("+z",), ("-z",)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_both_directions_are_written_as_both_and_others_as_they_are(direction):
    written = {"+z": None, ("+z", "-z"): "both"}.get(direction, direction)
    shocks = make_shocks(direction=direction)
    assert shocks.section() == ({"pulse": {"direction": written}} if written else {})
    assert make_shocks(shocks.values()).direction == shocks.part({}).direction == shocks.direction


def test_the_strongest_blow_of_a_train_may_pull_and_a_blow_begins_at_its_begin():
    train = make_train([BLOW, {"wait": 500.0}, BLOW | {"N": -2.0}])
    assert train.strongest.area < 0
    x, which = np.array([np.nan, 0.1, *train.blows]), np.zeros(4, int)
    assert blow_at([train], which, x).tolist() == [0, 1, 1, 2]


def test_short_pulses_trip_by_their_velocity_change(handout):
    """Half sine : versed sine : sawtooth = pi/4 : 1 : 1; the impulsive limit is one."""
    f0 = 100 * handout.own_frequency / (2 * math.pi) * 1e6
    shapes = ["versed sine", "half sine", "sawtooth"]
    edges = snapmap.threshold(Study(handout, "cosines", pulse=shapes), [f0], [60.0]).squeeze()
    np.testing.assert_allclose(edges.N_first / edges.N_first[0], [1, math.pi / 4, 1], rtol=0.01)
    assert (edges.velocity_change == edges.velocity_change[0]).all()


def test_long_pulses_without_a_jump_trip_at_the_static_limit(handout):
    """Backwards, where a search for nothing is slow, the limit is that of every frequency."""
    own, asked = handout.own_frequency / (2e-6 * math.pi), {"model": "3 cosines", "horizon": 300.0}
    there = snapmap.threshold(Study(handout, pulse=[*SHAPES], **asked), [0.02 * own], [25.0])
    there, smooth = there.squeeze(), ["versed sine", "half sine", "trapezoid"]
    np.testing.assert_allclose(there.N_first.sel(shape=smooth), there.N_static[0], rtol=5e-3)
    np.testing.assert_allclose(there.N_first, there.N_static, rtol=0.02)
    study = Study(handout, pulse=["half sine", "sawtooth"], direction="-z", **asked)
    back = snapmap.threshold(study, [own], [25.0]).squeeze().N_static
    assert back.isnull().values.tolist() == [True, False]
    assert back.sel(shape="sawtooth") > there.N_static.sel(shape="sawtooth")


@pytest.mark.parametrize("shape", SHAPES)
def test_a_kink_or_a_jump_leaves_order_two(handout, fix_step, shape):
    """Of a mass that flies, after the pulse: a jump enters by its mean over a step."""
    f0, ends, asked = 4100.0, [], {"pulse": shape, "direction": "-z", "horizon": 30.0}
    late = 1.02e6 / f0 + np.linspace(0, 20, 100)
    for step in (0.8, 0.4, 0.2, 0.1):
        fix_step(step)
        run = snapmap.simulate(Study(handout, "3 cosines", **asked), 100, f0, 25.0)
        ends.append(CubicSpline(run.time, run.z_mass)(late))
    errors = [abs(end - ends[-1]).max() for end in ends[:-1]]
    assert errors[0] / errors[1] > 2.5 and errors[1] / errors[2] > 2.5 and errors[0] < 1e-3


PARTS = {"shape": "sawtooth", "duration": 90.0}, {"wait": 60.0}, {**BLOW, "duration": 99.0}
RUNS = [(make_pulse(shape), 500.0, 3000.0, 1700) for shape in SHAPES]
RUNS += [(pulse.reversed(), *others) for pulse, *others in RUNS]
RUNS += [(make_train(PARTS), 700.0, 1e6 / 249.0, 1400)]


@pytest.mark.parametrize(("pulse", "N", "f0", "steps"), RUNS)
def test_the_kernel_follows_the_plain_loop_under_every_pulse(handout, pulse, N, f0, steps):
    model = build_model(handout, Cosines(modes=3))
    assert_followed(model, pulse, N, f0, 25.0, 0.2, steps)


def test_a_recorded_half_sine_is_a_half_sine(handout, tmp_path):
    """Whatever its peak, with its own duration and stretched to another."""
    x, path = np.linspace(0, 1, 401), tmp_path / "half.csv"
    columns = np.column_stack([0.5 * x, 37.0 * np.sin(np.pi * x)])
    np.savetxt(path, columns, "%.17g", ",", header="time (ms),acceleration (g)", comments="")
    pulse = snapmap.read_pulse(path)
    assert pulse.name == "half" and pulse.duration == pytest.approx(500.0) and not pulse.notes
    assert pulse.peak == pytest.approx(37 * 9.80665e-6) and np.isnan(make_pulse().peak)
    how = {"model": "cosines"}
    asked = {"C": [25.0]}
    study = Study(handout, pulse="half sine", **how)
    exact = snapmap.threshold(study, [2000.0, 5000.0], **asked).N_first
    for f0, N in zip((None, [5000.0]), exact.values[0], strict=True):
        edge = snapmap.threshold(Study(handout, pulse=pulse, **how), f0, **asked)
        assert edge.f0.item() == pytest.approx(5000.0 if f0 else 2000.0)
        assert edge.N_first.item() == pytest.approx(N, rel=1e-3)


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
    how = {"model": "cosines", "pulse": [swing, pull]}
    asked = {"C": [25.0]}
    edges = snapmap.threshold(Study(handout, **how), [500.0, 2000.0], **asked).squeeze("C")
    swing, pull = (edges.sel(shape=shape) for shape in ("swing", "pull"))
    assert swing.velocity_change.isnull() and pull.velocity_change > 0
    assert swing.N_first.notnull().all()
    assert pull.N_static.item() == pytest.approx(10 * swing.N_static.item(), rel=1e-2)


def test_noise_of_a_record_is_told_from_ringing():
    fine, noise = np.linspace(0, 500, 401), 0.03 * np.random.default_rng(1).standard_normal(399)
    for swings in (60, 20, 0):
        whole = np.sin(np.pi * fine / 500) * (1 + 0.3 * np.sin(2 * np.pi * swings * fine / 500))
        assert not sampled(fine, whole).notes
    (note,) = sampled(fine, whole + np.pad(noise, 1)).notes
    assert re.match(r"has noise of 2\.\d% of its peak", note)


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
        blow = pulse.at((begin + 500.0 * x) / pulse.duration)
        np.testing.assert_allclose(blow, N * make_pulse("half sine").at(x), atol=1e-11)
    area = 500.0 * 2 / math.pi
    np.testing.assert_allclose(areas(pulse), [area, -area / 2] * 3)
    assert pulse.impact * pulse.duration == pytest.approx(area)
    assert pulse.variation == pytest.approx(9) and pulse.highest == pytest.approx(1)
    assert pulse.reversed().impact == -pulse.impact
    instants = np.array([np.nan, 0.1, 1999.0, 2001.0, 1e4]) / pulse.duration
    assert blow_at([pulse], np.zeros(5, int), instants).tolist() == [0, 1, 1, 2, 6]
    ramps = make_train([{"shape": "sawtooth", "duration": 100.0, "N": 3}, {"wait": 9.0}])
    assert ramps.at(np.array([50.0, 100.5, 105.0]) / 110).tolist() == pytest.approx([0.5, 0.5, 0])


DROPS = [("half sine", 0.3, 2), ("sawtooth", 0.0, 0), ("versed sine", 0.2, 1)]


@pytest.mark.parametrize(("shape", "rebound", "again"), DROPS)
def test_a_drop_changes_the_velocity_as_its_height_and_rebound_say(shape, rebound, again):
    height, lasts = 2e4, 400.0
    pulse = make_drop({"height": height, "duration": lasts, "shape": shape, "rebound": rebound})
    velocity = math.sqrt(2 * G * height)
    unit, back = pulse.peak / velocity, rebound ** np.arange(pulse.blows.size)
    assert pulse.blows[0] * pulse.duration == pytest.approx(velocity / G, rel=1e-12)
    assert pulse.at(pulse.blows[0] - 1e-9) == pytest.approx(-G / pulse.peak, rel=1e-9)
    assert unit * pulse.impact * pulse.duration == pytest.approx(1 + rebound)
    changes = (1 + rebound) * back - 2 * np.append(back[1:], 0)
    np.testing.assert_allclose(unit * areas(pulse), changes, rtol=1e-9)
    assert pulse.blows.size == 1 + again
    words = ("", ", 1 rebound", ", 2 rebounds")[again]
    assert pulse.words == f"drop from 2 cm, {shape} of 0.4 ms{words}"
    fall = f"drop: N = {pulse.peak / 1e-5:.5g} is the fall from its height; another N scales the"
    assert pulse.doubts(1.0, 1.0, 1e-5) == [f"{fall} whole record"]
    assert unit * pulse.area * pulse.duration == pytest.approx(back[-1] * rebound)
    flights = np.diff(pulse.blows * pulse.duration) - lasts
    np.testing.assert_allclose(flights, 2 * back[1:] * velocity / G, rtol=1e-3)


@pytest.mark.parametrize(("apart", "share"), [(1.0, 1.0), (0.5, 0.0), (1.25, 0.5**0.5)])
def test_a_second_blow_adds_to_the_swing_of_the_mass_or_takes_it(handout, apart, share):
    """Behind a wide gap the mass is a linear oscillator: times 2 |cos(pi apart)| in periods."""
    far, N = varied(handout, gap=50.0), 30
    omega, period = far.own_frequency, 2 * math.pi / far.own_frequency
    lasts = 0.1 * period
    blow, wait = {"shape": "half sine", "duration": lasts}, {"wait": apart * period - lasts}
    asked = {"horizon": 2 * period, "pulse": {"train": [blow, wait, blow]}}
    run = snapmap.simulate(Study(far, "cosines", **asked), N, None, 0.0)
    after, p = run.z_mass[run.time > apart * period + lasts], math.pi / lasts
    alone = 2 * N * far.gravity * p * math.cos(omega * lasts / 2) / (omega * abs(omega**2 - p**2))
    swing = abs(after - far.beam.rise - far.gap).max().item()
    assert swing == pytest.approx(2 * share * alone, abs=2e-3 * alone) and run.blow == 0


def test_blows_far_apart_with_damping_are_blows_alone(handout):
    """And N_static and velocity_change are those of one blow."""
    calm = varied(handout, damping=0.02)  # the beam rings no longer than its mass
    how = {"model": "cosines", "horizon": 500.0}
    trains = {"train": [BLOW]}, {"train": [BLOW, {"wait": 9000.0}, BLOW]}
    asked = ([2000.0], "half sine"), *((None, pushes) for pushes in trains)
    studies = ((Study(calm, pulse=push, **how), f0) for f0, push in asked)
    pulse, alone, two = (snapmap.threshold(*each, [25.0]).squeeze() for each in studies)
    for key in ("N_first", "N_error", "N_always", "t_snap"):
        assert alone[key] == pulse[key]
    assert abs(two.N_first - pulse.N_first) <= pulse.N_error + two.N_error
    for key in ("N_static", "velocity_change"):
        assert two[key].item() == pytest.approx(pulse[key].item(), rel=1e-9)
    assert "blow" not in pulse and alone.blow == 1


ROW = "0,0\n0.1,5\n0.2,9\n"
REST = "0.3,0\n"


@pytest.mark.parametrize(("text", "line"), CASES["wrong"])
def test_a_record_that_is_miswritten_is_refused_with_a_remedy_that_helps(tmp_path, text, line):
    (tmp_path / "shock.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"shock\.csv: .*{line}"):
        snapmap.read_pulse(tmp_path / "shock.csv")


def test_samples_that_do_not_ascend_are_named():
    for time, fault in (([0, 1, 1, 2], "that of the one bef"), ([0, 2, 1, 3], "before the last")):
        with pytest.raises(ValueError, match=f"sample 3: time is {fault}"):
            sampled(time, [0.0, 1.0, 1.0, 0.0])


@pytest.mark.parametrize("head", ["", "# Logger\n# 10 kHz, g\n", "#\n# "])
def test_comments_before_the_header_of_a_record_are_left_out(tmp_path, head):
    (tmp_path / "shock.csv").write_text(f"{head}time (ms),CH (1) [g]\n{ROW}{REST}", "utf-8")
    pulse = snapmap.read_pulse(tmp_path / "shock.csv")
    assert pulse.duration == pytest.approx(300.0) and pulse.peak == pytest.approx(9 * G)


def test_a_record_of_a_sensor_beyond_its_range_is_told_from_others():
    t = np.linspace(0, 2000, 1001)
    x = np.clip((t - 200) / 500, 0, 1)
    ringing = np.sin(np.pi * x) + 0.3 * np.exp(-t / 400) * np.sin(t / 20)
    shocks = np.sin(np.pi * x), np.sin(np.pi * x) ** 2, -ringing, np.sin(2 * np.pi * x)
    for whole in shocks:
        for fine in (1, 4, 25):
            assert "flat" not in " ".join(sampled(t[::fine], whole[::fine]).notes)
        assert "flat" not in " ".join(sampled(t, np.round(whole * 127)).notes)
    for share in (0.95, 0.7, 0.3):
        for whole in shocks:
            top = share * abs(whole).max()
            record = np.clip(whole, -top, top)
            note = sampled(t, record).notes[0]
            assert re.match(r"is flat at its peak for [\d.]+ ms, as of a sensor beyond its", note)
    (note,) = sampled(t, np.clip(shocks[0], -0.5, 0.5)).notes
    assert "flat at its peak for 0.33 ms" in note


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_record_whose_largest_acceleration_only_pulls_is_doubted(sign):
    """Unless the other direction counts, too, or a pull is what snaps."""
    t = np.linspace(0.0, 500.0, 101)
    record = sampled(t, sign * np.sin(2 * np.pi * t / 500) * np.where(t < 250, 1.0, 0.5), "hit")
    ways = {"+z": sign < 0, "-z": sign > 0, "both": False}
    for direction, pulls in ways.items():
        lines = make_shocks(record, direction).doubts(is_pressed=True)
        other = "-z" if direction == "+z" else "+z"
        assert len(lines) == pulls and all(line.endswith(f"direction: {other}") for line in lines)
        assert not make_shocks(record, direction).doubts(is_pressed=False)
    for pulse in ("half sine", {"train": [{"N": -2.0, "duration": 9.0}, {"duration": 9.0}]}):
        assert not make_shocks(pulse, "-z").doubts(is_pressed=True)

"""Shapes against closed forms and other codes, recorded shocks, directions, and what is refused."""

import dataclasses
import json
import math
import re

import numpy as np
import pytest
import pyuff
from conserving_loop import assert_followed
from pyyeti import srs
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import snapmap
from snapmap.pulse import SHAPES, make_pulse, sampled, table
from snapmap.shocks import make_shocks
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out
from snapmap.solver.kernel.rows import LANES
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


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("x_step", [1e-4, 0.0031, 0.047])
def test_the_kernel_sets_a_pulse_out_as_it_is(shape, x_step):
    """Every step of every block; with a jump the sum over steps stays the area."""
    X, pulse = np.zeros((R.VECTORS + 40) * LANES), make_pulse(shape)
    shocks, state, pulses = np.zeros(BLOCK * LANES), no_pulse(), table([pulse])
    X[R.AMPLITUDE * LANES :][:LANES] = 1.0
    begin_pulse(X, 3, state, pulses, 0, x_step)
    found = []
    for block in range(int(1 / x_step / BLOCK) + 2):
        state.steps[:] = block * BLOCK
        set_out(X, shocks, state, pulses)
        found.append(shocks.reshape(-1, LANES).copy())
    found = np.concatenate(found)
    assert not np.delete(found, 3, axis=1).any()
    x = x_step * np.arange(len(found))
    smooth = abs(x - 1) > x_step
    np.testing.assert_allclose(found[smooth, 3], pulse.at(x)[smooth], atol=1e-11)
    kinks = {"versed sine": x_step, "sawtooth": 0.3, "half sine": 0.6, "trapezoid": 3.0}
    assert abs(found[:, 3].sum() * x_step - pulse.area) < kinks[shape] * x_step**2 + 1e-11


@pytest.mark.parametrize("shape", SHAPES)
def test_a_mass_pulled_off_is_a_linear_oscillator(handout, shape):
    """Along -z the mass leaves the beam at once; against an integrator of order 8."""
    f0, pulse = 3000.0, make_pulse(shape)
    run = snapmap.simulate(
        handout, 30, f0, 0.0, model="cosines", horizon=30.0, pulse=shape, direction="-z", step=0.2
    )
    omega2, a = handout.spring / handout.mass, 30 * handout.gravity

    def rate(t, state):
        return [state[1], a * float(pulse.at(np.array(t * f0 * 1e-6))) - omega2 * state[0]]

    joints = [0.1 * 1e6 / f0, 0.9 * 1e6 / f0, 1e6 / f0, run.time.values[-1]]
    state, begin, exact = [0.0, 0.0], 0.0, np.zeros(run.time.size)
    for end in joints:
        some = (run.time.values >= begin) & (run.time.values < end)
        asked = np.append(run.time.values[some], end)
        found = solve_ivp(rate, (begin, end), state, "DOP853", asked, rtol=1e-10, atol=1e-12)
        exact[some], state, begin = found.y[0, :-1], found.y[:, -1], end
    exact[-1] = state[0]
    moved = run.z_mass.values - handout.beam.rise
    flying = exact > 0.02 * exact.max()
    assert flying.mean() > 0.5
    np.testing.assert_allclose(moved[flying], exact[flying], atol=5e-4 * exact.max())


@pytest.mark.parametrize(
    ("shape", "ratio", "peak"), [("versed sine", 1.0, 1.705), ("half sine", 0.81, 1.768)]
)
def test_shock_spectra_are_those_of_another_code(shape, ratio, peak):
    """Largest answer of an undamped oscillator of period T to a pulse of duration tau."""
    rate, lasts = 20_000, 1.0
    time = np.arange(0, 4 * lasts, 1 / rate)
    drawn = make_pulse(shape).at(time / lasts)
    ratios = np.array([ratio - 0.02, ratio, ratio + 0.02])
    found = srs.srs(drawn, rate, ratios / lasts, 1e6, ic="zero")
    assert found[1] == pytest.approx(peak, abs=2e-3)
    assert found[1] >= found[[0, 2]].max() - 1e-3


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
def test_a_kink_or_a_jump_leaves_order_two(handout, shape):
    """Of a mass that flies, after the pulse: a jump enters by its mean over a step."""
    f0, runs = 4100.0, []
    for step in (0.8, 0.4, 0.2, 0.1):
        asked = {"pulse": shape, "direction": "-z", "horizon": 30.0, "step": step}
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


def test_a_shock_from_the_other_side_is_one_pushed_back(handout):
    """Either way: the frame's acceleration turned, or the pulse; the weaker side is told."""
    asked = {"f0": [5000.0], "C": [0.025], "model": "cosines"}
    both = snapmap.threshold(handout, **asked, direction="both").squeeze()
    assert both.N_first.sel(direction="-z") < 0.7 * both.N_first.sel(direction="+z")
    alone = snapmap.threshold(handout, **asked, direction="-z").squeeze()
    assert alone.N_first.item() == both.N_first.sel(direction="-z").item()
    N = both.N_first.sel(direction="-z").item() * np.array([0.997, 1.0])
    cube = snapmap.sweep(handout, N, **asked, direction="-z", until="snap")
    assert cube.t_snap.notnull().values.ravel().tolist() == [False, True]
    with pytest.raises(ValueError, match=r"N: \[-600.0\] is not .*direction -z"):
        snapmap.sweep(handout, [-600.0], **asked)
    with pytest.raises(ValueError, match=r"highest: -900.0 is not a number above 0"):
        snapmap.threshold(handout, **asked, highest=-900.0)


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
    plain = snapmap.sweep(handout, **asked, pulse="versed sine")
    np.testing.assert_array_equal(plain.t_snap, snapmap.sweep(handout, **asked).t_snap)


def write(path, time, acceleration, header="time (ms),acceleration (g)"):
    rows = (f"{t!r},{a!r}" for t, a in zip(time.tolist(), acceleration.tolist(), strict=True))
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def test_a_recorded_half_sine_is_a_half_sine(handout, tmp_path):
    """By CSV and UFF, whatever its peak, with its own duration and stretched to another."""
    x = np.linspace(0, 1, 401)
    path = write(tmp_path / "half.csv", 0.5 * x, 37.0 * np.sin(np.pi * x))
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

    uff = tmp_path / "half.uff"
    data = pyuff.prepare_58(
        func_type=1,
        abscissa_spec_data_type=17,
        ordinate_spec_data_type=12,
        num_pts=x.size,
        abscissa_spacing=0,
        abscissa_min=0.0,
        abscissa_inc=0.0,
        ord_data_type=4,
        binary=0,
        x=5e-4 * x,
        data=9.81 * np.sin(np.pi * x),
        rsp_node=1,
        rsp_dir=3,
        ref_node=1,
        ref_dir=3,
        orddenom_spec_data_type=0,
    )
    pyuff.UFF(str(uff)).write_sets(data, "overwrite")
    again = snapmap.read_pulse(uff)
    assert again.duration == pytest.approx(500.0, rel=1e-5)
    assert again.peak == pytest.approx(9.81e-6, rel=1e-5)
    np.testing.assert_allclose(again.at(x), pulse.at(x), atol=1e-5)


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


def test_a_record_is_told_what_it_lacks(handout):
    time = np.linspace(0, 500, 21)
    jump = sampled(time, np.linspace(1, 0, 21))
    assert jump.ends == (1.0, 0.0) and "begins at 100% of its peak" in jump.notes[0]
    shifted = np.where(time < 100, 0.02, np.sin(np.pi * np.clip((time - 100) / 400, 0, 1)))
    assert any("rests at 2.0% of its peak before" in one for one in sampled(time, shifted).notes)
    assert "rests at 2.0% of its peak after" in sampled(time, shifted[::-1]).notes[-1]
    smooth = sampled(time, np.sin(np.pi * time / 500))
    assert smooth.doubts(handout.own_frequency, 500.0) == []
    assert "coarse for a period" in smooth.doubts(handout.own_frequency, 5000.0)[0]
    fine = np.linspace(0, 500, 401)
    for swings in (60, 20, 0):  # of a record that rings there is no noise
        whole = np.sin(np.pi * fine / 500) * (1 + 0.3 * np.sin(2 * np.pi * swings * fine / 500))
        assert not sampled(fine, whole).notes
    noise = 0.03 * np.random.default_rng(1).standard_normal(399)
    (told,) = sampled(fine, whole + np.pad(noise, 1)).notes
    assert re.fullmatch(r"has noise of 2\.\d% of its peak, .* N scales; filter it", told)


@pytest.mark.parametrize(
    ("content", "wanted"),
    [
        ("", "is empty"),
        ("time,acceleration\n0,0\n1,0\n", "header 'time' names no unit"),
        ("time (fortnights),a (g)\n0,0\n", "unit 'fortnights' is unknown"),
        ("time (ms),a (g)\n0,0\n", "1 samples are no shock"),
        ("time (ms),a (g)\n", "0 samples are no shock"),
        (
            "time (ms),a (g)\n0,0\n1,nan\n2,0\n",
            "line 3, column acceleration: 'nan' is no finite",
        ),
        (
            "time (ms),a (g)\n0,0\n1,fast\n2,0\n",
            "line 3, column acceleration: 'fast' is no ",
        ),
        ("time (ms),a (g)\n0,0\n2,1\n1,0\n", "time of sample 3 is not after the one before"),
        ("time (ms),a (g)\n0,0\n1,1\n1,0\n", "time of sample 3 is not after the one before"),
        ("time (ms),a (g)\n0,0\n1,0\n", "the acceleration is 0 throughout"),
        ("time (ms),a (g)\n0,0\n1,1\n2,1\n", "ends at 100% of its peak"),
        (
            "time (ms);a (g)\n0;0\n0,1;1\n",
            "line 3, column time: '0,1' is no .* number; write decimals with",
        ),
        ("time (ms),a (g)\n0,0,1,5\n", "line 2: has more than 2 columns; write decimals with"),
        ("time (ms),a (g)\n0,0\n0,1,5\n", "in line 3, saw 3 .*; write decimals with a point"),
        ("time (ms),a (g),b (g)\n0,0,0\n", "has 3 columns; write 2"),
    ],
)
def test_what_is_no_recorded_shock_is_said_in_one_line(tmp_path, content, wanted):
    path = tmp_path / "shock.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match=wanted) as fault:
        snapmap.read_pulse(path)
    assert "\n" not in str(fault.value) and str(path) in str(fault.value)


def test_a_record_that_is_too_long_or_not_there_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"none.csv' is not the path of a file that is there"):
        snapmap.read_pulse(tmp_path / "none.csv")
    with pytest.raises(ValueError, match=r"is no file"):
        snapmap.read_pulse(tmp_path)
    long = tmp_path / "long.csv"
    with open(long, "wb") as file:
        file.truncate(2_000_000_000)  # as 1e8 samples have; it takes no room
    with pytest.raises(ValueError, match=r"has 2000 MB; write at most 1000000 samples"):
        snapmap.read_pulse(long)
    monkeypatch.setattr("snapmap.io.recorded.MOST_SAMPLES", 100)
    path = write(tmp_path / "many.csv", np.arange(200.0), np.zeros(200))
    with pytest.raises(ValueError, match=r"has more than 100 rows"):
        snapmap.read_pulse(path)
    other = tmp_path / "other.uff"
    other.write_text("no universal file", encoding="utf-8")
    with pytest.raises(ValueError, match=r"other.uff: "):
        snapmap.read_pulse(other)


@pytest.mark.parametrize(
    ("asked", "wanted"),
    [
        ({"pulse": "square"}, "pulse: 'square' is not one of versed sine, half sine"),
        ({"pulse": []}, "pulse: \\[\\] is not one of"),
        ({"pulse": ["half sine", "half sine"]}, "a shape comes twice"),
        ({"pulse": 3}, "pulse: 3 is not one of"),
        ({"direction": "up"}, "direction: 'up' is not"),
        ({"direction": []}, "direction: \\[\\] is not"),
    ],
)
def test_what_is_no_pulse_is_said_in_one_line(handout, asked, wanted):
    with pytest.raises(ValueError, match=wanted):
        snapmap.sweep(handout, [900.0], [1500.0], [25.0], model="cosines", **asked)


def test_files_say_which_pulse_they_are_of(handout):
    asked = {"N": [700.0], "f0": [1500.0], "C": [25.0], "model": "cosines", "horizon": 0.0}

    def section(**push):
        return json.loads(snapmap.sweep(handout, **asked, **push).attrs["config"]).get("pulse")

    assert section() is None and section(pulse="versed sine", direction="+z") is None
    assert section(direction="both") == {"direction": "both"}
    assert section(pulse=["half sine", "sawtooth"]) == {"shape": ["half sine", "sawtooth"]}
    ramp = make_pulse("trapezoid", rise=0.25)
    assert section(pulse=ramp, direction="-z") == {
        "shape": "trapezoid",
        "rise": "25 %",
        "direction": "-z",
    }


def test_trapezoids_rise_and_fall_as_asked():
    pulse = make_pulse("trapezoid", rise=0.5, fall=0.5)
    np.testing.assert_allclose(pulse.at(np.array([0.25, 0.5, 0.75])), [0.5, 1, 0.5])
    for shares in ({"rise": 0.6, "fall": 0.5}, {"rise": 0.0}, {"fall": True}):
        with pytest.raises(ValueError, match=r"pulse\.(rise|fall): "):
            make_shocks({"shape": "trapezoid", **shares})
    with pytest.raises(ValueError, match=r"pulse.rise: is of a trapezoid alone"):
        make_shocks({"shape": "half sine", "rise": 0.1})


def test_hard_contact_takes_every_shape(handout):
    """Labels 0.3 % below and above each threshold, as another discretisation sees them."""
    hard = dataclasses.replace(handout, contact=np.inf, mass=1.5e4)
    for shape in SHAPES:
        found = snapmap.threshold(hard, [800.0], [40.0], pulse=shape).squeeze()
        N = found.N_first.item() * np.array([0.997, 1.003])
        cube = snapmap.sweep(
            hard, N, [800.0], [40.0], model="elements", elements=12, modes=8, pulse=shape
        )
        assert cube.t_snap.notnull().values.ravel().tolist() == [False, True], shape

"""The value of a device that puts its threshold where it is wanted."""

import numpy as np
import pytest
from small_studies import cases_of

import snapmap
from snapmap import Study
from snapmap.applications.design.design import PARTS, _guess

CASES = cases_of(__file__)
CHEAP = {"model": "3 cosines", "horizon": 300.0}
SHOCK = {"f0": 1000.0, "C": 25.0}


@pytest.mark.parametrize(("value", "N", "low", "high", "step"), CASES["values"])
def test_the_threshold_at_the_designed_value_is_wanted(handout, value, N, low, high, step):
    """Its error bar is that of the threshold over its slope."""
    damper = {} if value == "C" else {"C": 25.0}
    goal = {"N": N, "f0": 1000.0, "between": (low, high)}
    designed = snapmap.design(Study(handout, **CHEAP), value, **goal, **damper)
    around = designed.value + step * np.array([-1, 0, 1])
    axes = {"C": around} if value == "C" else {"C": 25.0, "axes": {value: around}}
    near = snapmap.threshold(Study(handout, **CHEAP), [1000.0], **axes).squeeze()
    assert near.N_first[1].item() == pytest.approx(N, rel=2e-4)
    slope = (near.N_first[2] - near.N_first[0]).item() / (2 * step)
    assert designed.error == pytest.approx(near.N_error[1].item() / slope, rel=0.5)
    assert 0 < designed.error < 0.02 * designed.value


def test_a_design_says_that_there_are_several_solutions(handout, monkeypatch):
    with pytest.raises(ValueError, match=r"^C: is the value that design searches; leave it out$"):
        snapmap.design(Study(handout, **CHEAP), "C", N=1000, between=(10.0, 400.0), **SHOCK)

    def parabola(which, values, *_):
        N_first = 1000 + (values - 1.3) * (values - 2.2)
        return N_first, np.full(values.shape, 1e-4), N_first <= 1000

    finder = "snapmap.applications.design.design._threshold_finder"
    monkeypatch.setattr(finder, lambda *_: parabola)
    with pytest.warns(UserWarning, match="not monotone; at 1.3, 2.2 um") as warned:
        designed = snapmap.design(handout, "thickness", N=1000, between=(1.0, 3.0), **SHOCK)
    assert designed.value == pytest.approx(1.3, abs=1e-5) and warned[0].filename == __file__


@pytest.fixture
def linear(monkeypatch):
    """Thresholds of 1000 times the thickness, +- 5, and 10 from 1.5 um on; from 2.5 um none."""

    def at(study, values, f0, C, pulse_of, axes):
        value = values["thickness"]
        exists = value < 2.5
        error = np.where(value < 1.5, 5.0, 10.0)
        return np.where(exists, 1e3 * value, np.nan), np.where(exists, error, np.nan), exists

    monkeypatch.setattr("snapmap.applications.design.design.thresholds_at", at)


LINEAR, SIDES = {"between": (1.0, 3.0), "C": 25.0}, ("low", "high")


@pytest.mark.usefixtures("linear")
@pytest.mark.parametrize(("needs", "between", *SIDES), CASES["windows"])
def test_ends_of_windows_are_exact_with_their_errors(handout, needs, between, low, high):
    """Half a part of an interval beside the bar; without thresholds beyond, half a part alone.

    Some lie in parts at ends of intervals, of which thresholds are known.
    """
    snaps = {"trip": True, "arrive": "arrives", "stay": False}
    asked = [require(name, N, snaps[name]) for name, N in needs.items()]
    made = snapmap.design(handout, "thickness", requirements=asked, between=between, C=25.0)
    part = (between[1] - between[0]) / 32 / 512
    for side, (value, source) in zip(SIDES, (low, high), strict=True):
        bar = part / 2 + (value < 2.5) * (0.01 if value > 1.5 - part else 0.005)
        end, error, name = made[side], made[f"{side}_error"], made[f"{side}_from"]
        assert end.item() == pytest.approx(value, abs=part if value == 2.5 else 1e-9)
        assert error.item() == pytest.approx(bar * (source != "between")) and name.item() == source
        assert end.units == error.units == "um" and not name.attrs
    within = (made.tried >= low[0]) & (made.tried <= high[0]) & (made.tried < 2.5)
    assert (made.met.all("requirement") == within).all()


@pytest.mark.usefixtures("linear")
def test_a_value_of_linear_thresholds_is_exact(handout):
    made = snapmap.design(handout, "thickness", N=1503, f0=1e3, **LINEAR)
    assert made.value == pytest.approx(1.503) and made.error == pytest.approx(0.01 + 1 / 8 / 1024)
    both = [require("stay", 1500.0, False) | {"direction": "both"}]
    made = snapmap.design(handout, "thickness", requirements=both, **LINEAR)
    assert made.requirement.values.tolist() == ["stay, versed sine +z", "stay, versed sine -z"]


@pytest.mark.usefixtures("linear")
@pytest.mark.parametrize(("wrong", "line"), CASES["wrong"])
def test_what_a_design_lacks_or_cannot_reach_is_told(handout, wrong, line):
    with pytest.raises(ValueError, match=line):
        snapmap.design(handout, "thickness", **{"N": 900, "f0": 1e3, **LINEAR, **wrong})


def test_the_part_of_an_interval_that_has_a_threshold_is_guessed_by_a_cubic():
    """Exact where the place is a cubic of the threshold; half way where that is not known."""
    k, share = np.array([0, 1, 4, 7]), np.array([0.3, 0.001, 1.0, 0.7])
    grid = np.cbrt(np.arange(1.0, 10.0))
    guess = _guess(np.tile(grid, (4, 1)), k, np.cbrt(1 + k + share - 1e-9))
    assert guess.tolist() == np.ceil(PARTS * share).tolist()
    N_first = np.stack([grid, grid, np.where(grid > 2, np.nan, grid)])
    assert _guess(N_first, k[[0, 1, 3]], np.array([0.5, 9.0, 2.0])).tolist() == [1, 512, 256]


def require(name, N, snaps):
    return {"name": name, "N": N, "snaps": snaps, "f0": 1500.0, "pulse": "versed sine"}


@pytest.mark.parametrize(("value", "stays", "trips", "asked"), CASES["between"])
def test_all_are_met_in_a_window_between_the_values_for_each(handout, value, stays, trips, asked):
    needs = [require("trip", trips, True), require("stay", stays, False)]
    window = snapmap.design(Study(handout, **CHEAP), value, requirements=needs, **asked)
    for end, N in (("low", stays), ("high", trips)):
        alone = snapmap.design(Study(handout, **CHEAP), value, N=N, f0=1500.0, **asked)
        error = alone.error + window[f"{end}_error"].item()
        assert abs(window[end].item() - alone.value) <= error
    assert (window.low_from.item(), window.high_from.item()) == ("stay", "trip")


@pytest.mark.usefixtures("linear")
def test_a_contradiction_says_where_each_requirement_is_met(handout):
    needs = [require("trip", 1100.0, True), require("stay", 1300.0, False)]
    needs.append(require("never", 9e5, False))
    with pytest.warns(UserWarning) as warned:
        window = snapmap.design(handout, "thickness", requirements=needs, **LINEAR)
    assert window.sizes["window"] == 0 and warned[0].filename == __file__
    assert str(warned[0].message) == (
        "thickness: none from 1 to 3 um meets all requirements, at most 1 of 3 at 1 um: trip is "
        "met from 1 to 1.062, stay is met from 1.312 to 2.438, never is met nowhere"
    )


@pytest.mark.parametrize(("wrong", "line"), CASES["wrong requirements"])
def test_a_requirement_that_a_design_cannot_meet_is_named(handout, wrong, line):
    needs = [require("trip", 1100.0, True), require("stay", 1300.0, False) | wrong]
    with pytest.raises(ValueError, match=line):
        snapmap.design(Study(handout, **CHEAP), "thickness", requirements=needs, **LINEAR)

"""The value of a device that puts its threshold where it is wanted."""

import re
from dataclasses import replace

import numpy as np
import pytest

import snapmap
from snapmap.applications.design.design import _ends, _single, _single_shocks, remedy
from snapmap.pulse.shocks import make_shocks
from snapmap.study.study import Study, with_shocks
from snapmap.thresholds.population import thresholds_at

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}
SHOCK = {"f0": 1000.0, "C": 25.0}


def test_the_threshold_at_the_value_found_is_the_one_asked_for(handout):
    found = snapmap.design(handout, "thickness", N=1300, between=(2.0, 2.4), **SHOCK, **CHEAP)
    made = replace(handout, beam=replace(handout.beam, thickness=found.value))
    told = snapmap.threshold(made, [1000.0], [25.0], **CHEAP)
    assert told.N_first.item() == pytest.approx(1300, rel=2e-4)
    assert 0 < found.error < 0.01 * found.value
    # The error bar is the threshold's over its slope.
    around = snapmap.threshold(handout, [1000.0], [25.0], thickness=[2.1, 2.3], **CHEAP)
    slope = np.diff(around.N_first.squeeze()).item() / 0.2
    assert found.error == pytest.approx(told.N_error.item() / slope, rel=0.5)


@pytest.mark.parametrize(("N", "snaps"), [(1300.0, False), (800.0, True)])
def test_each_remedy_brings_the_threshold_to_its_side(handout, N, snaps):
    """With the mass, the spring or the beam as the line says, to a percent."""
    study = Study(device=handout, model={"name": "cosines", "modes": 3})
    goal = {"N": N, "f0": 1000.0, "snaps": snaps, "shocks": study.shocks}
    first = snapmap.threshold(handout, [1000.0], [25.0], **CHEAP).N_first.item()
    changes = remedy(study, goal, 25.0, first)
    assert {key for _, key, _ in changes} >= {"mass", "thickness"}
    for words, key, number in changes:
        name, percent, word = re.fullmatch(r"a (mass|spring|beam) (\d+)% (\w+)", words).groups()
        assert {"beam": "thickness"}.get(name, name) == key
        sign = 1 if word in ("heavier", "stiffer", "thicker") else -1
        value = {"thickness": handout.beam.thickness}.get(key) or getattr(handout, key)
        said = value * (1 + sign * float(percent) / 100)
        assert number == pytest.approx(said, abs=0.005 * value)
        for other in (number, said):
            first = thresholds_at(study, {key: np.array([other])}, 1000.0, 25.0)[0]
            assert (first <= N) == snaps


def test_the_damper_that_puts_the_threshold_where_it_is_wanted(handout):
    shock = {"N": 1000, "f0": 1000.0, **CHEAP}
    found = snapmap.design(handout, "C", between=(10.0, 400.0), **shock)
    C = [found.value - 10, found.value, found.value + 10]
    told = snapmap.threshold(handout, [1000.0], C, **CHEAP).squeeze()
    assert told.N_first[1].item() == pytest.approx(1000, rel=2e-4)
    slope = (told.N_first[2] - told.N_first[0]).item() / 20
    assert found.error == pytest.approx(told.N_error[1].item() / slope, rel=0.5)
    with pytest.raises(ValueError, match=r"^C: is the value that design searches; leave it out$"):
        snapmap.design(handout, "C", between=(10.0, 400.0), C=25.0, **shock)


def test_no_solution_and_several_are_said(handout):
    with pytest.raises(ValueError, match=r"thickness: no value from 1.9 to 2.1 um .* it runs from"):
        snapmap.design(handout, "thickness", N=9000, between=(1.9, 2.1), **SHOCK, **CHEAP)

    def parabola(_, values):
        N_first = 1000 + (values - 1.3) * (values - 2.2)
        return N_first, np.full(values.shape, 1e-4), N_first <= 1000

    grid = np.linspace(1.0, 3.0, 17)
    seen = parabola(None, grid[np.newaxis])
    _, values, errors = _ends(parabola, grid, *seen, np.ones((1, 16), bool), 1000.0)
    np.testing.assert_allclose(values, [1.3, 2.2], atol=1e-5)
    with pytest.warns(UserWarning, match="not monotone; at 1.3, 2.2 um"):
        design = _single("thickness", 1000.0, grid, seen[0], values, errors)
    assert design.value == pytest.approx(1.3)


def require(name, N, snaps):
    shock = {"N": N, "f0": 1500.0, "pulse": "versed sine"}
    return shock | {"name": name, "snaps": snaps}


@pytest.mark.parametrize(
    ("value", "stays", "trips", "shock"),
    [
        ("thickness", 1100.0, 1300.0, {"between": (1.8, 2.5), "C": 25.0}),
        ("C", 1010.0, 1060.0, {"between": (5.0, 400.0)}),
    ],
)
def test_the_window_in_which_all_requirements_are_met(handout, value, stays, trips, shock):
    needs, shock = [require("trip", trips, True), require("stay", stays, False)], shock | CHEAP
    found = snapmap.design(handout, value, requirements=needs, **shock)
    for end, N in (("low", stays), ("high", trips)):
        alone = snapmap.design(handout, value, N=N, f0=1500.0, **shock)
        error = alone.error + found[f"{end}_error"].item()
        assert abs(found[end].item() - alone.value) <= error
    assert (found.low_from.item(), found.high_from.item()) == ("stay", "trip")


def test_requirements_have_the_shocks_of_the_study_unless_they_name_theirs(handout):
    asked = {"name": "drop", "N": 900.0, "f0": 1000.0, "snaps": False}
    shocks = make_shocks(["half sine", "sawtooth"], "-z")
    required = with_shocks(asked, shocks)
    assert [one.pulse.name for one in required["shocks"].each()] == ["half sine", "sawtooth"]
    assert required["shocks"].directions == ("-z",)
    back = with_shocks(asked | {"pulse": "trapezoid", "direction": "both"}, shocks)["shocks"]
    assert [(one.pulse.name, one.direction) for one in back.each()] == [
        ("trapezoid", "+z"),
        ("trapezoid", "-z"),
    ]
    assert [one["name"] for one in _single_shocks([required])] == [
        "drop, half sine -z",
        "drop, sawtooth -z",
    ]
    record = {"train": [{"duration": 300.0}, {"wait": 900.0}, {"repeat": 2}]}
    within = {"C": 25.0, "between": (1.8, 2.5), "requirements": [asked]} | CHEAP
    with pytest.raises(ValueError, match="requirements: drop: pulse: missing, as the study"):
        snapmap.design(handout, "thickness", pulse=record, **within)
    within["requirements"] = [asked | {"snaps": "any"}]
    with pytest.raises(ValueError, match="requirements: drop: snaps: any has no threshold"):
        snapmap.design(handout, "thickness", **within)


def test_a_contradiction_says_where_each_requirement_is_met(handout):
    needs = [require("trip", 1100.0, True), require("stay", 1300.0, False)]
    needs.append(require("never", 9e5, False))
    with pytest.warns(UserWarning) as warned:
        found = snapmap.design(
            handout, "thickness", requirements=needs, between=(1.8, 2.5), C=25.0, **CHEAP
        )
    assert found.sizes["window"] == 0
    trip, stay = (found.tried.values[row] for row in found.met.values[:2].astype(bool))
    assert str(warned[0].message) == (
        "thickness: none from 1.8 to 2.5 um meets all requirements, at most 1 of 3 at 1.8 um: "
        f"trip is met from 1.8 to {trip.max():.4g}, stay is met from {stay.min():.4g} to 2.5, "
        "never is met nowhere"
    )

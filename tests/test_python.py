"""The functions of the package: what there is, and what a wrong call says."""

import doctest

import numpy as np
import pytest

import snapmap

CELL = {"N": [1000.0], "f0": [1500.0], "C": [25.0]}


@pytest.mark.parametrize("name", snapmap.__all__)
def test_the_example_of_each_function_is_true(root, monkeypatch, name):
    monkeypatch.chdir(root)
    function = getattr(snapmap, name)
    (example,) = doctest.DocTestFinder().find(function, name, globs={"snapmap": snapmap})
    assert example.examples
    assert doctest.DocTestRunner().run(example).failed == 0


@pytest.mark.parametrize(
    ("wrong", "start"),
    [
        ({"f0": ["1500 Hz"]}, "f0: ['1500 Hz'] is no number"),
        ({"f0": [0.0]}, "f0: 0 cannot be; it must be finite and above 0"),
        ({"N": [np.nan]}, "N: nan cannot be"),
        ({"C": [-1.0]}, "C: -1 cannot be; it must be finite and 0 or above"),
        ({"C": []}, "C: empty"),
        ({"horizon": "1500 us"}, "sweep.horizon: '1500 us' is not a number"),
        ({"horizon": True}, "sweep.horizon: True is not a number"),
        ({"until": "later"}, "sweep.until: 'later' is not one of"),
        ({"energy_tolerance": "1 %"}, "sweep.energy_tolerance: '1 %' is not a number"),
        ({"model": "spline"}, "model.name: 'spline' is unknown"),
        ({"model": "cosines", "modes": "three"}, "model.modes: 'three' is not a number"),
        ({"model": "cosines", "modes": 2.5}, "model.modes: 2.5 is not a whole number"),
        ({"elements": True}, "model.elements: True is not a number"),
    ],
)
@pytest.mark.parametrize("function", ["sweep", "simulate", "threshold"])
def test_a_wrong_argument_is_one_line(handout, function, wrong, start):
    given = {"model": "handout", **CELL, **wrong}
    if function == "threshold":
        del given["N"]
        if wrong.keys() & {"N", "until"}:
            pytest.skip("not an argument of threshold")
    if function == "simulate":
        single = {key: given[key][0] for key in CELL if given[key]}
        given |= single
    with pytest.raises(ValueError) as fault:
        getattr(snapmap, function)(handout, **given)
    assert str(fault.value).startswith(start) and "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("wrong", "start"),
    [
        ({"tolerance": "1 %"}, "tolerance: '1 %' is not a number"),
        ({"highest": "2"}, "highest: '2'"),
    ],
)
def test_a_threshold_is_asked_for_in_numbers(handout, wrong, start):
    with pytest.raises(ValueError, match=f"^{start}"):
        snapmap.threshold(handout, [1500.0], [25.0], **wrong)


def test_a_device_is_asked_for():
    with pytest.raises(ValueError, match=r"^device: 'handout' is no device"):
        snapmap.sweep("handout", **CELL)

"""The value of a device that puts its threshold where it is wanted."""

from dataclasses import replace

import numpy as np
import pytest

import snapmap
from snapmap.thresholds.design import _single, _solve

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


def test_along_another_value_the_answer_is_a_line(handout):
    rise = [6.0, 10.0]
    asked = {"N": 1100, "between": (2.0, 2.2), "rise": rise}
    line = snapmap.design(handout, "thickness", **asked, **SHOCK, **CHEAP)
    assert line.thickness.dims == ("rise",) and line.thickness[0].isnull()
    alone = snapmap.design(handout, "thickness", N=1100, between=(2.0, 2.2), **SHOCK, **CHEAP)
    assert line.thickness[1].item() == pytest.approx(alone.value, abs=2 * alone.error)


def test_no_solution_and_several_are_said(handout):
    with pytest.raises(ValueError, match=r"thickness: no value from 1.9 to 2.1 um .* it runs from"):
        snapmap.design(handout, "thickness", N=9000, between=(1.9, 2.1), **SHOCK, **CHEAP)

    def parabola(values, _):
        return (values - 1.3) * (values - 2.2), np.full(values.size, 1e-4)

    found = _solve(parabola, (1.0, 3.0), 1)
    np.testing.assert_allclose(found.value, [1.3, 2.2], atol=1e-5)
    with pytest.warns(UserWarning, match="not monotone; at 1.3, 2.2 um"):
        assert _single("thickness", 1000.0, (1.0, 3.0), found).value == pytest.approx(1.3)


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ({"value": "width"}, "width: no value of a device"),
        ({"between": (2.4, 1.9)}, "between: 2.4, 1.9 are not two ascending"),
        ({"N": -1.0}, "N: -1 is not above 0"),
        ({"thickness": [2.0]}, "thickness: give one value"),
        ({"direction": "both"}, "pulse: several"),
    ],
)
def test_what_cannot_be_is_named(handout, change, wanted):
    asked = {"value": "thickness", "N": 1100, "between": (1.9, 2.4), **SHOCK, **CHEAP} | change
    with pytest.raises(ValueError, match=wanted.replace("(", r"\(")):
        snapmap.design(handout, **asked)

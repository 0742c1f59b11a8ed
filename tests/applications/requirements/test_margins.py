"""The figure of margins."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from small_results import artists, drawn

from snapmap.applications.requirements import figure as requirements

pytestmark = pytest.mark.usefixtures("paper")


def test_margins_of_requirements_are_the_data_with_their_bars():
    verdicts = [
        {"requirement": "drop", "margin": 0.8, "margin_error": 0.01, "verdict": "met"},
        {"requirement": "back", "margin": np.nan, "margin_error": np.nan, "verdict": "met"},
        {"requirement": "shelf", "margin": 0.9, "margin_error": 0.02, "verdict": "failed"},
    ]
    for row, breaks, must in zip(verdicts, [0.0, 1e-4, 0.01], [True, False, False], strict=True):
        row |= {"device": "", "C": 25.0, "must_snap": must}
        row |= {"must_survive": 0.999, "break_probability": breaks, "start": "first"}
        row |= {"shape": "half sine", "direction": "-z", "temperature": -40.0}
    ax = drawn(requirements.draw_margins, verdicts)
    points = [line.get_xydata()[0].tolist() for line in ax.lines if line.get_marker() in "oX"]
    assert points == [[0.9, 0.0], [0.8, 1.0]]  # by slack, the failed first
    bars = [bar.get_segments()[0][:, 0].tolist() for bar in artists(ax, LineCollection)]
    assert bars == [pytest.approx([0.88, 0.92]), pytest.approx([0.79, 0.81])]
    assert [text.xy[1] for text in ax.texts] == [0, 2]  # breaks; no threshold
    any_way = verdicts[0] | {"must_snap": "any", "margin": 1.1}
    verdicts += [verdicts[2] | {"margin": 1.2, "verdict": "met"}, any_way | {"requirement": "hit"}]
    ax = drawn(requirements.draw_margins, verdicts)
    dots = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "."]
    assert [one for one in dots if one] == [[[1.2, 0.0]]]  # the corner that fails is in front
    assert len(ax.get_yticklabels()) == 4

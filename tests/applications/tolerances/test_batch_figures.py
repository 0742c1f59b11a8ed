"""Figures of devices as made: probabilities, sensitivities, yields."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from small_results import ATTRIBUTES, F0, artists, drawn

from snapmap.applications.tolerances import figure as tolerances

pytestmark = pytest.mark.usefixtures("paper")


def make_batch(f0=F0):
    """Thresholds of four devices under one damper, of which one never snaps."""
    N_first = np.array([900.0, 1000.0, 1100.0, np.nan])[:, np.newaxis, np.newaxis]
    N_first = np.tile(N_first, (1, 1, f0.size)) + np.arange(f0.size)
    of_f0, N = ("C", "f0"), np.linspace(800, 1200, 9)
    share = np.mean(N_first[..., np.newaxis] <= N, axis=0)
    index = np.stack([np.full((2, 1, f0.size), 0.9), np.full((2, 1, f0.size), 0.1)], axis=1)
    variables = {
        "bistable": ("sample", [1, 1, 1, 0]),
        "N_first": (("sample", *of_f0), N_first),
        "N_nominal": (of_f0, N_first[1]),
        "N_quantile": (("quantile", *of_f0), np.tile(N_first[1], (5, 1, 1))),
        "probability": ((*of_f0, "N"), share),
        "probability_bound": (("bound", *of_f0, "N"), np.stack([share / 2, share])),
        "sensitivity": (("order", "value", *of_f0), index),
        "sensitivity_bound": (("bound", "order", "value", *of_f0), np.stack([index, index + 0.2])),
        "N_first_required": (("requirement", "sample", "C"), N_first[np.newaxis, :, :, 0]),
        "N_required": ("requirement", [1050.0]),
        "must_snap": ("requirement", [1]),
        "share_meeting": (("requirement", "C"), [[0.5]]),
        "share_meeting_bound": (("bound", "requirement", "C"), [[[0.15]], [[0.85]]]),
        "yield": ("C", [0.4]),
        "yield_bound": (("bound", "C"), [[0.4], [0.9]]),
    }
    axes = {"C": [25.0], "f0": f0, "N": N, "quantile": list(tolerances.LINES)}
    axes |= {"order": ["first", "total"], "value": ["thickness+depth", "N"]}
    return xr.Dataset(variables, axes | {"requirement": ["drop"]}, ATTRIBUTES)


def test_devices_as_made_are_drawn_as_they_are():
    found = make_batch().isel(C=0)
    ax = drawn(tolerances.draw_probability, found)
    (field,) = ax.collections
    np.testing.assert_allclose(field.get_array(), found.probability.transpose("N", "f0"))
    assert len(ax.lines) == len(tolerances.LINES) + 1
    np.testing.assert_allclose(ax.lines[-1].get_ydata(), found.N_nominal)
    ax = drawn(tolerances.draw_sensitivity, found)
    shown = [line.get_ydata()[0] for line in ax.lines if len(line.get_ydata()) == F0.size]
    assert sorted(shown) == [0.1, 0.1, 0.9, 0.9]
    bars = [bar.get_segments()[0][1, 1] for bar in artists(ax, LineCollection)]
    assert bars == pytest.approx([1.0, 0.3])


def test_yields_and_requirements_are_drawn_as_they_are():
    ax = drawn(tolerances.draw_yield, make_batch())
    assert ax.lines[0].get_xydata().tolist() == [[0.5, 0.0], [0.4, 1.0]]
    low, high = ax.get_xlim()
    assert 0.05 < low < 0.15 and high > 1  # about the bounds, 0.15 to 0.9, and 1
    ax = drawn(tolerances.draw_requirement, make_batch().isel(C=0, requirement=0))
    assert sum(patch.get_height() for patch in ax.patches[1:]) == 3
    assert ax.patches[0].get_x() == 1050.0
    found = make_batch(np.array([1500.0])).isel(C=0)
    ax = drawn(tolerances.draw_probability, found)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), found.probability.squeeze())

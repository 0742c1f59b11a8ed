"""The figure of a history."""

import math

import numpy as np
import pytest
import xarray as xr
from small_results import ATTRIBUTES

from snapmap.applications.histories import figure as histories
from snapmap.figures import style

pytestmark = pytest.mark.usefixtures("paper")


def make_history(w_mid):
    """A history whose midpoint takes these positions, 10 us apart, 1 um below the mass."""
    w_mid = np.array(w_mid, float)
    values = {"w_mid": w_mid, "z_mass": w_mid + 1, "contact_force": 0 * w_mid}
    values["acceleration"] = np.full(w_mid.size, 0.02)
    variables = {key: ("time", column) for key, column in values.items()}
    attributes = ATTRIBUTES | {"second_equilibrium": -9.0, "gravity": 1e-5}
    attributes |= {"N": 1000.0, "f0": 1500.0, "C": 0.025}
    return xr.Dataset(variables, {"time": 10.0 * np.arange(w_mid.size)}, attributes)


def line(ax, label):
    return next(line for line in ax.lines if line.get_label().startswith(label))


def history_of(history):
    figure = style.double_column(height=4.2)
    return histories.draw_history(figure.subplots(3, sharex=True), history)


def test_a_history_is_the_data_in_ms_and_multiples_of_g_and_marks_the_snap():
    history = make_history([10, 0, -8, -12])
    positions, force, shock = axes = history_of(history)
    time = [0.0, 0.01, 0.02, 0.03]
    beam, mass = positions.lines[:2]
    assert beam.get_xydata().tolist() == [[t, w] for t, w in zip(time, history.w_mid, strict=True)]
    assert mass.get_ydata().tolist() == [11, 1, -7, -11]
    assert force.lines[0].get_ydata().tolist() == [0, 0, 0, 0]
    assert shock.lines[0].get_ydata() == pytest.approx([2000, 2000, 2000, 2000])
    assert line(positions, "second").get_ydata() == [-9.0, -9.0]
    assert line(positions, "snap").get_xydata().tolist() == [[0.0225, -9.0]]
    assert all([0.0225, 0.0225] in [list(line.get_xdata()) for line in ax.lines] for ax in axes)
    assert [len(ax.lines) for ax in history_of(make_history([10, 5, 10]))] == [3, 1, 1]


def test_snap_time_is_between_two_samples_or_not_seen():
    assert histories.snap_time(make_history([10, 0, -8, -12, -5, -12])) == 22.5
    assert math.isnan(histories.snap_time(make_history([10, 0, -8.9])))

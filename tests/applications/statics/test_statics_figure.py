"""The figure of force and energy over displacement."""

import numpy as np
import pytest
import xarray as xr
from small_results import ATTRIBUTES, drawn

from snapmap.applications.statics import figure as statics

pytestmark = pytest.mark.usefixtures("paper")


def make_statics():
    """A force that rises to 70, falls through the saddle at 12 um to -30, and rises again."""
    w = np.array([0.0, 2.0, 12.0, 18.0, 19.0, 20.0])
    force = np.array([[0.0, 70.0, 0.0, -30.0, 0.0, 40.0], [0.0, 70.0, 90.0, -30.0, 0.0, 40.0]])
    energy = np.array(
        [[0.0, 70.0, 490.0, 400.0, 385.0, 405.0], [0.0, 70.0, 800.0, 400.0, 385.0, 405.0]]
    )
    axes = ("branch", "point")
    variables = {"displacement": (axes, [w, w]), "force": (axes, force), "energy": (axes, energy)}
    attributes = {"rise": 10.0, "second_equilibrium": -9.0, "saddle": -2.0, "barrier": 490.0}
    attributes |= {"largest_force": 70.0, "least_force": -30.0} | ATTRIBUTES
    return xr.Dataset(variables, {"branch": ["guided", "unbranched"]}, attributes)


def line(ax, label):
    return next(line for line in ax.lines if line.get_label().startswith(label))


def test_statics_are_the_data_and_mark_wells_saddle_and_peaks():
    found = make_statics()
    force = drawn(statics.draw_force_displacement, found)
    energy = drawn(statics.draw_energy, found)
    for ax, values in ((force, found.force), (energy, found.energy)):
        unbranched, followed = ax.lines[:2]
        w = found.displacement.values[0].tolist()
        assert followed.get_xydata().T.tolist() == [w, values[0].values.tolist()]
        assert unbranched.get_ydata().tolist() == values[1].values.tolist()
    assert line(force, "stable").get_xydata().tolist() == [[0.0, 0.0], [19.0, 0.0]]
    assert line(force, "saddle").get_xydata().tolist() == [[12.0, 0.0]]
    assert line(energy, "stable").get_ydata().tolist() == [0.0, 385.0]
    assert line(energy, "saddle").get_ydata().tolist() == [490.0]

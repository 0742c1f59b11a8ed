"""The figure of the damage boundary."""

import numpy as np
import pytest
from matplotlib.patches import Polygon
from small_results import artists, drawn, make_found, visible

from snapmap.applications.boundary import figure as boundary
from snapmap.figures import curves

pytestmark = pytest.mark.usefixtures("paper")


def limits(ax, label):
    return [line for line in ax.lines if line.get_label().startswith(label)]


def test_damage_boundary_shades_what_snaps_of_each_C():
    ax = drawn(boundary.draw_damage_boundary, make_found())
    region, other = artists(ax, Polygon)
    assert other.get_path().vertices[0, 1] == region.get_path().vertices[0, 1] + 1
    snaps = region.get_path().contains_points
    assert snaps([(1.1, 2000.0), (6.0, 1100.0), (50.0, 1010.0), (51.0, 1e5)]).all()
    assert not snaps([(0.9, 1900.0), (5.4, 1000.0), (50.0, 980.0)]).any()
    # Shorter and longer pulses than the curve has.
    assert not snaps([(0.6, 1e5), (1.0, 2100.0), (1e3, 1000.0), (51.0, 1010.0)]).any()


def test_damage_boundary_is_over_the_velocity_change_between_its_limits():
    ax = drawn(boundary.draw_damage_boundary, make_found())
    # N g / (2 f0), with g = 10 m/s^2
    during, late = ax.lines[1:3]
    assert visible(during) == [pytest.approx([50.0, 1000.0]), pytest.approx([5.5, 1100.0])]
    assert visible(late) == [pytest.approx([5.5, 1100.0]), pytest.approx([1.0, 2000.0])]
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert [line.get_xdata()[0] for line in limits(ax, curves.SHORT)] == [0.5, 0.6]
    assert limits(ax, curves.LONG)[0].get_ydata() == [990.0, 990.0]
    guides = [line for line in ax.lines if line.get_color() == boundary.DURATION["color"]]
    v, N = guides[1].get_xydata().T
    assert len(guides) == 3 and N * 1e-5 / v == pytest.approx(np.full(2, 2e-3))

"""The figure of a window."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet

from snapmap.applications.window import figure as window
from snapmap.figures import style

pytestmark = pytest.mark.usefixtures("paper")


def make_window():
    """Trips up to a spring of 6.5, does not from C = 35 on; and a third is met everywhere."""
    spring, C = np.linspace(4.0, 8.0, 5), np.linspace(20.0, 60.0, 4)
    reserve = np.stack(np.broadcast_arrays(6.5 / spring[:, np.newaxis], C / 35, 3.0))
    over = "requirement", "spring", "C"
    data = {key: (over, reserve) for key in ("reserve", "N_first", "stress_max")}
    data["reserve"] = *data["reserve"], {"off_between_points": 0.06}
    data |= {"N_error": (over, reserve / 100), "yield": (over[1:], reserve[0] / 2)}
    data |= {"yield_bound": (("bound", *over[1:]), reserve[:2] / 2)}
    data["must_snap"] = over[0], [1, 0, 0]
    return xr.Dataset(data, {"requirement": ["trip", "stay", "easy"], "spring": spring, "C": C})


def colour_at(ax, *point):
    """The colour in which a point of a window is filled last, if any."""
    layers = [one for one in ax.collections if isinstance(one, ContourSet) and one.filled]
    within = [one for one in layers if one.get_paths()[0].contains_point(point)]
    return to_hex(within[-1].get_facecolor()[0]) if within else None


def test_a_window_ends_on_lines_where_each_requirement_begins_to_fail():
    window.draw_window(figure := style.double_column(4), make_window(), "spring", "C")
    *panels, stress, _ = figure.axes
    assert len(panels) == 2
    lines = [line for line in stress.collections if line.get_path_effects()]
    for line, column, end, straight in zip(lines, (0, 1), (6.5, 35.0), (0.06, 1e-9), strict=True):
        (path,) = line.get_paths()
        assert abs(path.vertices[:, column] - end).max() < straight
    met, failing = (window.MEETING["color"], window.FAILING["color"])
    for ax in panels:
        assert colour_at(ax, 5.0, 50.0) == met
        assert colour_at(ax, 7.0, 50.0) == colour_at(ax, 5.0, 30.0) == failing
        assert colour_at(ax, 7.0, 30.0) == failing
    for ax in (*panels, stress):
        assert (ax.get_xlim(), ax.get_ylim()) == ((4.0, 8.0), (20.0, 60.0))


def test_a_window_reaches_the_point_where_two_lines_meet_at_a_small_angle():
    spring, C = np.meshgrid([1.0, 2.0], [1.0, 2.0], indexing="ij")
    after, before = spring - 0.53, 2.53 - spring + 0.05 * (C - 1.03)
    found = make_window().isel(requirement=[0, 1], spring=[0, 1], C=[0, 1])
    found = found.assign_coords(spring=spring[:, 0], C=C[0]).drop_vars(["yield", "yield_bound"])
    found["reserve"] = found.reserve.copy(data=np.stack([after, before]))
    window.draw_window(figure := style.double_column(4), found, "spring", "C")
    for point in [(1.531, 1.3), (1.54, 1.5), (1.55, 1.9)]:
        assert colour_at(figure.axes[0], *point) == window.MEETING["color"]
    assert colour_at(figure.axes[0], 1.52, 1.5) == window.FAILING["color"]
    assert colour_at(figure.axes[0], 1.56, 1.5) == window.FAILING["color"]


def test_a_window_has_the_units_of_the_config_and_no_colour_where_nothing_is_known():
    found = make_window()
    found["reserve"] = found.reserve.where((found.spring < 8) | (found.C < 60))
    found = found.drop_vars(["yield", "yield_bound", "stress_max"])
    units = {"spring": ("mN/um", 1e3), "C": ("mN*s/m", 1e3)}
    window.draw_window(figure := style.double_column(4), found, "spring", "C", units)
    (ax,) = figure.axes
    assert ax.get_xlim() == (0.004, 0.008) and ax.get_ylim() == pytest.approx((0.02, 0.06))
    assert colour_at(ax, 0.0079, 0.059) is None

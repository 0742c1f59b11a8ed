"""Where over two axes required shocks are met."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet

import snapmap
from snapmap.applications.histories.history import extremes_of
from snapmap.applications.window import figure as window
from snapmap.applications.window.between import PARTS, between, least_reserve
from snapmap.applications.window.window import summary, window_of
from snapmap.device.samples import Tolerances
from snapmap.figures import style
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.settings import Settings
from snapmap.study.study import Study

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}
AXES = {"thickness": np.linspace(1.9, 2.4, 6), "C": [25.0, 60.0]}
SCATTERS = {"thickness": 0.05, "N": "2 %"}
NEEDS = [
    {"name": name, "N": N, "f0": 1500.0, "snaps": snaps, "survives": 0.999, "shocks": make_shocks()}
    for name, N, snaps in (("trip", 1300.0, True), ("stay", 1100.0, False))
]


@pytest.fixture(scope="module")
def study(handout):
    device, model = replace(handout, strength=1e3), {"name": "cosines", "modes": 3}
    return Study(device=device, model=model, settings=Settings(horizon=300.0))


@pytest.fixture(scope="module")
def found(study):
    return window_of(study, AXES, NEEDS, Tolerances(SCATTERS, samples=32))


def test_a_window_ends_where_a_design_does(handout, found):
    asked = {"C": 25.0, "between": (1.9, 2.4), "requirements": NEEDS}
    one, reserve = snapmap.design(handout, "thickness", **asked, **CHEAP), found.reserve.sel(C=25.0)
    for name, end in (("stay", one.low), ("trip", one.high)):
        along = reserve.sel(requirement=name).sortby(reserve.sel(requirement=name))
        assert np.interp(1.0, along, along.thickness) == pytest.approx(end.item(), abs=2e-3)
    met = int((found.reserve.min("requirement") >= 1).sum())
    line = summary(found, {"thickness": ("mm", 1e3), "C": ("uN*us/um", 1.0)})
    assert f"met at {met} of 12 points" in line and " mm, C = " in line


def test_its_yields_and_stresses_are_those_of_one_device(handout, study, found):
    device = replace(handout, beam=replace(handout.beam, thickness=2.1))
    asked = {"requirements": NEEDS, "samples": 32, "index_samples": 2}
    made = snapmap.tolerance(device, SCATTERS, [1500.0], AXES["C"], **asked, **CHEAP)
    here = found.sel(thickness=2.1, method="nearest")
    np.testing.assert_array_equal(here["yield"], made["yield"])
    np.testing.assert_array_equal(here.yield_bound, made.yield_bound)
    for required in NEEDS:
        one = extremes_of(replace(study, device=device), required["N"], 1500.0, 60.0)
        stress = here.stress_max.sel(requirement=required["name"], C=60.0).item()
        assert stress == pytest.approx(one.stress_max, rel=1e-6)


def test_where_the_beam_breaks_a_requirement_fails(study, found):
    limit = found.stress_max.median().item()
    brittle = replace(study, device=replace(study.device, strength=limit))
    reserve = window_of(brittle, AXES, NEEDS).reserve
    np.testing.assert_array_equal(reserve, found.reserve.where(found.stress_max < limit, 0))
    # With a strength that scatters it fails where more than one in ten breaks.
    modulus, share = 8.0, 0.9
    scale = limit / (-np.log(share)) ** (1 / modulus)
    device = replace(study.device, strength=scale, strength_modulus=modulus)
    needs = [NEEDS[0] | {"survives": share}, NEEDS[1] | {"snaps": "any", "survives": share}]
    trip, any_way = window_of(replace(study, device=device), AXES, needs).reserve
    unbroken = found.stress_max < limit
    assert 0 < unbroken.mean() < 1
    np.testing.assert_array_equal(trip, found.reserve[0].where(unbroken[0], 0))
    np.testing.assert_array_equal(any_way, np.where(unbroken[1], np.inf, 0))


def test_under_several_shocks_the_worst_counts(study):
    axes, shapes = {"thickness": [2.0, 2.2], "C": [25.0]}, ["half sine", "versed sine"]
    alone = [window_of(study, axes, [NEEDS[1] | {"shocks": make_shocks(one)}]) for one in shapes]
    both = window_of(study, axes, [NEEDS[1] | {"shocks": make_shocks(shapes)}])
    least = np.minimum(alone[0].reserve, alone[1].reserve)
    np.testing.assert_array_equal(both.reserve, least)
    np.testing.assert_array_equal(both.N_first, least * 1100)
    np.testing.assert_array_equal(
        both.stress_max, np.maximum(alone[0].stress_max, alone[1].stress_max)
    )


def test_a_line_says_what_lies_between_points():
    """Of x < 2.5 and y > 10.5, of x from 1 to 3 and y from 10 to 12: three quarters each way."""
    x, y = np.array([1.0, 2.0, 3.0]), np.array([10.0, 12.0])
    reserve = np.stack(np.broadcast_arrays((1 + (2.5 - x) / 10)[:, np.newaxis], 1 + (y - 10.5)))
    over = ("requirement", "mass", "C")
    data = {"reserve": (over, reserve), "yield": (over[1:], np.array([[0.5, 0.9]] * 3))}
    found = xr.Dataset(data, {"requirement": ["a", "b"], "mass": x, "C": y})
    line = summary(found, {"mass": ("mg", 2.0)})
    assert line.startswith("all requirements met at 2 of 6 points, ")
    assert pytest.approx(float(re.search(r"on ([0-9.]+)% of", line)[1]) / 100, abs=0.03) == 0.75**2
    assert line.endswith("a factor of 1.15, is at mass = 0.5 mg, C = 10.75 uN*us/um, yield 65.0%")
    # From x = 1.4 to 1.6 of 1 to 3.
    column = np.repeat([[1 + (1.6 - x) / 10], [1 + (x - 1.4) / 10]], 2, axis=1)
    line = summary(found.assign(reserve=(over, column.swapaxes(1, 2))), {})
    assert line.startswith("all requirements met at 0 of 6 points, ")
    assert pytest.approx(float(re.search(r"on ([0-9.]+)% of", line)[1]) / 100, abs=0.03) == 0.1


def test_no_design_chooses_a_temperature(handout):
    """Each requirement is met at both temperatures, or not at all; so is the yield."""
    device = replace(handout, modulus_slope=-2e-3)
    model = {"name": "cosines", "modes": 3}
    study = Study(device=device, model=model, settings=Settings(horizon=300.0))
    design = {"thickness": np.array([2.0, 2.1, 2.2]), "C": [25.0]}
    drawn = Tolerances(SCATTERS, samples=16)
    apart = [
        window_of(study, {"temperature": [at], **design}, NEEDS, drawn) for at in (-20.0, 60.0)
    ]
    both = window_of(study, {"temperature": [-20.0, 60.0], **design}, NEEDS, drawn)
    assert both.reserve.dims == ("requirement", "thickness", "C")
    each = np.stack([one.reserve.squeeze("temperature") for one in apart])
    np.testing.assert_array_equal(both.reserve, each.min(axis=0))
    hot = np.argmin(each, axis=0)
    np.testing.assert_array_equal(both.temperature, np.where(hot, 60.0, -20.0))
    shares = np.stack([one["yield"].squeeze("temperature") for one in apart])
    assert (both["yield"] <= shares.min(axis=0)).all() and len(np.unique(hot)) == 2
    assert both.attrs["temperatures"] == [-20.0, 60.0]
    assert both.reserve.long_name.startswith("factor by which") and both.temperature.units == "degC"


def test_what_is_not_known_is_neither_met_nor_failed():
    reserve = np.array([[[1.2, np.nan], [1.1, np.nan]], [[1.3, 1.1], [0.9, 0.8]]])
    least = least_reserve(reserve)
    np.testing.assert_array_equal(least, [[1.2, np.nan], [0.9, 0.8]])
    fine = between(np.array([1.0, np.nan, 3.0, 4.0]), 1)
    assert fine[0] == 1 and fine[2 * PARTS] == 3 and fine[-1] == 4
    assert np.isnan(fine[1 : 2 * PARTS]).all() and np.isfinite(fine[2 * PARTS :]).all()


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


@pytest.mark.usefixtures("paper")
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


@pytest.mark.usefixtures("paper")
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


@pytest.mark.usefixtures("paper")
def test_a_window_has_the_units_of_the_config_and_no_colour_where_nothing_is_known():
    found = make_window()
    found["reserve"] = found.reserve.where((found.spring < 8) | (found.C < 60))
    found = found.drop_vars(["yield", "yield_bound", "stress_max"])
    units = {"spring": ("mN/um", 1e3), "C": ("mN*s/m", 1e3)}
    window.draw_window(figure := style.double_column(4), found, "spring", "C", units)
    (ax,) = figure.axes
    assert ax.get_xlim() == (0.004, 0.008) and ax.get_ylim() == pytest.approx((0.02, 0.06))
    assert colour_at(ax, 0.0079, 0.059) is None

"""Where over two axes required shocks are met."""

import re
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr
from matplotlib.backend_bases import GraphicsContextBase
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from small_results import artists, legend_words
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.applications.histories.history import extremes_of
from snapmap.applications.requirements.sections import RequiredShock
from snapmap.applications.window import application, choose_axes, figure
from snapmap.applications.window.between import PARTS, between, least_reserve
from snapmap.applications.window.window import _off_between, summary, window_of
from snapmap.device.samples import Scatters, Tolerances
from snapmap.figures import style
from snapmap.pulse.shocks import make_shocks
from snapmap.study.shock import Shock
from snapmap.values.kinds import kind_of

CASES = cases_of(__file__)
CHEAP = {"model": "3 cosines", "horizon": 300.0}
AXES = {"thickness": np.linspace(1.9, 2.4, 6), "C": [25.0, 60.0]}
WRITTEN = {"thickness": 0.05, "N": "2 %"}
SCATTERS = kind_of(Scatters).take(WRITTEN)
ASKED = CASES["asked"]
NEEDS = [Shock(**shock, survives=0.999, shocks=make_shocks()) for shock in ASKED]


@pytest.fixture(scope="module")
def strong(study):
    return replace(study, device=replace(study.device, strength=1e3))


@pytest.fixture(scope="module")
def met(strong):
    """The window in which the needs are met."""
    return window_of(strong, AXES, NEEDS, Tolerances(SCATTERS, samples=32))


def test_a_window_ends_where_a_design_does(handout, met):
    asked = {"C": 25.0, "between": (1.9, 2.4), "requirements": ASKED}
    design = snapmap.design(Study(handout, **CHEAP), "thickness", **asked)
    for name, end in (("stay", design.low), ("trip", design.high)):
        along = met.reserve.sel(C=25.0, requirement=name)
        along = along.sortby(along)
        assert np.interp(1.0, along, along.thickness) == pytest.approx(end.item(), abs=2e-3)
    assert {*met.coords} == {"requirement", "thickness", "C", "bound"}
    points = int((met.reserve.min("requirement") >= 1).sum())
    line = summary(met, {"thickness": ("mm", 1e3), "C": ("uN*us/um", 1.0)})
    assert f"requirements at {points} of 12 points" in line and " mm, C = " in line


def test_its_yields_and_stresses_are_those_of_one_device(handout, strong, met):
    device = varied(handout, thickness=2.1)
    asked = {"requirements": ASKED, "samples": 32, "index_samples": 2}
    made = snapmap.tolerance(Study(device, **CHEAP), WRITTEN, [1500.0], AXES["C"], **asked)
    here = met.sel(thickness=2.1, method="nearest")
    for key in ("yield", "yield_bound"):
        np.testing.assert_array_equal(here[key], made[key])
    for required in NEEDS:
        largest = extremes_of(replace(strong, device=device), required.N, 1500.0, 60.0)
        stress = here.stress_max.sel(requirement=required.name, C=60.0).item()
        assert stress == pytest.approx(largest.stress_max, rel=1e-6)


def test_where_the_beam_breaks_a_requirement_fails(strong, met):
    """With a strength that scatters where more than one in ten breaks."""
    limit, of_strength = met.stress_max.median().item(), partial(replace, strong.device)
    unbroken = met.stress_max < limit
    assert 0 < unbroken.mean() < 1
    brittle = replace(strong, device=of_strength(strength=limit))
    reserve = window_of(brittle, AXES, NEEDS).reserve
    np.testing.assert_array_equal(reserve, met.reserve.where(unbroken, 0))
    modulus, share = 8.0, 0.9
    scale = limit / (-np.log(share)) ** (1 / modulus)
    weibull = replace(strong, device=of_strength(strength=scale, strength_modulus=modulus))
    needs = [replace(NEEDS[0], survives=share), replace(NEEDS[1], snaps="any", survives=share)]
    trip, any_way = window_of(weibull, AXES, needs).reserve
    np.testing.assert_array_equal(trip, met.reserve[0].where(unbroken[0], 0))
    np.testing.assert_array_equal(any_way, np.where(unbroken[1], np.inf, 0))


def test_under_several_shocks_the_worst_counts(strong):
    axes, shapes = {"thickness": [2.0, 2.2], "C": [25.0]}, ["versed sine", "half sine"]
    needs = [replace(NEEDS[1], shocks=make_shocks(each)) for each in (*shapes, shapes)]
    *alone, both = (window_of(strong, axes, [need]) for need in needs)
    least = np.minimum(*(window.reserve for window in alone))
    np.testing.assert_array_equal(both.reserve, least)
    np.testing.assert_array_equal(both.N_first, least * 1100)
    most = np.maximum(*(window.stress_max for window in alone))
    np.testing.assert_array_equal(both.stress_max, most)


def test_a_line_says_what_lies_between_points():
    """Of x < 2.5 and y > 10.5, of x from 1 to 3 and y from 10 to 12: three quarters each way."""
    x, y, over = np.array([1.0, 2.0, 3.0]), np.array([10.0, 12.0]), ("requirement", "mass", "C")
    share = lambda line: float(re.search(r"on ([0-9.]+)% of", line)[1]) / 100  # noqa: E731
    reserve = np.stack(np.broadcast_arrays((1 + (2.5 - x) / 9.9)[:, np.newaxis], 1 + (y - 10.5)))
    data = {"yield": (over[1:], np.array([[0.5, 0.9]] * 3))}
    data |= dict.fromkeys(("reserve", "N_first"), (over, reserve))
    window = xr.Dataset(data, {"requirement": ["a", "b"], "mass": x, "C": y})
    line = summary(window, {"mass": ("mg", 3.0)})
    assert line.startswith("thresholds on the right side of all requirements at 2 of 6 points, ")
    assert share(line) == pytest.approx(0.75**2, abs=0.03)
    place = "mass = 0.333333 mg, C = 10.75 uN*us/um"
    assert line.endswith(f"a factor of 1.152, is at {place}, yield 65.0%")
    # From x = 1.4 to 1.6 of 1 to 3.
    band = np.array([1 + (1.6 - x) / 10, 1 + (x - 1.4) / 10])[..., np.newaxis].repeat(2, axis=2)
    line = summary(window.assign(reserve=(over, band)), {})
    assert line.startswith("thresholds on the right side of all requirements at 0 of 6 points, ")
    assert share(line) == pytest.approx(0.1, abs=0.03)


def test_margins_beyond_what_is_followed_are_no_widest_ones():
    """Of x above 5 the half is beyond 4; where nothing snaps there is no margin at all."""
    over = "requirement", "mass", "C"
    reserve = np.array([[[3.0, 3.0], [5.0, 5.0], [6.0, 6.0]]])
    window = xr.Dataset({key: (over, reserve) for key in ("reserve", "N_first")})
    window = window.assign_coords(requirement=["a"], mass=[1.0, 2.0, 3.0], C=[10.0, 12.0])
    line = summary(window, {})
    assert re.search(r"100.0% of the plane; the widest margin, a factor over 4, is that of", line)
    assert float(re.search(r"of ([\d.]+)% of the plane$", line)[1]) == pytest.approx(51.5, abs=2)
    infinite = window.assign(reserve=window.reserve + np.inf, N_first=window.N_first * np.nan)
    infinite["N_error"] = infinite.N_first
    line = summary(infinite, {})
    assert line.endswith("requirements at 6 of 6 points; nothing snaps at any")
    infinite.reserve.attrs["off_between_points"] = 0.0
    about = figure._about(infinite, infinite.reserve.values)
    assert about == "met everywhere: a\nticks: where a requirement fails; nothing snaps"


@pytest.mark.parametrize(("sizes", "chosen"), CASES["axes"])
def test_a_window_is_over_two_axes_that_a_design_chooses(sizes, chosen):
    axes = {key: np.arange(float(size)) for key, size in sizes.items()}
    shock = RequiredShock(name="a", N=1e3, f0=1e3, snaps=True, shocks=make_shocks())
    study = SimpleNamespace(axes=axes, requests={"requirements": [shock]})
    assert choose_axes(study) == tuple(chosen)
    assert application.outputs(study) == ({"window": "results/window.nc"} if chosen else {})
    study.requests = {}
    assert application.outputs(study) == {}


def test_between_points_a_reserve_is_off_by_an_eighth_of_its_second_differences():
    """Summed over both axes, the largest of each; 4 and 1/4 count for what is beyond."""
    x, y = np.array([9.0, 3.0, 0.0]), np.array([0.0, 0.1, 0.1])
    assert _off_between(x[:, np.newaxis] + y[np.newaxis, np.newaxis]) == pytest.approx(2.05 / 8)


def test_no_design_chooses_a_temperature(handout, study):
    """Each requirement is met at both temperatures, or not at all; so is the yield."""
    study = replace(study, device=replace(handout, modulus_slope=-2e-3))
    design = {"thickness": np.array([2.0, 2.1, 2.2]), "C": [25.0]}
    axes = [{"temperature": at} | design for at in ([-20.0], [60.0], [-20.0, 60.0])]
    made = Tolerances(SCATTERS, samples=16)
    *apart, both = (window_of(study, each, NEEDS, made) for each in axes)
    assert both.reserve.dims == ("requirement", "thickness", "C")
    each = np.stack([window.reserve.squeeze("temperature") for window in apart])
    np.testing.assert_array_equal(both.reserve, each.min(axis=0))
    hot = np.argmin(each, axis=0)
    np.testing.assert_array_equal(both.temperature, np.where(hot, 60.0, -20.0))
    shares = np.stack([window["yield"].squeeze("temperature") for window in apart])
    assert (both["yield"] <= shares.min(axis=0)).all() and len(np.unique(hot)) == 2
    assert both.attrs["temperatures"] == [-20.0, 60.0]
    assert both.reserve.long_name.startswith("factor by which") and both.temperature.units == "degC"


def test_what_is_not_known_is_neither_met_nor_failed():
    reserve = np.array([[[1.2, np.nan], [1.1, np.nan]], [[1.3, 1.1], [0.9, 0.8]]])
    np.testing.assert_array_equal(least_reserve(reserve), [[1.2, np.nan], [0.9, 0.8]])
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
    layers = [layer for layer in artists(ax, ContourSet) if layer.filled]
    within = [layer for layer in layers if layer.get_paths()[0].contains_point(point)]
    return to_hex(within[-1].get_facecolor()[0]) if within else None


INTERNAL = {"spring": ("N/m", 1.0), "C": ("uN*us/um", 1.0)}


def drawn_window(window, units=INTERNAL):
    figure.draw(page := style.double_column(4), window, units)
    return page.axes


MET, FAILING = figure.MEETING["color"], figure.FAILING["color"]


@pytest.mark.usefixtures("paper")
def test_a_window_ends_on_lines_where_each_requirement_begins_to_fail():
    *panels, stress, _ = drawn_window(make_window())
    assert len(panels) == 2 and legend_words(stress) == CASES["legend"]
    assert stress.figure.legends[0].get_title().get_text() == CASES["about"]
    layers = [layer for ax in panels for layer in artists(ax, ContourSet) if not layer.filled]
    drawn = [layer.levels.tolist() for layer in layers if layer.levels.tolist() != [1.0]]
    assert drawn == [[1.02, 1.05, 1.1, 1.15, 1.2, 1.5], [0.5]]
    lines = [line for line in stress.collections if line.get_path_effects()]
    for line, column, end, straight in zip(lines, (0, 1), (6.5, 35.0), (0.06, 1e-9), strict=True):
        (path,), (effect,), page = line.get_paths(), line.get_path_effects(), Mock()
        assert abs(path.vertices[:, column] - end).max() < straight
        page.points_to_pixels = float
        effect.draw_path(page, GraphicsContextBase(), path, stress.transData, None)
        ticks = page.draw_path.call_args_list[0].args[1].vertices
        ticks = stress.transData.inverted().transform(ticks[1::2] - ticks[::2] + stress.bbox.p0)
        across = (ticks - (4.0, 20.0))[:, column]
        assert (across > 0.03).all() if column == 0 else across == pytest.approx(-0.1559, abs=1e-3)
    points = {(5.0, 50.0): MET} | dict.fromkeys([(7.0, 50.0), (5.0, 30.0), (7.0, 30.0)], FAILING)
    for ax in panels:
        assert {point: colour_at(ax, *point) for point in points} == points
    for ax in (*panels, stress):
        assert (ax.get_xlim(), ax.get_ylim()) == ((4.0, 8.0), (20.0, 60.0))


@pytest.mark.usefixtures("paper")
def test_a_requirement_that_is_just_met_is_met():
    even = make_window().isel(requirement=[2]).drop_vars("stress_max")
    even["reserve"] = even.reserve.copy(data=1 + 0 * even.reserve)
    *_, ax = drawn_window(even)
    words = [figure.MEETING["label"], figure.POINTS["label"]]
    assert legend_words(ax) == words
    title = ax.figure.legends[0].get_title().get_text()
    assert title.startswith("met everywhere: easy\nticks")
    line = "all requirements at 20 of 20 points, by interpolation on 100.0% of the plane"
    assert line in summary(even, {})


@pytest.mark.usefixtures("paper")
def test_a_window_reaches_the_point_where_two_lines_meet_at_a_small_angle():
    spring, C = np.meshgrid([1.0, 2.0], [1.0, 2.0], indexing="ij")
    after, before = spring - 0.53, 2.53 - spring + 0.05 * (C - 1.03)
    window = make_window().isel(requirement=[0, 1], spring=[0, 1], C=[0, 1])
    window = window.assign_coords(spring=spring[:, 0], C=C[0]).drop_vars(["yield", "yield_bound"])
    window["reserve"] = window.reserve.copy(data=np.stack([after, before]))
    points = dict.fromkeys([(1.531, 1.3), (1.54, 1.5), (1.55, 1.9)], MET)
    points |= dict.fromkeys([(1.52, 1.5), (1.56, 1.5)], FAILING)
    ax, *_ = drawn_window(window)
    assert {point: colour_at(ax, *point) for point in points} == points


@pytest.mark.usefixtures("paper")
def test_a_window_has_the_units_of_the_config_and_no_colour_where_nothing_is_known():
    window = make_window()
    window["reserve"] = window.reserve.where((window.spring < 8) | (window.C < 60))
    window = window.drop_vars(["yield", "yield_bound", "stress_max"])
    (ax,) = drawn_window(window, {"spring": ("mN/um", 1e3), "C": ("mN*s/m", 1e3)})
    assert ax.get_xlim() == (0.004, 0.008) and ax.get_ylim() == pytest.approx((0.02, 0.06))
    assert colour_at(ax, 0.0079, 0.059) is None

"""What figures show of their data: curves, limits, shares, forces; how they are saved."""

import json
import os
import runpy
from pathlib import Path

import numpy as np
import pytest
import small_results
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, LineCollection, QuadMesh
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from PIL import Image
from small_results import artists, drawn, legend_words, make_found, visible
from small_studies import cases_of

from snapmap.applications.boundary import figure as boundary
from snapmap.figures import captions, curves, maps, scales, style, thresholds

pytestmark = pytest.mark.usefixtures("sketch")
CASES = cases_of(__file__)


@pytest.mark.parametrize(("key", "values", "edges"), CASES["edges"])
def test_edges_lie_midway_and_surround_a_lone_value(key, values, edges):
    assert scales.scale_of(key, np.array(values)).edges == pytest.approx(edges)


@pytest.mark.parametrize(("key", "values", "ends"), CASES["ends"])
def test_an_axis_ends_at_its_first_and_last_value_and_few_of_a_device_are_columns(
    key, values, ends
):
    ax, scale = style.single_column(height=3).subplots(), scales.cells_of(key, np.array(values))
    scales.set_scale(ax, "x", scale)
    assert [*ax.get_xlim()] == ends
    if scale.is_counted:
        texts = [text.get_text() for text in ax.get_xticklabels()]
        assert texts == [scales.number(value) for value in values]
        assert ax.get_xticks().tolist() == scale.places.tolist()


def test_space_for_markers_is_a_little_of_an_axis_beyond_its_data():
    for key, values in (("temperature", [-40.0, 21.5, 125.0]), ("f0", [100.0, 400.0, 6400.0])):
        ax, scale = style.single_column(height=3).subplots(), scales.scale_of(key, np.array(values))
        scales.set_scale(ax, "x", scale)
        scales.leave_space(ax, scale)
        at = ax.transAxes.inverted().transform
        ends = at(ax.transData.transform([[values[0], 0.5], [values[-1], 0.5]]))[:, 0]
        assert (0 < ends[0] < 0.04) and (0.96 < ends[1] < 1)


def test_values_numbers_and_axes_are_written_with_their_signs_and_units():
    """A number has a minus sign; a name keeps its hyphen."""
    own, ours = Figure().subplots(), style.single_column(height=3).subplots()
    for value, text in CASES["numbers"]:
        assert scales.number(value) == text
    for key, value, text in CASES["values"]:
        assert scales.value_text(key, value) == text
    for key, label, short in CASES["labels"]:
        assert [scales.label_in(ax, key) for ax in (ours, own)] == [label, short]


def test_figures_over_durations_are_those_over_frequencies():
    over_duration = scales.along(make_found(), "duration", "C")
    np.testing.assert_allclose(over_duration.duration, [0.1, 1.0, 10.0])
    assert over_duration.N_first.sel(C=25.0).values.tolist() == [2000.0, 1100.0, 1000.0]
    assert scales.along(over_duration, "f0") is over_duration


@pytest.mark.parametrize("draw", [thresholds.draw_thresholds, boundary.draw_damage_boundary])
@pytest.mark.parametrize("f0", [[2], [0, 2]])
def test_thresholds_that_are_not_known_leave_a_hole(draw, f0):
    results = make_found()
    for name in ("N_first", "N_error", "N_always"):
        results[name] = results[name].where(results.f0 < 1000)
    ax = drawn(draw, results.isel(f0=f0))
    curves = [line for line in ax.lines if line.get_marker() not in ("None", "", "x", "|", "_")]
    seen = [points for line in curves if (points := visible(line)) and points[0][1] >= 1000]
    assert bool(seen) == (0 in f0)


def limits(ax, label):
    return [line for line in ax.lines if line.get_label().startswith(label)]


def test_thresholds_are_the_data_dashed_and_hollow_where_late_and_approach_both_limits():
    ax = drawn(thresholds.draw_thresholds, make_found())
    short = limits(ax, curves.SHORT)
    for i, (N, v) in enumerate([(1000.0, 0.5), (1001.0, 0.6)]):
        of_curve = [line for line in ax.lines if line.get_color() == curves.LOOKS[i][0]]
        solid, dashed = of_curve[1:3]
        assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
        assert dashed.get_markerfacecolor() == "white" != solid.get_markerfacecolor()
        assert dashed.get_markevery().tolist() == [False, False, True]
        assert visible(dashed) == [[1000.0, N + 100], [10000.0, N + 1000]]
        assert visible(solid) == [[100.0, N], [1000.0, N + 100]]
        assert [line for line in of_curve if line in short] == [short[i]]
        np.testing.assert_allclose(short[i].get_ydata() * 5 / short[i].get_xdata(), v, rtol=1e-9)
    assert [line.get_ydata() for line in limits(ax, curves.LONG)] == [[990.0, 990.0]]
    assert len(short) == 2
    unknown = make_found().assign(velocity_change=("C", [np.nan, np.nan]))
    assert not limits(drawn(thresholds.draw_thresholds, unknown), curves.SHORT)


def test_late_stretches_reach_to_their_neighbours_and_leave_a_gap_between_them():
    """A snap at the very end of the pulse is not late."""
    f0, late = np.array([100.0, 200.0, 400.0, 800.0, 1600.0]), np.array([1, 0, 0, 0, 1])
    found = {"N_first": f0 + 1, "N_error": 0 * f0, "t_snap": 1e6 / f0 + late}
    curve = xr.Dataset({key: ("f0", values) for key, values in found.items()}, {"f0": f0})
    ax = style.single_column(height=3).subplots()
    curves.draw_curve(ax, f0, curve, "C0", "o")
    solid, dashed = ax.lines[1:]
    assert [x for x, _ in visible(solid)] == [200.0, 400.0, 800.0]
    assert visible(dashed) == [[x, x + 1] for x in (100.0, 200.0, 800.0, 1600.0)]
    assert dashed.get_markevery().tolist() == [True, False, False, False, True]
    assert (dashed.get_marker(), dashed.get_markeredgewidth()) == ("o", 0.6)
    assert dashed.get_label() == "threshold, snap after the pulse"


def test_the_velocity_change_is_the_area_of_the_pulse_times_its_peak_and_duration():
    """In m/s: N g area / f0, of N = 1000 at 100 Hz and 1e-5 um/us^2: 0.01 um/us^2 times 5 ms."""
    changes = curves.velocity_change(make_found().isel(C=0))
    np.testing.assert_allclose(changes, [50.0, 5.5, 1.0], rtol=1e-14)


def test_crosses_of_lines_without_thresholds_stand_in_rows():
    found = make_found()
    partly = found.assign(N_first=found.N_first.where(found.f0 < 1e3))
    ax = drawn(thresholds.draw_thresholds, partly)
    rows = [line for line in ax.lines if line.get_marker() == "x"]
    assert [line.get_color() for line in rows] == [look[0] for look in curves.LOOKS[:2]]
    for line, height in zip(rows, (0.975, 0.945), strict=True):
        assert line.get_xdata().tolist() == [1000.0, 10000.0]
        assert line.get_ydata() == pytest.approx([height, height], rel=1e-14)


@pytest.mark.parametrize(("static", "is_drawn"), [(990.0, False), (1001.0, True)])
def test_the_bound_by_energy_is_drawn_where_some_threshold_is_below_the_static_one(
    static, is_drawn
):
    ax = drawn(thresholds.draw_thresholds, make_found().assign(N_static=static))
    assert ([180.0, 190.0, 630.0] in [[*line.get_ydata()] for line in ax.lines]) == is_drawn


def test_a_map_of_thresholds_has_their_values():
    (mesh,) = artists(drawn(thresholds.draw_threshold_map, make_found(), "f0", "C"), QuadMesh)
    assert mesh.get_array().tolist() == make_found().N_first.transpose("C", "f0").values.tolist()


def test_level_lines_need_two_values_along_both_axes_and_no_hole():
    found = make_found(C=[10.0 * place for place in range(6)])
    holed = found.assign(N_first=found.N_first.where(found.f0 < 9e3))
    for data, are_drawn in ((found, True), (found.isel(f0=[0]), False), (holed, False)):
        ax = drawn(thresholds.draw_threshold_map, data, "f0", "C")
        assert bool(artists(ax, QuadContourSet)) == are_drawn


def test_the_limit_of_long_pulses_begins_nowhere_and_lines_that_share_it_have_one():
    results = make_found()
    results["N_slow"] = results.N_first * [1.005, 0.995, 1.1]
    (limit,) = limits(drawn(thresholds.draw_thresholds, results), curves.LONG)
    assert limit.get_xydata().tolist() == [[0, 990.0], [1, 990.0]]  # from edge to edge
    assert limit.get_label() == "limit of long pulses, $N$ = 990"
    two = results.assign(N_static=("C", [990.0, 995.0]))
    assert len(limits(drawn(thresholds.draw_thresholds, two), curves.LONG)) == 2


def test_an_axis_of_thresholds_goes_as_far_as_they_vary_whatever_their_limits():
    """From the least N_first to the largest N_always; a limit beyond is in no legend."""
    for static in (100.0, 990.0):
        ax = drawn(thresholds.draw_thresholds, make_found().assign(N_static=static))
        ends = (993 / thresholds.BEYOND, 2301 * thresholds.BEYOND)
        assert ax.get_ylim() == pytest.approx(ends)
        assert any(words.startswith(curves.LONG) for words in legend_words(ax)) == (static > 900)


def test_a_legend_has_no_gap_and_no_island_that_is_too_small_to_see():
    words = legend_words(drawn(thresholds.draw_thresholds, make_found()))
    assert words == CASES["legend"]
    thin = make_found()
    thin["N_always"] = thin.N_first * (1 + 1e-5)
    thin["island_to"] = thin.island_from * (1 + 1e-5)
    assert not {*words[-2:]} & {*legend_words(drawn(thresholds.draw_thresholds, thin))}


def test_figures_of_a_pushed_beam_count_its_force():
    device = {"beam": {}, "mass": "none", "force": "2.0 uN"}
    pushed = {"config": json.dumps(small_results.CONFIG | {"device": device})}
    two = {"config": json.dumps({"devices": {"a": device, "b": device | {"force": "3.0 uN"}}})}
    assert captions.multiples(two) == "multiples of each force"
    for gravity, unit in CASES["gravity"].items():
        shaken = json.dumps({"device": {"beam": {}, "gravity": f"{gravity} um/us^2"}})
        assert captions.multiples({"config": shaken}) == f"multiples of {unit}"
    results = make_found().assign(velocity_change=("C", [np.nan, np.nan])).assign_attrs(pushed)
    ax = drawn(thresholds.draw_thresholds, results)
    assert ax.get_ylabel() == "pulse amplitude $N$ (multiples of 2 µN)"
    cells = small_results.TINY.assign_attrs(pushed)
    assert drawn(maps.draw_map, cells, results.isel(C=0)).get_ylabel().endswith("of 2 µN)")
    assert drawn(maps.draw_map, small_results.TINY, None).get_ylabel().endswith("of $g$)")


def test_a_saved_figure_has_fonts_and_facts_and_repeats_byte_for_byte(tmp_path):
    for name in ("first", "again"):
        with style.paper():
            figure = drawn(thresholds.draw_thresholds, make_found()).figure
            style.save(figure, tmp_path / name, small_results.ATTRIBUTES)
    for kind in ("pdf", "png"):
        first, again = (tmp_path / f"{name}.{kind}" for name in ("first", "again"))
        assert first.read_bytes() == again.read_bytes()
    pdf = (tmp_path / "first.pdf").read_bytes()
    for fact in (b"/FontFile2", b"/Title (A title)", b"/Creator (0.1.0+abc)", b"1.5 ms"):
        assert fact in pdf
    assert b"/Type3" not in pdf and b"Date" not in pdf
    with Image.open(tmp_path / "first.png") as image:
        assert image.size[0] == 2100
        assert image.info["dpi"] == pytest.approx((300, 300), abs=0.01)
        assert [image.info[key] for key in ("Title", "Software")] == ["A title", "0.1.0+abc"]
        assert json.loads(image.info["Comment"]) == small_results.CONFIG


def test_pictures_of_pages_are_small_and_have_the_numbers_of_today(root, tmp_path):
    pictures = runpy.run_path(root / "docs" / "make_pictures.py")
    files = root / "docs" / "pictures"
    names = {path.stem for path in files.glob("*.png")}
    assert names == {"map", "speed", "laws", "convergence", *pictures["GALLERY"]}
    assert all(path.stat().st_size <= 100_000 for path in files.iterdir())
    pictures["draw_badges"](tmp_path)
    assert all((tmp_path / p.name).read_text() == p.read_text() for p in files.glob("*.svg"))
    pictures["draw_speeds"](ax := style.single_column(height=4).subplots())
    error, speed = ax.lines[0].get_xydata()[0]
    lines = (root / "docs" / "accuracy.md").read_text(encoding="utf-8").splitlines()
    row = next(line for line in lines if line.startswith("| snapmap | step x 2 | 3 cosines |"))
    assert f"| {speed:.0f} | {error / 100:.1e} |" in row
    assert len(ax.lines) == len(pictures["SHOWN"]) == 7


def test_thresholds_have_bars_gaps_and_islands():
    ax = drawn(thresholds.draw_thresholds, make_found(C=[25.0]))
    (gap,) = artists(ax, FillBetweenPolyCollection)
    assert gap.get_paths()[0].vertices.max(axis=0).tolist() == [10000.0, 2300.0]
    islands, bars = artists(ax, LineCollection)
    ends = [line[:, 1].tolist() for line in islands.get_segments() if len(line)]
    assert ends == [[2000.0, 2050.0], [2100.0, 2150.0]]
    assert bars.get_segments()[0].tolist() == [[100.0, 993.0], [100.0, 1007.0]]


@pytest.mark.parametrize("processes", [1, 2])
def test_tasks_side_by_side_are_all_done_and_a_fault_is_told(python, tmp_path, processes):
    no_forks = "-Werror::DeprecationWarning:multiprocessing.popen_fork"
    program = CASES["side by side"].format(processes)
    assert python(program, options=[no_forks], cwd=tmp_path) == ("told\n", "")


def test_what_draws_needs_no_kernel_no_pyplot_and_no_dask(python):
    code = "import sys, draw; print({'numba', 'matplotlib.pyplot', 'dask.array'} & {*sys.modules})"
    assert python(code) == ("set()\n", "")


def test_a_figure_on_a_full_disk_is_one_line(tmp_path, monkeypatch):
    def write_bytes(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(Path, "write_bytes", write_bytes)
    with (
        pytest.raises(OSError, match=r"^/.*a\.png: not written, .* MB are free there: .*28\]"),
        style.saved(str(tmp_path / "a"), {}, 3.0) as figure,
    ):
        figure.subplots()
    assert not [*tmp_path.iterdir()]

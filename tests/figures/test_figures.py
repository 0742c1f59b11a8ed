"""What figures show of their data: curves, limits, shares, forces; how they are saved."""

import json
import math
import subprocess
import sys
import warnings

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, LineCollection, QuadMesh
from matplotlib.colors import to_hex, to_rgb
from matplotlib.contour import ContourSet
from matplotlib.patches import Polygon
from PIL import Image
from small_results import ATTRIBUTES, CONFIG, F0, TINY, legend_words, make_found, visible

from snapmap.applications.boundary import figure as boundary
from snapmap.applications.calibration import figure as calibration
from snapmap.applications.histories import figure as histories
from snapmap.applications.requirements import figure as requirements
from snapmap.applications.statics import figure as statics
from snapmap.applications.tolerances import figure as tolerances
from snapmap.applications.window import figure as window
from snapmap.figures import curves, maps, scales, style, thresholds


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


def make_history(w_mid):
    """A history whose midpoint takes these positions, 10 us apart, 1 um below the mass."""
    w_mid = np.array(w_mid, float)
    values = {"w_mid": w_mid, "z_mass": w_mid + 1, "contact_force": 0 * w_mid}
    values["acceleration"] = np.full(w_mid.size, 0.02)
    variables = {key: ("time", column) for key, column in values.items()}
    attributes = ATTRIBUTES | {"second_equilibrium": -9.0, "gravity": 1e-5}
    attributes |= {"N": 1000.0, "f0": 1500.0, "C": 0.025}
    return xr.Dataset(variables, {"time": 10.0 * np.arange(w_mid.size)}, attributes)


@pytest.fixture(autouse=True)
def paper():
    """The figures' own style; a warning is a fault."""
    with style.paper(), warnings.catch_warnings(action="error"):
        yield


def drawn(draw, dataset, *others):
    """Axes on which a function has drawn a dataset."""
    return draw(style.double_column(height=3.4).subplots(), dataset, *others)


def artists(ax, kind):
    return [artist for artist in ax.get_children() if isinstance(artist, kind)]


def line(ax, label):
    return next(line for line in ax.lines if line.get_label().startswith(label))


def history_of(history):
    figure = style.double_column(height=4.2)
    return histories.draw_history(figure.subplots(3, sharex=True), history)


@pytest.mark.parametrize(
    ("key", "values", "edges"),
    [
        ("f0", [100.0, 400.0, 6400.0], [50.0, 200.0, 1600.0, 25600.0]),
        ("N", [-1.0, 0.0, 3.0], [-1.5, -0.5, 1.5, 4.5]),
        *(("N", [1500.0], [1350.0, 1650.0]), ("N", [0.0], [-0.5, 0.5])),
        ("f0", [1500.0], [1500 / 1.1, 1500 * 1.1]),
        ("device", ["a", "b"], [-0.5, 0.5, 1.5]),
    ],
)
def test_edges_lie_midway_and_surround_a_lone_value(key, values, edges):
    assert scales.scale_of(key, np.array(values)).edges == pytest.approx(edges)


@pytest.mark.parametrize("ends", [(1.0, 2.5), (100.0, 3e4), (1e-3, 1e5)])
@pytest.mark.parametrize("column", [style.single_column, style.double_column])
def test_logarithmic_axes_have_ticks_enough_and_apart(ends, column):
    ax = column(height=3.0).subplots()
    ax.set(xscale="log", xlim=ends)
    scales.tick(ax.xaxis, *ends)
    ticks = ax.xaxis.get_majorticklocs()
    ticks = ticks[(ticks >= ends[0]) & (ticks <= ends[1])]
    across, _ = ax.transData.transform(np.stack([ticks, ticks], axis=1)).T
    assert ticks.size >= 3 and np.diff(across).min() > 20 / 72 * ax.figure.dpi


def test_figures_over_durations_are_those_over_frequencies():
    found = scales.along(make_found(), "duration", "C")
    np.testing.assert_allclose(found.duration, [0.1, 1.0, 10.0])
    assert found.N_first.sel(C=25.0).values.tolist() == [2000.0, 1100.0, 1000.0]
    ax = drawn(thresholds.draw_thresholds, found, "duration", "C")
    assert ax.get_xscale() == "log" and "ms" in ax.get_xlabel()
    assert scales.along(found, "f0") is found


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
    assert points == [[0.8, 0.0], [0.9, 2.0]]
    bars = [bar.get_segments()[0][:, 0].tolist() for bar in artists(ax, LineCollection)]
    assert bars == [pytest.approx([0.79, 0.81]), pytest.approx([0.88, 0.92])]
    assert [text.xy[1] for text in ax.texts] == [1, 2]  # no threshold; breaks
    assert legend_words(ax)[:2] == ["met", "failed"]
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert names[0].startswith("drop, trips\nhalf sine −z, −40 °C, ")
    any_way = verdicts[0] | {"must_snap": "any", "margin": 1.1}
    verdicts += [verdicts[2] | {"margin": 1.2, "verdict": "met"}, any_way | {"requirement": "hit"}]
    ax = drawn(requirements.draw_margins, verdicts)
    dots = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "."]
    assert [one for one in dots if one] == [[[1.2, 2.0]]]  # the corner that fails is in front
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert len(names) == 4 and names[3].startswith("hit, trips or not")


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
        "sensitivity_bound": (("bound", "order", "value", *of_f0), np.stack([index, index + 0.1])),
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


def test_shots_stand_on_the_side_of_their_outcome_beside_the_fit():
    spread = xr.DataArray([0.05], dims="bound", coords={"bound": ["estimate"]})
    columns = {"f0": [1e3, 1e3, 2e3], "N": [900.0, 1100.0, 1000.0], "tripped": [0, 1, 0]}
    columns |= {"threshold": [1e3, 1e3, 1.2e3], "threshold_low": [950.0, 950.0, 1100.0]}
    columns |= {"threshold_high": [1050.0, 1050.0, 1300.0], "direction": ["+z"] * 3}
    columns["shape"] = ["half sine"] * 3
    found = xr.Dataset({key: ("shot", values) for key, values in columns.items()})
    (panel,) = calibration.panels(found.assign(spread=spread))
    fit, stayed, tripped = drawn(calibration.draw_shots, panel).lines
    assert fit.get_xydata().tolist() == [[1e3, 1e3], [2e3, 1.2e3]]
    assert stayed.get_ydata().tolist() == [900, 1000] and tripped.get_ydata().tolist() == [1100]
    assert [shots.get_markerfacecolor() for shots in (stayed, tripped)] == ["white", "black"]


def test_damage_boundary_shades_what_snaps_of_the_first_C():
    ax = drawn(boundary.draw_damage_boundary, make_found())
    (region,) = artists(ax, Polygon)
    snaps = region.get_path().contains_points
    assert snaps([(1.1, 2000.0), (6.0, 1100.0), (50.0, 1010.0), (51.0, 1e5)]).all()
    assert not snaps([(0.9, 1900.0), (5.4, 1000.0), (50.0, 980.0)]).any()
    # Shorter and longer pulses than the curve has.
    assert not snaps([(0.6, 1e5), (1.0, 2100.0), (1e3, 1000.0), (51.0, 1010.0)]).any()


def curves_of(ax):
    """What is seen of each line, late or not."""
    known = [line for line in ax.lines if line.get_marker() not in ("None", "", "x", "|", "_")]
    return [points for line in known if (points := visible(line))]


@pytest.mark.parametrize("draw", [thresholds.draw_thresholds, boundary.draw_damage_boundary])
@pytest.mark.parametrize("f0", [[2], [0, 2]])
def test_thresholds_not_found_leave_a_hole(draw, f0):
    found = make_found()
    for name in ("N_first", "N_error", "N_always"):
        found[name] = found[name].where(found.f0 < 1000)
    ax = drawn(draw, found.isel(f0=f0))
    seen = [points for points in curves_of(ax) if points[0][1] >= 1000]
    assert bool(seen) == (0 in f0)


def test_figures_need_no_pyplot(root):
    scripts = root / "workflow" / "scripts"
    code = "import sys, draw; print('matplotlib.pyplot' in sys.modules)"
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, cwd=scripts, capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


def limits(ax, label):
    return [line for line in ax.lines if line.get_label().startswith(label)]


def test_thresholds_are_the_data_dashed_and_hollow_where_late():
    ax = drawn(thresholds.draw_thresholds, make_found())
    for i, N in enumerate([1000.0, 1001.0]):
        solid, dashed = [line for line in ax.lines if line.get_color() == curves.LOOKS[i][0]][1:3]
        assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
        assert dashed.get_markerfacecolor() == "white" != solid.get_markerfacecolor()
        assert dashed.get_markevery().tolist() == [False, False, True]
        assert visible(dashed) == [[1000.0, N + 100], [10000.0, N + 1000]]
        assert visible(solid) == [[100.0, N], [1000.0, N + 100]]


def test_a_map_of_thresholds_has_their_values_and_says_where_it_is():
    found = make_found().assign_coords(thickness=1.9)
    ax = drawn(thresholds.draw_threshold_map, found, "f0", "C")
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_array().tolist() == found.N_first.transpose("C", "f0").values.tolist()
    assert ax.get_title("left") == "thickness 1.9 µm"


def test_thresholds_approach_both_limits():
    ax = drawn(thresholds.draw_thresholds, make_found())
    (static,) = limits(ax, curves.LONG)
    assert static.get_ydata() == [990.0, 990.0]
    short = limits(ax, curves.SHORT)
    for line, v, (colour, _) in zip(short, [0.5, 0.6], curves.LOOKS[:2], strict=True):
        assert line.get_color() == colour
        f0, N = line.get_xydata().T
        assert N * 1e-5 / (2e-6 * f0) == pytest.approx(np.full(f0.size, v))
    found = make_found().assign(velocity_change=("C", [np.nan, np.nan]))
    assert not limits(drawn(thresholds.draw_thresholds, found), curves.SHORT)


def test_figures_of_a_pushed_beam_count_its_force_and_no_velocity_change():
    device = {"device": {"beam": {}, "mass": "none", "force": "2.0 uN"}}
    found = make_found().assign(velocity_change=("C", [np.nan, np.nan]))
    found.attrs["config"] = json.dumps(CONFIG | device)
    ax = drawn(thresholds.draw_thresholds, found)
    assert ax.get_ylabel() == "pulse amplitude $N$ (multiples of 2 µN)"
    legend = ax.figure.legends[0]
    words = [legend.get_title().get_text(), *legend_words(ax)]
    assert not [text for text in words if "Delta v" in text]
    two = {"a": device["device"], "b": device["device"] | {"force": "3.0 uN"}}
    attributes = {"config": json.dumps({"devices": two})}
    assert style.multiples(attributes) == "multiples of each force"
    cells = TINY.assign_attrs(config=found.attrs["config"])
    assert drawn(maps.draw_map, cells, found.isel(C=0)).get_ylabel().endswith("of 2 µN)")
    assert drawn(maps.draw_map, TINY, None).get_ylabel().endswith("of $g$)")


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


def test_a_saved_figure_has_fonts_and_facts_and_repeats_byte_for_byte(tmp_path):
    files = []
    for name in ("first", "again"):
        with style.paper():
            figure = history_of(make_history([10, 0, -12]))[0].figure
            style.save(figure, tmp_path / name, ATTRIBUTES)
        files.append([(tmp_path / f"{name}.{kind}").read_bytes() for kind in ("pdf", "png")])
    assert files[0] == files[1]
    pdf = files[0][0]
    assert all(
        part in pdf for part in (b"/FontFile2", b"/Title (A title)", b"/Creator (0.1.0+abc)")
    )
    assert b"1.5 ms" in pdf and b"/Type3" not in pdf and b"Date" not in pdf
    with Image.open(tmp_path / "first.png") as image:
        assert image.size[0] == 2100
        assert image.info["dpi"] == pytest.approx((300, 300), abs=0.01)
        assert [image.info[key] for key in ("Title", "Software")] == ["A title", "0.1.0+abc"]
        assert json.loads(image.info["Comment"]) == CONFIG


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


def test_thresholds_have_bars_gaps_and_islands():
    ax = drawn(thresholds.draw_thresholds, make_found(C=[25.0]))
    (gap,) = artists(ax, FillBetweenPolyCollection)
    assert gap.get_paths()[0].vertices.max(axis=0).tolist() == [10000.0, 2300.0]
    islands, bars = artists(ax, LineCollection)
    ends = [line[:, 1].tolist() for line in islands.get_segments() if len(line)]
    assert ends == [[2000.0, 2050.0], [2100.0, 2150.0]]
    assert bars.get_segments()[0].tolist() == [[100.0, 993.0], [100.0, 1007.0]]


def test_yields_and_requirements_are_drawn_as_they_are():
    ax = drawn(tolerances.draw_yield, make_batch())
    assert ax.lines[0].get_xydata().tolist() == [[0.5, 0.0], [0.4, 1.0]]
    ax = drawn(tolerances.draw_requirement, make_batch().isel(C=0, requirement=0))
    assert sum(patch.get_height() for patch in ax.patches[1:]) == 3
    assert ax.patches[0].get_x() == 1050.0
    found = make_batch(np.array([1500.0])).isel(C=0)
    ax = drawn(tolerances.draw_probability, found)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), found.probability.squeeze())


def test_snap_time_is_between_two_samples_or_not_seen():
    assert histories.snap_time(make_history([10, 0, -8, -12, -5, -12])) == 22.5
    assert math.isnan(histories.snap_time(make_history([10, 0, -8.9])))
    grey = [np.dot(to_rgb(colour), [0.299, 0.587, 0.114]) for colour, _ in curves.LOOKS[:3]]
    assert (np.diff(grey) > 0.1).all()


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
    assert len(panels) == 2 and stress.get_title(loc="left").startswith("largest stress")
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
    legend = figure.legends[0]
    words = [text.get_text() for text in legend.get_texts()]
    colours = ["all requirements are met", "a requirement fails", "points that were computed"]
    assert words == ["trip, trips", "stay, does not trip", *colours]
    title = legend.get_title().get_text()
    assert "met everywhere: easy" in title and "°C" not in title
    assert "error bars up to 1.0 %, between points up to 6.0 % more" in title


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


def test_a_window_has_the_units_of_the_config_and_says_its_temperatures():
    found = make_window().assign_attrs(temperatures=[-40.0, 20.0, 125.0])
    found["reserve"] = found.reserve.where((found.spring < 8) | (found.C < 60))
    found = found.drop_vars(["yield", "yield_bound", "stress_max"])
    units = {"spring": ("mN/um", 1e3), "C": ("mN*s/m", 1e3)}
    window.draw_window(figure := style.double_column(4), found, "spring", "C", units)
    (ax,) = figure.axes
    assert ax.get_xlabel() == "spring (mN/µm)" and ax.get_ylabel().endswith("$C$ (mN s/m)")
    assert ax.get_xlim() == (0.004, 0.008) and ax.get_ylim() == pytest.approx((0.02, 0.06))
    assert scales.typeset("kg/m^3") == "kg/m$^{3}$" and scales.typeset("uN/um") == "N/m"
    legend = figure.legends[0]
    assert "at each temperature from −40 to 125 °C" in legend.get_title().get_text()
    assert "no device, or not known" in [text.get_text() for text in legend.get_texts()]
    assert colour_at(ax, 0.0079, 0.059) is None
    failing = found.assign(reserve=0 * found.reserve + 0.5)
    failing.reserve.attrs = found.reserve.attrs
    window.draw_window(figure := style.double_column(4), failing, "spring", "C")
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "a requirement fails" in words and "all requirements are met" not in words

"""What maps state: cells, states, doubts, snap times, thresholds and points; where they stand."""

import itertools
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, QuadMesh
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.contour import ContourSet
from matplotlib.patches import PathPatch
from small_results import TINY, make_cells, make_found

import snapmap
from snapmap.figures import layout, maps, plane, scales, style
from snapmap.figures.states import (
    ABSENT,
    CROSSING,
    FAILED,
    REST_PROVEN,
    REST_SEEN,
    SNAPS,
    STATES,
    TRIPPED_PROVEN,
    TRIPPED_SEEN,
    end_elsewhere,
    end_states,
    snap_states,
)
from snapmap.io.tables import Point, read_points
from snapmap.sweeps.cube import summary, with_summary

EVERY = make_cells(["0123456"])
"""A cell of each outcome."""


@pytest.fixture(autouse=True)
def paper():
    """The figures' own style; a warning is a fault."""
    with style.paper(), warnings.catch_warnings(action="error"):
        yield


def end_map(cells, **others):
    return maps.draw_end_map(layout.single_box(), cells, **others)


def snap_map(cells, found=None, **others):
    return maps.draw_snap_map(layout.single_box(), cells, found, **others)


def artists(ax, kind):
    return [artist for artist in ax.get_children() if isinstance(artist, kind)]


def test_where_the_beam_breaks_a_line_shows_it():
    cells = make_cells(["2222", "2222", "0022"])
    share = cells.N / 1100 + 0 * cells.f0
    ax = snap_map(cells.assign(stress_share=share.transpose(*cells.outcome.dims)))
    (line,) = artists(ax, ContourSet)
    np.testing.assert_allclose(line.get_paths()[0].vertices[:, 1], 1100)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "largest stress = strength" in labels
    whole = snap_map(cells.assign(stress_share=share / 2))
    assert not artists(whole, ContourSet)


def filled(ax, states):
    """The cells that have each state's colour: rectangles by the state's name."""
    names = {to_rgba(state.colour): state.name for state in states}
    regions = [patch for patch in artists(ax, PathPatch) if not patch.get_hatch()]
    return {names[patch.get_facecolor()]: rectangles(patch) for patch in regions}


def hatched(ax, look):
    """The hatched regions of one look."""
    regions = (patch for patch in artists(ax, PathPatch) if patch.get_hatch() == look["hatch"])
    return [patch for patch in regions if patch.get_hatchcolor() == to_rgba(look["hatchcolor"])]


def rectangles(patch):
    """Lower left and upper right corners of the rectangles of a region."""
    corners = patch.get_path().vertices.reshape(-1, 5, 2)
    return [(*rectangle[0], *rectangle[2]) for rectangle in corners.tolist()]


def visible(line):
    """Points of a line that are not NaN."""
    return line.get_xydata()[~np.isnan(line.get_ydata())].tolist()


def legend_words(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def inches(ax):
    """Width and height of the box."""
    return ax.get_position().size * ax.figure.get_size_inches()


def lightness(rgb):
    """L* of linear RGB."""
    Y = np.clip(rgb, 0, 1) @ [0.2126, 0.7152, 0.0722]
    return 116 * np.cbrt(Y) - 16 if Y > 0.008856 else 903.3 * Y


def lab(rgb):
    """CIELAB of linear RGB, white D65."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    xyz = to_xyz @ np.clip(rgb, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def linear(colour):
    value = np.array(to_rgb(colour))
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


BLIND = {
    "protan": [[0.1523, 1.0526, -0.2049], [0.1145, 0.7863, 0.0992], [-0.0039, -0.0481, 1.0520]],
    "deutan": [[0.3673, 0.8607, -0.2280], [0.2801, 0.6725, 0.0474], [-0.0118, 0.0429, 0.9689]],
    "tritan": [[1.2555, -0.0767, -0.1788], [-0.0784, 0.9308, 0.1476], [0.0047, 0.6914, 0.3039]],
}
"""Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB."""


@pytest.mark.parametrize("states", [STATES, SNAPS])
def test_states_differ_in_grey_and_to_the_colour_blind(states):
    for one, other in itertools.combinations([linear(state.colour) for state in states], 2):
        assert abs(lightness(one) - lightness(other)) > 11.5
        for matrix in BLIND.values():
            assert np.linalg.norm(lab(matrix @ one) - lab(matrix @ other)) > 11.5


def test_end_states_tell_the_side_and_how_sure_it_is():
    states = end_states(EVERY).squeeze().values.tolist()
    known = [REST_SEEN, REST_PROVEN, TRIPPED_SEEN, TRIPPED_PROVEN, REST_PROVEN, FAILED, ABSENT]
    assert states == known
    for share in (0.6, np.nan):
        cells = EVERY.assign(well_share=share * EVERY.well_share)
        crossing = [CROSSING if state in (REST_SEEN, TRIPPED_SEEN) else state for state in known]
        assert end_states(cells).squeeze().values.tolist() == crossing


def test_a_run_that_ends_at_its_snap_was_last_seen_there():
    """As every run of the model `reference` is, whose cells tell no well."""
    untold = {"well": xr.zeros_like(EVERY.well), "well_share": np.nan * EVERY.well_share}
    cells = EVERY.assign(untold).isel(f0=slice(0, 3))
    codes = {0: REST_SEEN, 1: REST_PROVEN, 2: TRIPPED_SEEN}
    expected = [codes[int(code)] for code in cells.outcome.values.ravel()]
    assert end_states(cells).values.ravel().tolist() == expected


def test_snap_states_tell_whether_a_cell_snaps():
    assert snap_states(EVERY).squeeze().values.tolist() == [0, 0, 1, 1, 1, 2, 3]


def test_an_end_is_elsewhere_by_its_side_alone():
    """Not by its label, as of a proof before the horizon in one step alone, nor by its level."""
    cells = make_cells(["2222"])
    for name in ("reproduced", "agreed"):
        cells[name] = xr.zeros_like(cells.outcome)
    assert not end_elsewhere(cells).any()
    cells["well_reproduced"] = (("f0", "N"), [[0], [0], [1], [1]])
    cells["well_share"] = (("f0", "N"), [[1.0], [0.5], [1.0], [0.5]])
    assert end_elsewhere(cells).squeeze().values.tolist() == [True, False, False, False]
    told = with_summary(cells)
    assert told.attrs["cells_ended_elsewhere"] == 1
    assert "another step ended elsewhere (1)" in legend_words(end_map(cells))
    assert "1 ended elsewhere with another step" in summary(told)


@pytest.mark.parametrize("order", [1, -1])
def test_cells_lie_about_their_grid_points_in_the_colours_of_their_states(order):
    cells = make_cells(["21", "03"]).isel(f0=slice(None, None, order), N=slice(None, None, order))
    assert filled(end_map(cells), STATES) == {
        "rest_proven": [(200.0, 1050.0, 800.0, 1150.0)],
        "rest_seen": [(50.0, 950.0, 200.0, 1050.0)],
        "tripped_seen": [(50.0, 1050.0, 200.0, 1150.0)],
        "tripped_proven": [(200.0, 950.0, 800.0, 1050.0)],
    }
    assert filled(snap_map(cells), SNAPS) == {
        "waiting": [(50.0, 950.0, 200.0, 1050.0), (200.0, 1050.0, 800.0, 1150.0)],
        "snapped": [(50.0, 1050.0, 200.0, 1150.0), (200.0, 950.0, 800.0, 1050.0)],
    }


def test_neighbours_of_one_state_are_one_rectangle():
    ax = snap_map(make_cells(["2", "2", "0", "2"], f0=[1000.0]))
    assert [rectangle[1::2] for rectangle in filled(ax, SNAPS)["snapped"]] == [
        (950.0, 1050.0),
        (1150.0, 1350.0),
    ]


def test_legends_name_the_states_present_with_the_number_of_cells():
    assert legend_words(end_map(TINY)) == [
        "not tripped, proven (1)",
        "not tripped when last seen (7)",
        "tripped when last seen (7)",
        "failed (1)",
    ]
    assert legend_words(snap_map(TINY)) == ["does not snap (8)", "snaps (7)", "failed (1)"]


def test_keys_look_as_their_states():
    keys = end_map(EVERY).get_legend().get_patches()
    drawn = [state for i, state in enumerate(STATES) if (end_states(EVERY) == i).any()]
    assert [key.get_facecolor() for key in keys] == [to_rgba(state.colour) for state in drawn]
    assert [key.get_hatch() for key in keys] == [None] * 5 + [plane.ABSENT["hatch"]]


def test_what_ended_elsewhere_is_hatched_light_on_dark():
    cells = make_cells(["43", "20"])
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    ax = end_map(cells)
    ((light,), (dark,)) = hatched(ax, plane.ELSEWHERE), hatched(ax, plane.ELSEWHERE_DARK)
    assert rectangles(light) == [(50.0, 950.0, 200.0, 1050.0), (200.0, 950.0, 800.0, 1050.0)]
    assert rectangles(dark) == [(50.0, 1050.0, 200.0, 1150.0), (200.0, 1050.0, 800.0, 1150.0)]
    assert legend_words(ax)[-1] == "another step ended elsewhere (4)"
    assert not hatched(snap_map(cells), plane.ELSEWHERE)


def test_where_no_device_is_cells_are_hatched():
    (region,) = hatched(end_map(make_cells(["26"])), plane.ABSENT)
    assert rectangles(region) == [(200.0, 900.0, 800.0, 1100.0)]


def test_failed_cells_are_crossed_out():
    crosses = [line.get_xydata().tolist() for line in end_map(TINY).lines]
    assert crosses == [[[6400.0, 1300.0]]] * 2


def test_time_map_shows_the_snap_times_and_grey_elsewhere():
    cells = make_cells(["22", "05"])
    cells["t_snap"] = (("f0", "N"), [[np.nan, 2500.0], [np.nan, 500.0]])
    ax = maps.draw_time_map(layout.single_box(), cells)
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_array().tolist() == [[None, None], [2.5, 0.5]]
    assert mesh.get_clim() == (0.5, 2.5)
    (bar,) = [child for child in ax.child_axes if child.get_xlabel().startswith("first snap")]
    assert bar.get_xlabel().endswith("(ms)")
    assert legend_words(ax) == ["no snap seen (1)", "failed (1)"]
    ax = maps.draw_time_map(layout.single_box(), cells, ends=(10.0, 900.0))
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_array().tolist() == [[None, None], [2500.0, 500.0]]
    assert mesh.get_clim() == (10.0, 900.0)


def test_time_map_without_a_snap_is_grey():
    ax = maps.draw_time_map(layout.single_box(), make_cells(["00", "01"]))
    assert not artists(ax, QuadMesh) and legend_words(ax) == ["no snap seen (4)"]


def test_map_without_thresholds_has_no_line():
    assert not snap_map(make_cells(["22", "00"])).lines


def test_map_shows_the_refined_threshold_in_its_band_dashed_where_late():
    ax = snap_map(make_cells(["22", "00"]), make_found().isel(C=0))
    dashed, solid, always = ax.lines[:3]
    assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
    assert visible(solid) == [[100.0, 1000.0], [1000.0, 1100.0]]
    assert visible(dashed) == [[1000.0, 1100.0], [10000.0, 2000.0]]
    assert visible(always) == [[10000.0, 2300.0]]
    (band,) = artists(ax, FillBetweenPolyCollection)
    corners = band.get_paths()[0].vertices
    assert {993.0, 1007.0} <= set(corners[corners[:, 0] == 100.0, 1])
    assert legend_words(ax)[-5:] == [
        "lowest $N$ that snaps",
        "the same, after the pulse",
        "error band of it",
        "above it, all $N$ snap",
        "limits of long and of short pulses",
    ]


def test_map_keeps_its_limits_and_shows_both_asymptotes():
    cells = make_cells(["22", "00"])
    ax, bare = snap_map(cells, make_found().isel(C=0)), snap_map(cells)
    assert (ax.get_xlim(), ax.get_ylim()) == (bare.get_xlim(), bare.get_ylim())
    static, short = ax.lines[-2:]
    assert static.get_ydata() == [990.0, 990.0]
    f0, N = short.get_xydata().T
    assert N * 1e-5 / (2e-6 * f0) == pytest.approx(np.full(f0.size, 0.5))


def test_boxes_have_one_size_whatever_is_written():
    shocks = [(f"shock {i}", 100.0, 1100.0, True) for i in range(9)]
    few, many = (
        end_map(make_cells(["1"])),
        snap_map(TINY, make_found().isel(C=0), required_shocks=shocks),
    )
    times = maps.draw_time_map(layout.single_box(), TINY)
    for ax in (few, many, times):
        layout.trim(ax.figure)
        assert inches(ax) == pytest.approx(layout.BOX)
    assert few.figure.get_figheight() < many.figure.get_figheight()


@pytest.mark.parametrize("draw", [end_map, snap_map])
def test_nothing_is_clipped_by_the_edge_of_a_figure(draw):
    cells = make_cells(["0123456" * 4] * 40, f0=np.geomspace(100, 3e4, 28), N=np.arange(40) + 6e2)
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    figure = draw(cells).figure
    layout.trim(figure)
    drawn = figure.get_tightbbox()
    assert min(drawn.x0, drawn.y0) >= 0
    assert drawn.x1 <= figure.get_figwidth() and drawn.y1 <= figure.get_figheight()


def panels_of(number, found=None):
    return [
        maps.Panel(TINY.assign_coords(C=25.0 + C), found and found.isel(C=0)) for C in range(number)
    ]


def test_maps_side_by_side_share_one_legend():
    figure = style.double_column(height=9)
    axes = maps.draw_maps(figure, panels_of(2), "f0", "N")
    titles = [ax.get_title(loc="left") for ax in axes.flat]
    assert titles == [scales.value_text("C", C) for C in (25.0, 26.0)]
    (legend,) = [ax.get_legend() for ax in axes.flat if ax.get_legend()]
    words = [text.get_text() for text in legend.get_texts()]
    assert words[:2] == ["not tripped, proven (2)", "not tripped when last seen (14)"]
    assert figure.get_figwidth() == 7


def test_maps_side_by_side_are_of_snaps_where_there_are_thresholds_or_no_ends():
    for panels in (
        panels_of(2, make_found()),
        [maps.Panel(cells.drop_vars("well")) for cells, _ in panels_of(2)],
    ):
        axes = maps.draw_maps(style.double_column(height=9), panels, "f0", "N")
        assert legend_words(axes[-1, 0])[0] == "does not snap (16)"


@pytest.mark.parametrize(
    ("number", "shape"),
    [(1, (1, 1)), (2, (1, 2)), (3, (1, 3)), (4, (2, 2)), (6, (2, 3)), (11, (3, 4)), (12, (3, 4))],
)
def test_maps_stand_in_rows(number, shape):
    axes = maps.draw_maps(style.double_column(height=9), panels_of(number), "f0", "N")
    there = [ax for ax in axes.flat if ax is not None]
    assert axes.shape == shape and len(there) == number
    assert np.ptp([inches(ax) for ax in there], axis=0) == pytest.approx([0, 0], abs=1e-9)
    lowest = [[ax for ax in column if ax is not None][-1] for column in axes.T]
    assert {ax for ax in there if ax.get_xlabel()} == set(lowest)
    assert [ax for ax in there if ax.get_ylabel()] == [axes[-1, 0]]


def test_shocks_are_pointed_out_by_numbers_at_the_edge_if_they_lie_beyond():
    shocks = [
        ("far", 1e3, 1e6, True),
        ("back", 400.0, 1000.0, False),
        ("drop", 400.0, 1000.0, True),
    ]
    ax = snap_map(TINY, required_shocks=shocks)
    top = ax.get_ylim()[1]
    assert [(text.get_text(), *text.xy) for text in ax.texts] == [("1", 1e3, top), ("3", 400, 1000)]
    assert ax.get_title(loc="left").splitlines()[-3:] == [
        "1:\u00a0far at $N$ = 1\u2009000\u2009000, $f_0$ = 1000 Hz",
        "3:\u00a0drop",
        "of another shape or direction: 2:\u00a0back",
    ]


def test_where_no_threshold_is_the_edge_is_marked():
    found = make_found().isel(C=0)
    found["N_first"] = found.N_first.where(found.f0 != 1000)
    ax = snap_map(make_cells(["22", "00"]), found)
    (marks,) = [line for line in ax.lines if line.get_marker() == "x"]
    assert marks.get_xdata().tolist() == [1000.0] and 0 < marks.get_ydata()[0] < 1
    assert "here no threshold found" in legend_words(ax)


def test_names_are_drawn_as_they_are():
    name = r"$\frac$ of {x}"
    ax = snap_map(
        TINY,
        required_shocks=[(name, 400.0, 1000.0, True)],
        own_points=[Point(name, 1000.0, 400.0, True)],
    )
    ax.figure.draw_without_rendering()
    for text in (ax.get_title(loc="left").splitlines()[-1], ax.texts[-1].get_text()):
        assert text.endswith(r"\$\frac\$ of {x}")


POINTS = (Point("bench", 1000.0, 400.0, True), Point("", 1100.0, 800.0, False))


def test_own_points_are_filled_where_the_device_tripped():
    for ax in (end_map(TINY, own_points=POINTS), snap_map(TINY, own_points=POINTS)):
        filled, hollow = ax.lines[-2:]
        assert filled.get_xydata().tolist() == [[400.0, 1000.0]]
        assert hollow.get_xydata().tolist() == [[800.0, 1100.0]]
        assert (filled.get_markerfacecolor(), hollow.get_markerfacecolor()) == ("black", "white")
        assert [text.get_text() for text in ax.texts] == ["bench"]
        assert legend_words(ax)[-2:] == ["own point, tripped", "own point, not tripped"]


def test_own_points_have_no_place_on_other_axes():
    cells = TINY.assign_coords(f0=[1.0, 2.0, 3.0, 4.0]).rename(f0="thickness")
    ax = maps.draw_end_map(layout.single_box(), cells, "thickness", "N", own_points=POINTS)
    assert len(ax.lines) == 2 and not ax.texts


def table(folder, text):
    path = Path(folder) / "points.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_points_are_read_over_frequencies_and_durations(tmp_path):
    text = "N,f0 (Hz),name,snapped\n1000,400,bench,yes\n\n1100,800,,NO\n900,1e3,,\n"
    assert read_points(table(tmp_path, text)) == (*POINTS, Point("", 900.0, 1000.0, None))
    assert read_points(table(tmp_path, "duration,N\n0.5,70\n")) == (Point("", 70.0, 2e3, None),)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "is empty; write a header"),
        ("N,f0,colour\n", "line 1: column 'colour' is unknown; known are N, f0,"),
        ("N,f0,f0 (Hz)\n", "line 1: column f0 comes twice"),
        ("f0\n1\n", "line 1: column N is missing"),
        ("N\n1\n", "line 1: write one of the columns f0 (Hz) and duration (ms)"),
        ("N,f0,duration\n1,2,3\n", "line 1: write one of the columns f0 (Hz) and duration (ms)"),
        ("N,f0\n1,2\n1\n", "line 3, column f0: '' is no number above 0"),
        ("N,f0\n1,2\n1,fast\n", "line 3, column f0: 'fast' is no number above 0"),
        ("N,duration\n-1,2\n", "line 2, column N: '-1' is no number above 0"),
        ("N,duration\n1,0\n", "line 2, column duration: '0' is no number above 0"),
        ("N;f0\n1,5;2\n", "line 2, column N: '1,5' is no number above 0; write decimals with a"),
        ("N,f0\n1,5,2\n", "line 2: has more than 2 columns; write decimals with a point"),
        ('N,f0\n"1,5",2\n', "line 2, column N: '1,5' is no number above 0; write decimals with a"),
        ("N,f0,snapped\n1,2,maybe\n", "line 2, column snapped: 'maybe' is not yes or no"),
    ],
)
def test_faults_of_points_are_named(tmp_path, text, complaint):
    path = table(tmp_path, text)
    with pytest.raises(ValueError) as fault:
        read_points(path)
    assert str(fault.value).startswith(f"{path}: {complaint}")
    assert "\n" not in str(fault.value)


def test_map_states_its_case():
    assert end_map(TINY).get_title(loc="left").replace("\n", " ") == (
        "$C$ = 25 µN µs µm$^{-1}$ versed sine, handout model (5 Hermite elements on half the "
        "beam, all modes), followed 1.5 ms beyond the pulse"
    )


def test_upper_axis_is_the_duration_of_the_pulse():
    ax = end_map(TINY)
    ax.figure.draw_without_rendering()
    (top,) = ax.child_axes
    places = [(ax, 400.0), (top, 2.5)]
    place, place_on_top = (axis.transData.transform([at, 0])[0] for axis, at in places)
    assert place_on_top == pytest.approx(place)


@pytest.mark.parametrize(
    "rows",
    [["0"], ["2"], ["5"], ["6"], ["0125"], ["5", "2", "0"], ["22", "22"], ["00", "00"]],
)
def test_odd_grids_draw_without_warnings(rows):
    cells = make_cells(rows)
    for draw in (end_map, snap_map, lambda cells: maps.draw_time_map(layout.single_box(), cells)):
        draw(cells).figure.draw_without_rendering()


def test_a_lone_value_is_the_only_tick():
    ax = end_map(make_cells(["2"], f0=[1500.0], N=[1000.0]))
    ax.figure.draw_without_rendering()
    for axis, words in [(ax.xaxis, "1500"), (ax.yaxis, "1000"), (ax.child_axes[0].xaxis, "0.667")]:
        labels = [label.get_text() for label in axis.get_ticklabels(which="both")]
        assert labels == [words]


def test_axes_of_a_fine_grid_end_at_its_first_and_last_value_which_are_ticked():
    cells = make_cells(["2" * 31] * 91, f0=np.geomspace(100, 3e4, 31), N=np.linspace(600, 2400, 91))
    ax = end_map(cells)
    ax.figure.draw_without_rendering()
    assert ax.get_xlim() == pytest.approx((100, 3e4)) and ax.get_ylim() == (600, 2400)
    labels = [label.get_text() for label in ax.get_xticklabels() if label.get_text()]
    assert {"1000", "10\u2009000", "30\u2009000"} <= set(labels)
    heights = [label.get_text() for label in ax.get_yticklabels()]
    assert heights == ["600", "900", "1200", "1500", "1800", "2100", "2400"]


def test_very_fine_grids_are_rasterised_in_the_same_colours():
    rows = ["2" * 400] * 150 + ["0" * 400] * 150
    cells = make_cells(rows, f0=np.geomspace(100, 3e4, 400), N=np.linspace(600, 2400, 300))
    ax = end_map(cells)
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_rasterized() and not filled(ax, STATES)
    assert (mesh.get_array() == end_states(cells).values.T).all()
    assert mesh.to_rgba(TRIPPED_SEEN) == to_rgba(STATES[TRIPPED_SEEN].colour)
    assert legend_words(ax) == [
        "not tripped when last seen (60000)",
        "tripped when last seen (60000)",
    ]


def test_a_plot_in_a_notebook_shows_what_snaps_or_where_it_ends():
    words = legend_words(snapmap.plot_outcome(TINY, layout.single_box(), ends=True))
    assert words[0].startswith("not tripped")
    with pytest.raises(ValueError, match="not known"):
        snapmap.plot_outcome(TINY.drop_vars("well"), layout.single_box(), ends=True)
    words = legend_words(
        snapmap.plot_outcome(TINY, layout.single_box(), found=make_found().isel(C=0))
    )
    assert words[0] == "does not snap (8)" and "lowest $N$ that snaps" in words


def test_snap_times_are_the_ends_of_all_maps():
    panels = [TINY.assign(t_snap=TINY.t_snap * factor) for factor in (3.0, np.nan, 0.5)]
    assert maps.snap_times(panels) == (50.0, 300.0)

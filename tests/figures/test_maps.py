"""What maps show: cells, states, doubts, snap times, thresholds and points; where they stand."""

import itertools

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, QuadMesh
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.patches import PathPatch
from small_results import TINY, legend_words, make_cells, make_found, visible

import snapmap
from snapmap.config.points import Point, read_points
from snapmap.figures import curves, maps, plane, style
from snapmap.figures import states as S
from snapmap.sweeps.cube import summary, with_summary

pytestmark = pytest.mark.usefixtures("paper")
EVERY = make_cells(["0123456"])
"""A cell of each outcome."""


def axes():
    return style.single_column(height=5).subplots()


def end_map(cells, **others):
    return maps.draw_map(axes(), cells, shows="ends", **others)


def snap_map(cells, found=None, **others):
    return maps.draw_map(axes(), cells, found, **others)


def time_map(cells, **others):
    return maps.draw_map(axes(), cells, shows="times", **others)


def artists(ax, kind):
    return [artist for artist in ax.get_children() if type(artist) is kind]


def filled(ax):
    """The codes of the cells, over y and x, and the edges between them along x and y."""
    mesh = artists(ax, QuadMesh)[0]
    corners = mesh.get_coordinates()
    return mesh.get_array().tolist(), corners[0, :, 0].tolist(), corners[:, 0, 1].tolist()


def hatched(ax, look):
    """Lower left and upper right corners of the cells that are hatched in one look."""
    regions = [patch for patch in artists(ax, PathPatch) if patch.get_hatch() == look["hatch"]]
    regions = [patch for patch in regions if patch.get_edgecolor() == to_rgba(look["edgecolor"])]
    cells = [patch.get_path().vertices.round(6).reshape(-1, 5, 2) for patch in regions]
    return [(*corners[0], *corners[2]) for region in cells for corners in region]


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


@pytest.mark.parametrize("states", [S.STATES, S.SNAPS])
def test_states_differ_in_grey_and_to_the_colour_blind(states):
    for one, other in itertools.combinations([linear(state.colour) for state in states], 2):
        assert abs(lab(one)[0] - lab(other)[0]) > 11.5
        for matrix in BLIND.values():
            assert np.linalg.norm(lab(matrix @ one) - lab(matrix @ other)) > 11.5


def test_the_first_lines_differ_in_grey():
    grey = [lab(linear(colour))[0] for colour, _ in curves.LOOKS[:3]]
    assert (np.diff(grey) > 11.5).all()


def test_end_states_tell_the_side_and_how_sure_it_is():
    states = S.end_states(EVERY).squeeze().values.tolist()
    seen, proven = (S.REST_SEEN, S.TRIPPED_SEEN), (S.REST_PROVEN, S.TRIPPED_PROVEN)
    known = [seen[0], proven[0], seen[1], proven[1], proven[0], S.FAILED, S.ABSENT]
    assert states == known
    for share in (0.6, np.nan):
        cells = EVERY.assign(well_share=share * EVERY.well_share)
        crossing = [S.CROSSING if state in seen else state for state in known]
        assert S.end_states(cells).squeeze().values.tolist() == crossing


def test_an_end_is_elsewhere_by_its_side_alone():
    """Not by its label, as of a proof before the horizon in one step alone, nor by its level."""
    cells = make_cells(["2222"])
    for name in ("reproduced", "agreed"):
        cells[name] = xr.zeros_like(cells.outcome)
    assert not S.end_elsewhere(cells).any()
    cells["well_reproduced"] = (("f0", "N"), [[0], [0], [1], [1]])
    cells["well_share"] = (("f0", "N"), [[1.0], [0.5], [1.0], [0.5]])
    assert S.end_elsewhere(cells).squeeze().values.tolist() == [True, False, False, False]
    told = with_summary(cells)
    assert told.attrs["cells_ended_elsewhere"] == 1
    assert len(hatched(end_map(cells), plane.ELSEWHERE)) == 1
    assert "1 ended elsewhere with another step" in summary(told)


def test_labels_near_a_change_are_counted():
    """A change between 1000 and 1100 lies within 1 % of 1000 or 1100 one time in five."""
    cells = make_cells(["2" * 20, "0" * 20])
    for order in (slice(None), slice(None, None, -1)):
        told = with_summary(cells.isel(N=order))
        assert told.attrs["labels_near_change"] == 4
        assert "about 4 labels may be wrong, within 1 % of a threshold" in summary(told)
    assert "wrong" not in summary(with_summary(make_cells(["00", "00"])))


@pytest.mark.parametrize("order", [1, -1])
def test_cells_lie_about_their_grid_points_in_the_colours_of_their_states(order):
    cells = make_cells(["21", "03"]).isel(f0=slice(None, None, order), N=slice(None, None, order))
    expected = [[S.REST_SEEN, S.TRIPPED_PROVEN], [S.TRIPPED_SEEN, S.REST_PROVEN]]
    codes, x, y = filled(end_map(cells))
    assert codes == expected and x == pytest.approx([50, 200, 800]) and y == [950, 1050, 1150]
    codes, *_ = filled(snap_map(cells))
    assert codes == [[0, 1], [1, 0]]


def test_time_map_shows_the_snap_times_and_grey_elsewhere():
    cells = make_cells(["22", "05"])
    for size, unit in ((1.0, "(ms)"), (0.1, "(µs)")):
        cells["t_snap"] = (("f0", "N"), size * np.array([[np.nan, 2500.0], [np.nan, 500.0]]))
        times = [2.5, 0.5] if unit == "(ms)" else [250.0, 50.0]
        ax = time_map(cells)
        states, mesh = artists(ax, QuadMesh)
        assert states.get_array().tolist() == [[0, 2], [None, None]]
        assert mesh.get_array().tolist() == [[None, None], times]
        assert mesh.get_clim() == (times[1], times[0])
        assert unit in ax.figure.axes[1].get_xlabel()


def test_panels_of_times_share_their_colours_and_one_bar():
    panels = [
        (TINY.assign(t_snap=TINY.t_snap * factor).assign_coords(C=C), None, ())
        for C, factor in enumerate((3.0, np.nan, 0.5))
    ]
    drawn = maps.draw_maps(style.double_column(height=9), panels, "f0", "N", shows="times")
    meshes = [artists(ax, QuadMesh)[1:] for ax in drawn.flat]
    assert [len(several) for several in meshes] == [1, 0, 1]
    assert {mesh.get_clim() for several in meshes for mesh in several} == {(50.0, 300.0)}


def test_map_shows_the_refined_threshold_in_its_band_dashed_where_late():
    ax = snap_map(make_cells(["22", "00"]), make_found().isel(C=0))
    solid, dashed, always = ax.lines[:3]
    assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
    assert visible(solid) == [[100.0, 1000.0], [1000.0, 1100.0]]
    assert visible(dashed) == [[1000.0, 1100.0], [10000.0, 2000.0]]
    assert visible(always) == [[10000.0, 2300.0]]
    (band,) = artists(ax, FillBetweenPolyCollection)
    corners = band.get_paths()[0].vertices
    assert {993.0, 1007.0} <= set(corners[corners[:, 0] == 100.0, 1])


POINTS = (Point("bench", 1000.0, 400.0, True), Point("", 1100.0, 800.0, False))


def test_own_points_are_filled_where_the_device_tripped():
    for ax in (end_map(TINY, own_points=POINTS), snap_map(TINY, own_points=POINTS)):
        filled, hollow = ax.lines[-2:]
        assert filled.get_xydata().tolist() == [[400.0, 1000.0]]
        assert hollow.get_xydata().tolist() == [[800.0, 1100.0]]
        assert (filled.get_markerfacecolor(), hollow.get_markerfacecolor()) == ("black", "white")
        assert [text.get_text() for text in ax.texts] == ["bench"]


def test_a_plot_in_a_notebook_shows_what_snaps_or_where_it_ends():
    for ends, classify in ((True, S.end_states), (False, S.snap_states)):
        ax = snapmap.plot_outcome(TINY, axes(), found=make_found().isel(C=0), ends=ends)
        assert filled(ax)[0] == classify(TINY).values.T.tolist()
    with pytest.raises(ValueError, match="has no wells"):
        snapmap.plot_outcome(TINY.drop_vars("well"), axes(), ends=True)


def test_cells_are_hatched_where_the_beam_breaks_where_no_device_is_and_what_ends_elsewhere():
    cells = make_cells(["22", "22", "00"])
    share = (cells.N / 1150 + 0 * cells.f0).transpose(*cells.outcome.dims)
    ax = snap_map(cells.assign(stress_share=share))
    expected = [(50.0, 1150.0, 200.0, 1250.0), (200.0, 1150.0, 800.0, 1250.0)]
    assert hatched(ax, plane.BREAKS) == expected
    assert not artists(snap_map(cells.assign(stress_share=share / 2)), PathPatch)
    absent = hatched(end_map(make_cells(["26"])), plane.ABSENT)
    assert absent == [(200.0, 900.0, 800.0, 1100.0)]
    cells = make_cells(["43", "20"])
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    ax = end_map(cells)
    light = [(50.0, 950.0, 200.0, 1050.0), (200.0, 950.0, 800.0, 1050.0)]
    assert hatched(ax, plane.ELSEWHERE) == light
    dark = [(50.0, 1050.0, 200.0, 1150.0), (200.0, 1050.0, 800.0, 1150.0)]
    assert hatched(ax, plane.ELSEWHERE_DARK) == dark
    assert not hatched(snap_map(cells), plane.ELSEWHERE)
    crosses = [line.get_xydata().tolist() for line in end_map(TINY).lines]
    assert crosses == [[[6400.0, 1300.0]]] * 2  # of the failed cell


@pytest.mark.parametrize(("draw", "states"), [(end_map, S.STATES), (snap_map, S.SNAPS)])
def test_each_state_has_its_colour_and_a_key_with_the_number_of_cells(draw, states):
    ax = draw(EVERY)
    (mesh,) = artists(ax, QuadMesh)
    codes = np.ravel(filled(ax)[0]).astype(int)
    keys = ax.figure.legends[0].get_patches()
    for key, words, code in zip(keys, legend_words(ax), np.unique(codes), strict=True):
        seen, colour = mesh.to_rgba(float(code)), to_rgba(states[code].colour)
        assert tuple(seen) == key.get_facecolor() == colour
        assert f"({(codes == code).sum()} " in words


def test_snap_states_tell_whether_a_cell_snaps():
    assert S.snap_states(EVERY).squeeze().values.tolist() == [0, 0, 1, 1, 1, 2, 3]
    # A run that ends at its snap, as of the model `reference`, tells no well.
    untold = {"well": xr.zeros_like(EVERY.well), "well_share": np.nan * EVERY.well_share}
    ends = S.end_states(EVERY.assign(untold)).squeeze().values.tolist()
    assert ends[:3] == [S.REST_SEEN, S.REST_PROVEN, S.TRIPPED_SEEN]


def test_shocks_stand_where_they_are_and_names_are_no_mathematics():
    name = r"$\frac$ of {x}"
    shocks = [("far", 1e3, 1e6, True), ("back", 400.0, 1000.0, False), (name, 400.0, 1000.0, True)]
    ax = snap_map(TINY, required_shocks=shocks)
    top = ax.get_ylim()[1]
    assert [(text.get_text(), *text.xy) for text in ax.texts] == [("1", 1e3, top), ("3", 400, 1000)]
    ax = snap_map(TINY, own_points=[Point(name, 1000.0, 400.0, True)])
    assert ax.texts[0].get_text() == r"\$\frac\$ of {x}"


def test_where_no_threshold_is_the_edge_is_marked():
    found = make_found().isel(C=0)
    found["N_first"] = found.N_first.where(found.f0 != 1000)
    (marks,) = [line for line in snap_map(TINY, found).lines if line.get_markersize() == 3]
    assert marks.get_xdata().tolist() == [1000.0] and 0 < marks.get_ydata()[0] < 1


COLUMNS = "N,f0 (Hz),name,snapped\n1000,400,bench,yes\n\n1100,800,,NO\n900,1e3,,\n"
FAULTS = {
    "": "",
    "N,f0,colour\n": "line 1: column 'colour'",
    "N,f0,f0 (Hz)\n": "line 1: column f0",
    "N\n1\n": "line 1: ",
    "N,f0\n1,2\n1\n": "line 3, column f0: ''",
    "N,duration\n1,0\n": "line 2, column duration: '0'",
    "N,f0\n1,5,2\n": "line 2: ",
    'N,f0\n"1,5",2\n': "line 2, column N: '1,5'",
    "N,f0,snapped\n1,2,maybe\n": "line 2, column snapped: 'maybe'",
}


def test_points_are_read_and_their_faults_named_by_line_column_and_value(tmp_path):
    path = tmp_path / "points.csv"
    for text, points in (
        (COLUMNS, (*POINTS, Point("", 900.0, 1000.0, None))),
        ("duration,N\n0.5,70\n", (Point("", 70.0, 2e3, None),)),
    ):
        path.write_text(text, encoding="utf-8")
        assert read_points(path) == points
    for text, place in FAULTS.items():
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError) as fault:
            read_points(path)
        assert str(fault.value).startswith(f"{path}: {place}") and "\n" not in str(fault.value)


def test_axes_end_at_the_grid_with_the_duration_above():
    ax = end_map(TINY)
    ax.figure.draw_without_rendering()
    (top,) = ax.child_axes
    places = [(ax, 400.0), (top, 2.5)]
    place, place_on_top = (axis.transData.transform([at, 0])[0] for axis, at in places)
    assert place_on_top == pytest.approx(place)
    rows = ["2" * 400] * 150 + ["0" * 400] * 150
    cells = make_cells(rows, f0=np.geomspace(100, 3e4, 400), N=np.linspace(600, 2400, 300))
    ax = end_map(cells)
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_rasterized() and (mesh.get_array() == S.end_states(cells).values.T).all()
    assert ax.get_xlim() == pytest.approx((100, 3e4)) and ax.get_ylim() == (600, 2400)


@pytest.mark.parametrize("rows", [["5"], ["6"], ["5", "2", "0"]])
def test_odd_grids_draw_without_warnings(rows):
    cells = make_cells(rows)
    for draw in (end_map, snap_map, time_map):
        draw(cells).figure.draw_without_rendering()

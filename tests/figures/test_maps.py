"""What maps show: cells, states, doubts, snap times, thresholds and points; where they stand."""

import itertools
import json
from functools import partial

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, QuadMesh
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.patches import PathPatch
from small_results import TINY, artists, legend_words, make_cells, make_found, visible
from small_studies import cases_of

import snapmap
from snapmap.config.points import Point, read_points
from snapmap.figures import captions, curves, maps, plane, scales, style
from snapmap.figures import states as S
from snapmap.sweeps.cube import summary, with_summary

FAULTS, BLIND, SETTLED = cases_of(__file__).values()

pytestmark = pytest.mark.usefixtures("sketch")
EVERY = make_cells(["0123456"])
"""A cell of each outcome."""


def axes():
    return style.single_column(height=5).subplots()


def snap_map(cells, thresholds=None, shows="snaps", **others):
    return maps.draw_map(axes(), cells, thresholds, shows=shows, **others)


end_map, time_map = (partial(snap_map, shows=shows) for shows in ("ends", "times"))


def filled(ax):
    """The codes of the cells, over y and x, and the edges between them along x and y."""
    mesh = artists(ax, QuadMesh)[0]
    corners = mesh.get_coordinates()
    return mesh.get_array().tolist(), corners[0, :, 0].tolist(), corners[:, 0, 1].tolist()


def hatched(ax, look):
    """Lower left and upper right corners of the cells that are hatched in this look."""
    pen = look["hatch"], to_rgba(look["edgecolor"])
    regions = [p for p in artists(ax, PathPatch) if (p.get_hatch(), p.get_edgecolor()) == pen]
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


@pytest.mark.parametrize("states", [S.STATES, S.SNAPS])
def test_states_differ_in_grey_and_to_the_colour_blind_and_lines_in_grey(states):
    for a, b in itertools.combinations([linear(state.colour) for state in states], 2):
        assert abs(lab(a)[0] - lab(b)[0]) > 11.5
        assert all(np.linalg.norm(lab(eye @ a) - lab(eye @ b)) > 11.5 for eye in BLIND)
    assert (np.diff([lab(linear(colour))[0] for colour, _ in curves.LOOKS[:3]]) > 11.5).all()


def test_states_tell_whether_a_cell_snaps_and_the_side_of_its_end_and_how_sure_that_is():
    states = lambda cells, of=S.end_states: of(cells).squeeze().values.tolist()  # noqa: E731
    assert states(EVERY, S.snap_states) == [0, 0, 1, 1, 1, 2, 3]
    seen = S.REST_SEEN, S.TRIPPED_SEEN
    settled = [S.TRIPPED_SETTLED, S.REST_SETTLED, S.FAILED, S.ABSENT]
    known = [S.REST_SEEN, S.REST_SETTLED, S.TRIPPED_SEEN, *settled]
    assert states(EVERY) == known
    crossing = [S.CROSSING if state in seen else state for state in known]
    for share in (0.6, np.nan):
        assert states(EVERY.assign(well_share=share * EVERY.well_share)) == crossing
    # A run that ends at its snap, as of the model `reference`, has no well.
    blank = {"well": xr.zeros_like(EVERY.well), "well_share": np.nan * EVERY.well_share}
    assert states(EVERY.assign(blank))[:3] == known[:3]


def test_a_cube_has_the_case_and_the_states_of_its_guide_and_start():
    run = {"horizon": "300 us", "start": "second"}
    blank = EVERY.assign(well=xr.zeros_like(EVERY.well))
    made = blank.assign_attrs(config=json.dumps({"device": {"beam": {"free": True}}, "run": run}))
    words = "versed sine, beam free to tilt, starts in the second shape, followed 0.3 ms"
    assert captions.case(made.attrs) == words
    assert (S.end_states(made) != S.end_states(blank)).any()


def test_an_end_is_elsewhere_by_its_side_alone():
    """Not by its label, as where one step alone settles before the horizon, nor by its level."""
    cells = make_cells(["2222"])
    cells = cells.assign(dict.fromkeys(("reproduced", "agreed"), xr.zeros_like(cells.outcome)))
    assert not (S.end_states(cells) == S.ELSEWHERE).any()
    cells["well_reproduced"] = (("f0", "N"), [[0], [0], [1], [1]])
    cells["well_share"] = (("f0", "N"), [[1.0], [0.5], [1.0], [0.5]])
    states = [S.ELSEWHERE, S.CROSSING, S.TRIPPED_SEEN, S.CROSSING]
    assert S.end_states(cells).squeeze().values.tolist() == states
    assert len(hatched(end_map(cells), plane.HATCHES["elsewhere"])) == 1
    assert with_summary(cells).attrs["cells_ended_elsewhere"] == 1
    assert "; 1 on another side with a smaller time step; " in summary(with_summary(cells))


def test_a_cell_that_another_step_contradicts_is_in_no_other_state_and_nothing_is_proven():
    """A settled run, too: legend and summary call no cell both settled and ended elsewhere."""
    cells = make_cells(["33", "33", "11"])
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    cells.well_reproduced[..., 2] = 1
    words = legend_words(end_map(cells))
    assert words == ["tripped, settled (2 cells)", "ends elsewhere with another step (4 cells)"]
    counted = with_summary(cells)
    line = "6 cells, all settled; 4 on another side with a smaller time step; "
    assert summary(counted).startswith(line)
    assert not any("proven" in state.words for state in S.STATES)


@pytest.mark.parametrize(("row", "words"), SETTLED)
def test_all_are_settled_where_none_is_left(row, words):
    assert summary(with_summary(make_cells([row]))).startswith(words)


@pytest.mark.parametrize("order", [1, -1])
def test_cells_in_any_order_lie_about_their_grid_points_and_labels_near_a_change_count(order):
    """A change between 1000 and 1100 lies within 1 % of 1000 or 1100 one time in five."""
    turn = slice(None, None, order)
    cells = make_cells(["21", "03"]).isel(f0=turn, N=turn)
    codes, x, y = filled(end_map(cells))
    assert codes == [[S.REST_SEEN, S.TRIPPED_SETTLED], [S.TRIPPED_SEEN, S.REST_SETTLED]]
    assert x == pytest.approx([50, 200, 800]) and y == [950, 1050, 1150]
    assert filled(snap_map(cells))[0] == [[0, 1], [1, 0]]
    counted = with_summary(make_cells(["2" * 20, "0" * 20]).isel(N=turn))
    assert counted.attrs["labels_near_change"] == 4
    assert "about 4 within 1 % of a threshold, of uncertain label" in summary(counted)
    assert "uncertain" not in summary(with_summary(make_cells(["00", "00"])))


@pytest.mark.parametrize(
    ("last", "unit", "times"), [(2500, "(ms)", [2.5, 0.5]), (250, "(µs)", [250.0, 50.0])]
)
def test_a_map_of_times_shows_the_snap_times_and_the_colour_of_no_snap_elsewhere(last, unit, times):
    cells = make_cells(["22", "05"])
    cells["t_snap"] = (("f0", "N"), [[np.nan, last], [np.nan, last / 5]])
    ax = time_map(cells)
    states, mesh = artists(ax, QuadMesh)
    assert states.get_array().tolist() == [[0, 2], [None, None]]
    lightest = lab(linear(S.TIME_COLOURS(1.0)[:3]))[0]
    assert lab(linear(S.WAITING.colour))[0] - lightest > 11.5
    assert mesh.get_array().tolist() == [[None, None], times]
    assert mesh.get_clim() == (times[1], times[0])
    assert unit in ax.figure.axes[1].get_xlabel()


def test_maps_of_several_axes_lie_in_rows_and_columns():
    """A column has one value of an axis, and each row one of the others."""
    for sizes, columns in (((3, 2), 3), ((2, 3), 3), ((2, 3, 2), 3), ((2, 2), 2), ((1, 4, 2), 4)):
        keys = ("device", "temperature", "C")[: len(sizes)]
        points = [*itertools.product(*(map(float, range(size)) for size in sizes))]
        cells = [TINY.assign_coords(dict(zip(keys, point, strict=True))) for point in points]
        panels, across = maps._in_columns([(part, None, ()) for part in cells])
        assert across == columns
        grid = np.array([[part[key].item() for key in keys] for part, *_ in panels])
        assert {*map(tuple, grid.tolist())} == {*points}
        grid = grid.reshape(-1, columns, len(keys))
        in_columns, in_rows = (grid == grid[:1]).all((0, 1)), (grid == grid[:, :1]).all((0, 1))
        assert (in_columns | in_rows).all()
    one = [(TINY.assign_coords(C=float(C)), None, ()) for C in range(10)]
    places = (0, 1), (1, 2), (0, 2)
    holes = [(TINY.assign_coords(C=C, temperature=T), None, ()) for C, T in places]
    made = [(part, *maps._in_columns(part)) for part in (holes, *(one[:n] for n in range(1, 11)))]
    assert all(panels == part for part, panels, _ in made)
    assert [columns for *_, columns in made] == [3, 2, 2, 3, 2, 3, 3, 4, 4, 3, 4]


def test_panels_of_times_share_their_colours_and_one_bar():
    panels, hot = [], TINY.assign_coords(temperature=20.0)
    for C, factor in enumerate((3.0, np.nan, 0.5, 1.0, 1.0)):
        cells = hot.assign(t_snap=hot.t_snap * factor).assign_coords(C=C)
        panels.append((cells, None, ()))
    figure = style.double_column(height=9)
    *panels, left = maps.draw_maps(figure, panels, "f0", "N", shows="times").flat
    meshes = [[mesh.get_clim() for mesh in artists(ax, QuadMesh)[1:]] for ax in panels]
    assert meshes == [[(50.0, 300.0)], [], *[[(50.0, 300.0)]] * 3] and left is None
    titles = [f"$C$ = {C} µN µs µm$^{{-1}}$" for C in range(5)]
    assert [ax.get_title(loc="left") for ax in panels] == titles
    assert figure.legends[0].get_title().get_text().startswith("temperature 20 °C\nversed sine")
    assert [bool(ax.get_xlabel()) for ax in panels] == [False, False, True, True, True]
    assert [len(ax.child_axes) for ax in panels] == [1, 1, 1, 0, 0]


def test_a_map_has_the_threshold_in_its_band_dashed_where_late_and_marked_where_there_is_none():
    cells, thresholds = make_cells(["22", "00"]), make_found().isel(C=0)
    ax = snap_map(cells, thresholds)
    solid, dashed, always = ax.lines[:3]
    assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
    assert visible(solid) == [[100.0, 1000.0], [1000.0, 1100.0]]
    assert visible(dashed) == [[1000.0, 1100.0], [10000.0, 2000.0]]
    ends = [[10**3.5, 2300.0], [10**4.5, 2300.0]]  # halfway to its neighbours
    np.testing.assert_allclose(visible(always), ends)
    (band,) = artists(ax, FillBetweenPolyCollection)
    corners = band.get_paths()[0].vertices
    assert {993.0, 1007.0} <= set(corners[corners[:, 0] == 100.0, 1])
    known = thresholds[["N_first", "t_snap"]].where(thresholds.f0 != 1000)
    lines = snap_map(cells, thresholds.assign(known)).lines
    assert [visible(line) for line in lines[:2]] == [[[100.0, 1000.0]], [[10000.0, 2000.0]]]
    (marks,) = [line for line in lines if line.get_markersize() == 3]
    assert marks.get_xdata().tolist() == [1000.0] and 0 < marks.get_ydata()[0] < 1


POINTS = (Point("bench", 1000.0, 400.0, True), Point("", 1100.0, 800.0, False))


@pytest.mark.parametrize("draw", [end_map, snap_map])
def test_measured_points_are_filled_where_the_device_tripped(draw):
    ax = draw(TINY, own_points=POINTS)
    marks = [(mark.get_markerfacecolor(), mark.get_xydata().tolist()) for mark in ax.lines[-2:]]
    assert marks == [("black", [[400.0, 1000.0]]), ("white", [[800.0, 1100.0]])]
    assert [text.get_text() for text in ax.texts] == ["bench"]


@pytest.mark.parametrize(("number", "named"), [(12, 12), (13, 0)])
def test_at_most_twelve_points_have_names(number, named):
    ax = snap_map(TINY, own_points=[Point(f"p{i}", 1000.0, 400.0, None) for i in range(number)])
    assert [text.get_text() for text in ax.texts] == [f"p{i}" for i in range(named)]


def test_points_and_shocks_stand_at_their_duration_where_that_is_the_axis():
    """In ms: 400 Hz is 2.5 ms."""
    ax = axes()
    ax.set(xlim=(1.0, 5.0), ylim=(900.0, 1200.0))
    plane.draw_points(ax, "duration", POINTS)
    assert [line.get_xydata().tolist() for line in ax.lines] == [[[2.5, 1000]], [[1.25, 1100]]]
    plane.number_shocks(ax, "duration", [("drop", 400.0, 1000.0, True)])
    assert [text.xy[0] for text in ax.texts] == [2.5, 2.5]  # of the first point and the shock


def test_what_snaps_always_is_marked_where_it_differs_by_more_than_the_error():
    found, apart = make_found().isel(C=0), xr.DataArray([7.0, 8.0, 300.0], dims="f0")
    scale = scales.scale_of("N", np.arange(3.0))
    curves.draw_band(ax := axes(), scale, found.assign(N_always=found.N_first + apart))
    steps = [[0.5, 1108.0], [1.5, 1108.0], [1.5, 2300.0], [2.5, 2300.0]]
    assert visible(ax.lines[2]) == steps


def test_a_plot_in_a_notebook_shows_what_snaps_or_where_it_ends():
    for ends, classify in ((True, S.end_states), (False, S.snap_states)):
        ax = snapmap.plot_outcome(TINY, axes(), thresholds=make_found().isel(C=0), ends=ends)
        assert filled(ax)[0] == classify(TINY).values.T.tolist()
    with pytest.raises(ValueError, match="has no ends"):
        snapmap.plot_outcome(TINY.drop_vars("well"), axes(), ends=True)


def test_a_plot_takes_only_the_thresholds_of_its_cells():
    found, plot = make_found(), partial(snapmap.plot_outcome, TINY)
    one = plot(axes(), thresholds=found.isel(C=[0]))
    assert "threshold" in {line.get_label() for line in one.lines}
    wrong = {"has several C": found, "have no axis f0": found.isel(C=0, f0=0)}
    wrong["C is 200.0, but 25.0 in the cube"] = found.isel(C=1)
    for words, thresholds in wrong.items():
        with pytest.raises(ValueError, match=f"^thresholds: {words}"):
            plot(axes(), thresholds=thresholds)
    for cube in (TINY.isel(f0=[]), TINY.drop_vars("t_snap"), TINY.rename(f0="pace")):
        with pytest.raises(ValueError, match=r"^(cube|x): "):
            snapmap.plot_outcome(cube, axes(), x="pace" if "pace" in cube.dims else "f0")


def test_cells_are_hatched_where_the_beam_breaks_where_no_device_is_and_what_ends_elsewhere():
    cells = make_cells(["22", "22", "00"])
    share = (cells.N / 1150 + 0 * cells.f0).transpose(*cells.outcome.dims)
    breaks = hatched(snap_map(cells.assign(stress_share=share)), plane.BREAKS)
    assert breaks == [(50.0, 1150.0, 200.0, 1250.0), (200.0, 1150.0, 800.0, 1250.0)]
    assert not artists(snap_map(cells.assign(stress_share=share / 2)), PathPatch)
    absent = hatched(end_map(make_cells(["26"])), plane.HATCHES["absent"])
    assert absent == [(200.0, 900.0, 800.0, 1100.0)]
    cells = make_cells(["43", "20"])
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    apart = [(x, y, 4 * x, y + 100) for x in (50, 200) for y in (950, 1050)]
    assert hatched(end_map(cells), plane.HATCHES["elsewhere"]) == apart
    assert not hatched(snap_map(cells), plane.HATCHES["elsewhere"])
    crosses = [line.get_xydata().tolist() for line in end_map(TINY).lines]
    assert crosses == [[[6400.0, 1300.0]]] * 2  # of the failed cell


@pytest.mark.parametrize(("draw", "states"), [(end_map, S.STATES), (snap_map, S.SNAPS)])
def test_each_state_has_its_colour_and_a_key_with_the_number_of_cells(draw, states):
    ax = draw(EVERY)
    (mesh,) = artists(ax, QuadMesh)
    codes = np.ravel(filled(ax)[0]).astype(int)
    keys = zip(ax.figure.legends[0].get_patches(), legend_words(ax), strict=True)
    for (key, words), code in zip(keys, np.unique(codes), strict=True):
        colour = to_rgba(states[code].colour)
        assert tuple(mesh.to_rgba(float(code))) == key.get_facecolor() == colour
        assert f"({(codes == code).sum()} " in words


def test_shocks_stand_where_they_are_and_names_are_no_mathematics():
    name = r"$\frac$ of {x}"
    shocks = [("far", 1e3, 1e6, True), ("back", 400.0, 1000.0, False), (name, 400.0, 1000.0, True)]
    ax = snap_map(TINY, required_shocks=shocks)
    numbers = [(text.get_text(), *text.xy) for text in ax.texts]
    assert numbers == [("1", 1e3, ax.get_ylim()[1]), ("3", 400, 1000)]
    ax = snap_map(TINY, own_points=[Point(name, 1000.0, 400.0, True)])
    assert ax.texts[0].get_text() == r"\$\frac\$ of {x}"


COLUMNS = "N,f0 (Hz),name,snapped\n1000,400,bench,yes\n\n1100,800,,NO\n900,1e3,,\n"
READ = {COLUMNS: (*POINTS, Point("", 900.0, 1000.0, None))}
READ["duration,N\n0.5,70\n"] = (Point("", 70.0, 2e3, None),)


@pytest.mark.parametrize("text", [*READ, *FAULTS])
def test_points_are_read_or_their_fault_is_named_by_line_column_and_value(tmp_path, text):
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8")
    if text in READ:
        assert read_points(path) == READ[text]
        return
    with pytest.raises(ValueError) as fault:
        read_points(path)
    assert str(fault.value).startswith(f"{path}: {FAULTS[text]}") and "\n" not in str(fault.value)


def test_axes_end_at_the_grid_with_the_duration_above():
    ax = end_map(TINY)
    ax.figure.draw_without_rendering()
    (top,) = ax.child_axes
    place = ax.transData.transform([400.0, 0])[0]
    assert top.transData.transform([2.5, 0])[0] == pytest.approx(place)
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

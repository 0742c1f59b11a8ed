"""What the figures state: cells, classes, threshold and snap; and how they are saved."""

import io
import json
import math
import subprocess
import sys
import warnings

import draw_history
import draw_map
import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.patches import StepPatch
from PIL import Image

from snapmap.cube import COORDINATES, VARIABLES, write
from snapmap.figures import histories, maps, style
from snapmap.outcome import OUTCOMES

CONFIG = {
    "model": {"name": "handout"},
    "sweep": {"horizon": "1.5 ms"},
    "histories": [{"N": 1000, "f0": "1500 Hz", "C": "0.025 uN*us/um"}],
}
ATTRIBUTES = {"title": "A title", "code_version": "0.1.0+abc", "config": json.dumps(CONFIG)}


def make_cells(rows, f0=None, N=None):
    """Cells of C = 25 whose outcomes are digits: one row of text per N, the highest first."""
    outcome = np.array([[int(digit) for digit in row] for row in rows[::-1]], np.int8).T
    f0 = 100.0 * 4.0 ** np.arange(outcome.shape[0]) if f0 is None else f0
    N = 1000.0 + 100 * np.arange(outcome.shape[1]) if N is None else N
    variables = {
        "outcome": (("f0", "N"), outcome, VARIABLES["outcome"]),
        "t_snap": (("f0", "N"), np.where(outcome == 2, 100.0, np.nan), VARIABLES["t_snap"]),
    }
    axes = {"C": ((), 25.0, COORDINATES["C"]), "f0": f0, "N": N}
    return xr.Dataset(variables, axes, ATTRIBUTES)


TINY = make_cells(["2225", "2022", "0020", "0100"])


def make_history(w_mid):
    """A history whose midpoint takes these positions, 10 us apart, 1 um below the mass."""
    w_mid = np.array(w_mid, float)
    values = {"w_mid": w_mid, "z_mass": w_mid + 1, "contact_force": 0 * w_mid}
    values["acceleration"] = np.full(w_mid.size, 0.02)
    variables = {key: ("time", column) for key, column in values.items()}
    attributes = ATTRIBUTES | {"second_equilibrium": -9.0, "gravity": 1e-5}
    return xr.Dataset(variables, {"time": 10.0 * np.arange(w_mid.size)}, attributes)


@pytest.fixture(autouse=True)
def paper():
    """The figures' own style; a warning is a fault."""
    with style.paper(), warnings.catch_warnings(action="error"):
        yield


def map_of(cells):
    return maps.draw_map(style.single_column(height=3.4).subplots(), cells)


def artists(ax, kind):
    return [artist for artist in ax.get_children() if isinstance(artist, kind)]


def legend_words(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def history_of(history):
    figure = style.double_column(height=4.2)
    return histories.draw_history(figure.subplots(3, sharex=True), history)


def line(ax, label):
    return next(line for line in ax.lines if line.get_label().startswith(label))


def test_geometric_edges():
    edges = maps.geometric_edges(np.array([100.0, 400.0, 6400.0]))
    assert edges.tolist() == [50.0, 200.0, 1600.0, 25600.0]


def test_arithmetic_edges():
    assert maps.arithmetic_edges(np.array([-1.0, 0.0, 3.0])).tolist() == [-1.5, -0.5, 1.5, 4.5]


@pytest.mark.parametrize("value", [-1000.0, 0.0, 1e-3, 1500.0])
def test_edges_surround_a_lone_value(value):
    low, high = maps.arithmetic_edges(np.array([value]))
    assert low < value < high
    assert low + high == pytest.approx(2 * value)


def test_geometric_edges_surround_a_lone_value():
    low, high = maps.geometric_edges(np.array([1500.0]))
    assert 0 < low < 1500 < high
    assert low * high == pytest.approx(1500.0**2)


def test_cells_lie_about_their_grid_points():
    (mesh,) = artists(map_of(TINY), QuadMesh)
    corners = mesh.get_coordinates()
    assert corners[0, :, 0].tolist() == [50.0, 200.0, 800.0, 3200.0, 12800.0]
    assert corners[:, 0, 1].tolist() == [950.0, 1050.0, 1150.0, 1250.0, 1350.0]


@pytest.mark.parametrize("order", [1, -1])
def test_drawn_class_is_the_outcome(order):
    cells = TINY.isel(f0=slice(None, None, order), N=slice(None, None, order))
    (mesh,) = artists(map_of(cells), QuadMesh)
    assert (mesh.get_array() == TINY.outcome.values.T).all()


@pytest.mark.parametrize("name", OUTCOMES)
def test_drawn_colour_is_that_of_the_class(name):
    (mesh,) = artists(map_of(TINY), QuadMesh)
    assert mesh.to_rgba(OUTCOMES.index(name)) == to_rgba(maps.COLOURS[name])


def test_every_outcome_has_colour_and_words():
    assert tuple(maps.COLOURS) == tuple(maps.WORDS) == OUTCOMES


def test_colours_darken_in_grey():
    grey = [np.dot(to_rgb(colour), [0.299, 0.587, 0.114]) for colour in maps.COLOURS.values()]
    assert (np.diff(grey) < -0.1).all()


def test_legend_names_the_classes_present():
    assert legend_words(map_of(TINY)) == [
        "no snap seen (7)",
        "never snaps (1)",
        "snaps (7)",
        "failed (1)",
        "lowest $N$ that snaps",
    ]


def test_lowest_snap_is_the_edge_below_the_first_snap():
    assert maps.lowest_snap(TINY).tolist() == [1150.0, 1250.0, 1050.0, 1150.0]


@pytest.mark.parametrize("column", ["0000", "0100", "2220", "0052", "5002", "5555"])
def test_lowest_snap_is_unknown(column):
    """Nothing snaps; the first N does; a failure lies below."""
    assert np.isnan(maps.lowest_snap(make_cells(column[::-1]))).all()


@pytest.mark.parametrize("snap", "234")
def test_whatever_follows_the_snap_it_counts(snap):
    assert maps.lowest_snap(make_cells(["0", snap, "1", "0"])).tolist() == [1150.0]


def test_threshold_steps_between_cells():
    (steps,) = artists(map_of(TINY), StepPatch)
    corners = list(dict.fromkeys(map(tuple, steps.get_path().vertices.tolist())))
    assert corners == [
        (50.0, 1150.0),
        (200.0, 1150.0),
        (200.0, 1250.0),
        (800.0, 1250.0),
        (800.0, 1050.0),
        (3200.0, 1050.0),
        (3200.0, 1150.0),
        (12800.0, 1150.0),
    ]


@pytest.mark.parametrize("rows", [["000", "000"], ["222", "222"], ["555", "000"]])
def test_no_threshold_without_a_change(rows):
    ax = map_of(make_cells(rows))
    assert artists(ax, StepPatch) == []
    assert len(legend_words(ax)) == len(set("".join(rows)))


def test_failed_cells_are_crossed_out():
    crosses = [line.get_xydata().tolist() for line in map_of(TINY).lines]
    assert crosses == [[[6400.0, 1300.0]]] * 2


def test_map_states_its_case():
    assert map_of(TINY).get_title(loc="left") == (
        "$C$ = 25 µN µs µm$^{-1}$\nhandout model, followed 1500 µs beyond the pulse"
    )


def test_upper_axis_is_the_duration_of_the_pulse():
    ax = map_of(TINY)
    ax.figure.draw_without_rendering()
    (top,) = ax.child_axes
    places = [(ax, 400.0), (top, 2.5)]
    place, place_on_top = (axis.transData.transform([at, 0])[0] for axis, at in places)
    assert place_on_top == pytest.approx(place)


@pytest.mark.parametrize(
    "rows",
    [["0"], ["2"], ["5"], ["0125"], ["5", "2", "0"], ["22", "22"], ["00", "00"], ["55", "55"]],
)
def test_odd_grids_draw_without_warnings(rows):
    ax = map_of(make_cells(rows))
    ax.figure.draw_without_rendering()
    (mesh,) = artists(ax, QuadMesh)
    assert mesh.get_array().shape == (len(rows), len(rows[0]))


def test_a_lone_value_is_the_only_tick():
    ax = map_of(make_cells(["2"], f0=[1500.0], N=[1000.0]))
    ax.figure.draw_without_rendering()
    for axis, words in [(ax.xaxis, "1500"), (ax.yaxis, "1000"), (ax.child_axes[0].xaxis, "0.667")]:
        labels = [label.get_text() for label in axis.get_ticklabels(which="both")]
        assert labels == [words]


def test_fine_grid_draws_without_warnings():
    rows = ["2" * 250] * 100 + ["0" * 250] * 100
    ax = map_of(make_cells(rows, f0=np.geomspace(100, 3e4, 250), N=np.linspace(600, 2400, 200)))
    ax.figure.draw_without_rendering()
    assert legend_words(ax)[:2] == ["no snap seen (25000)", "snaps (25000)"]


def test_snap_time_is_between_two_samples():
    assert histories.snap_time(make_history([10, 0, -8, -12, -5, -12])) == 22.5


def test_snap_time_is_not_seen():
    assert math.isnan(histories.snap_time(make_history([10, 0, -8.9])))


def test_history_draws_the_data_in_ms_and_multiples_of_g():
    history = make_history([10, 0, -8, -12])
    positions, force, shock = history_of(history)
    time = [0.0, 0.01, 0.02, 0.03]
    beam, mass = line(positions, "midpoint"), line(positions, "mass")
    assert beam.get_xydata().tolist() == [[t, w] for t, w in zip(time, history.w_mid, strict=True)]
    assert mass.get_ydata().tolist() == [11, 1, -7, -11]
    assert force.lines[0].get_ydata().tolist() == [0, 0, 0, 0]
    assert shock.lines[0].get_ydata() == pytest.approx([2000, 2000, 2000, 2000])


def test_history_marks_the_snap_on_all_axes():
    axes = history_of(make_history([10, 0, -8, -12]))
    assert line(axes[0], "second").get_ydata() == [-9.0, -9.0]
    assert line(axes[0], "snap").get_xydata().tolist() == [[0.0225, -9.0]]
    assert legend_words(axes[0])[-1] == "snap at 0.0225 ms"
    assert all([0.0225, 0.0225] in [list(line.get_xdata()) for line in ax.lines] for ax in axes)


def test_history_without_a_snap_has_no_mark():
    axes = history_of(make_history([10, 5, 10]))
    assert [len(ax.lines) for ax in axes] == [3, 1, 1]


def test_history_states_its_case():
    title = history_of(make_history([10, 5, 10]))[0].get_legend().get_title().get_text()
    assert title == "$N = 1000$, $f_0$ = 1500 Hz, $C$ = 0.025 µN µs µm$^{-1}$, handout model"


def save_both(folder):
    """Save a map and a history through the rules' own functions; the four files' bytes."""
    cube, history = folder / "cube.nc", folder / "history.nc"
    write(TINY.expand_dims("C"), cube)
    write(make_history([10, 0, -8, -12]), history)
    paths = [folder / name for name in ("map.pdf", "map.png", "history.pdf", "history.png")]
    draw_map.draw_map(cube, 0, *paths[:2])
    draw_history.draw_history(history, *paths[2:])
    assert sorted(folder.iterdir()) == sorted([cube, history, *paths])
    return {path.name: path.read_bytes() for path in paths}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    return save_both(tmp_path_factory.mktemp("figures"))


def test_saved_files_repeat_byte_for_byte(saved, tmp_path):
    assert save_both(tmp_path) == saved


@pytest.mark.parametrize("name", ["map.pdf", "history.pdf"])
def test_pdf_embeds_truetype_fonts(saved, name):
    assert b"/FontFile2" in saved[name]
    assert b"/Type3" not in saved[name]


def test_pdf_carries_provenance_and_no_date(saved):
    assert b"/Title (A title)" in saved["map.pdf"]
    assert b"/Creator (0.1.0+abc)" in saved["map.pdf"]
    assert b"1.5 ms" in saved["map.pdf"]
    assert b"Date" not in saved["map.pdf"]


def test_png_carries_provenance_at_300_dpi(saved):
    with Image.open(io.BytesIO(saved["map.png"])) as image:
        assert image.size == (1020, 1020)
        assert image.info["dpi"] == pytest.approx((300, 300), abs=0.01)
        assert image.info["Title"] == "A title"
        assert image.info["Software"] == "0.1.0+abc"
        assert json.loads(image.info["Comment"]) == CONFIG


@pytest.mark.parametrize(("make", "width"), [(style.single_column, 3.4), (style.double_column, 7)])
def test_figures_have_the_widths_of_columns(make, width):
    assert make(height=3).get_size_inches().tolist() == [width, 3]


def test_style_leaves_the_users_own_alone():
    with matplotlib.rc_context({"font.size": 33}):
        with style.paper():
            assert matplotlib.rcParams["font.size"] == 7
        assert matplotlib.rcParams["font.size"] == 33


def test_figures_need_no_pyplot(root):
    code = "import sys, draw_map, draw_history; print('matplotlib.pyplot' in sys.modules)"
    command, scripts = [sys.executable, "-c", code], root / "workflow" / "scripts"
    run = subprocess.run(command, cwd=scripts, capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"

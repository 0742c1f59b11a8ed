"""What the figures state: cells, classes, thresholds, forces and errors; how they are saved."""

import io
import json
import math
import os
import re
import subprocess
import sys
import warnings

import draw_convergence
import draw_history
import draw_maps
import draw_statics
import draw_thresholds
import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, LineCollection, QuadMesh
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.patches import PathPatch, Polygon
from PIL import Image

from snapmap.axes import COORDINATES
from snapmap.figures import (
    convergence,
    curves,
    histories,
    maps,
    requirements,
    scales,
    statics,
    style,
    thresholds,
    tolerances,
)
from snapmap.io.netcdf import write
from snapmap.solver.outcome import OUTCOMES
from snapmap.sweeps.cube import VARIABLES

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
    flags = {"flag_values": np.arange(len(OUTCOMES)), "flag_meanings": " ".join(OUTCOMES)}
    variables = {
        "outcome": (("f0", "N"), outcome, VARIABLES["outcome"] | flags),
        "t_snap": (("f0", "N"), np.where(outcome == 2, 100.0, np.nan), VARIABLES["t_snap"]),
    }
    axes = {"C": ((), 25.0, COORDINATES["C"]), "f0": f0, "N": N}
    return xr.Dataset(variables, axes, ATTRIBUTES)


TINY = make_cells(["2225", "2022", "0020", "0100"])


F0 = np.array([100.0, 1000.0, 10000.0])


def make_found(C=(25.0, 200.0)):
    """Thresholds of several C at 100, 1000 and 10000 Hz; at the last two islands, and late."""
    N = np.array([1000.0, 1100.0, 2000.0]) + np.arange(len(C))[:, np.newaxis]
    gap = np.array([0.0, 0.0, 300.0])
    nan = np.full((len(C), 2, 2), np.nan)
    last = np.stack([N[:, 2:], N[:, 2:] + 100], axis=-1)
    axes = ("C", "f0")
    variables = {
        "N_first": (axes, N),
        "N_error": (axes, 0 * N + 7.0),
        "N_always": (axes, N + gap),
        "N_latched": (axes, 0 * N + np.nan),
        "t_snap": (axes, np.broadcast_to([5000.0, 500.0, 400.0], N.shape)),
        "islands": (axes, np.broadcast_to([0, 0, 2], N.shape)),
        "island_from": ((*axes, "island"), np.concatenate([nan, last], axis=1)),
        "island_to": ((*axes, "island"), np.concatenate([nan, last + 50], axis=1)),
        "N_static": ((), 990.0),
        "area": ((), 0.5),
        "velocity_change": ("C", 0.5 + 0.1 * np.arange(len(C))),
    }
    return xr.Dataset(variables, {"C": list(C), "f0": F0}, ATTRIBUTES | {"gravity": 1e-5})


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
    attributes |= {"top_force": 70.0, "bottom_force": -30.0} | ATTRIBUTES
    return xr.Dataset(variables, {"branch": ["followed", "unbranched"]}, attributes)


def make_accuracy():
    """Errors of 3 and 6 elements of order 4, of cosines, and of steps of order 2."""
    families = {
        "elements_consistent": {"3 elements, consistent": 1.6e-2, "6 elements, consistent": 1e-3},
        "elements_hrz": {"3 elements, hrz": 2e-2},
        "cosines": {"3 cosines": 1e-3, "6 cosines": 1e-4},
        "cosines_uncorrected": {"3 cosines, uncorrected": 8e-3, "6 cosines, uncorrected": 1e-3},
        "step": {"step 0.1": 0.0, "step 0.4": 1e-5, "step 0.8": 4e-5},
    }
    names = [name for cases in families.values() for name in cases]
    codes = [i for i, cases in enumerate(families.values()) for _ in cases]
    worst = [error for cases in families.values() for error in cases.values()]
    one = ("reference", "C", "f0")
    variables = {
        "threshold_worst": ("model", worst),
        "converged_threshold": (one, [[[1000.0, 1000.0]]]),
        "converged_threshold_error": (one, [[[0.02, 5.0]]]),
        "threshold_decided": (one, [[[1, 0]]]),
    }
    family = ("model", codes, {"flag_meanings": " ".join(families)})
    return xr.Dataset(variables, {"model": names, "family": family}, ATTRIBUTES)


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


def map_of(cells, found=None):
    return maps.draw_map(style.single_column(height=3.6).subplots(), cells, found)


def drawn(draw, dataset, *shape):
    """Axes on which a function has drawn a dataset."""
    return draw(style.double_column(height=3.4).subplots(*shape), dataset)


def visible(line):
    """Points of a line that are not NaN."""
    return line.get_xydata()[~np.isnan(line.get_ydata())].tolist()


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
    edges = scales.geometric_edges(np.array([100.0, 400.0, 6400.0]))
    assert edges.tolist() == [50.0, 200.0, 1600.0, 25600.0]


def test_arithmetic_edges():
    assert scales.arithmetic_edges(np.array([-1.0, 0.0, 3.0])).tolist() == [-1.5, -0.5, 1.5, 4.5]


@pytest.mark.parametrize("value", [-1000.0, 0.0, 1e-3, 1500.0])
def test_edges_surround_a_lone_value(value):
    low, high = scales.arithmetic_edges(np.array([value]))
    assert low < value < high
    assert low + high == pytest.approx(2 * value)


def test_geometric_edges_surround_a_lone_value():
    low, high = scales.geometric_edges(np.array([1500.0]))
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
    assert (np.diff(grey[:-1]) < -0.1).all() and maps.COLOURS["absent"] == "#ffffff"


def test_legend_names_the_classes_present():
    assert legend_words(map_of(TINY)) == [
        "no snap, end open (7)",
        "never snaps (1)",
        "snaps, end open (7)",
        "failed (1)",
    ]


@pytest.mark.parametrize("name", OUTCOMES)
def test_every_class_has_a_key(name):
    cells = make_cells([str(OUTCOMES.index(name))])
    (key,) = map_of(cells).get_legend().get_patches()
    assert key.get_label() == f"{maps.WORDS[name]} (1)"
    assert key.get_facecolor() == to_rgba(maps.COLOURS[name])
    assert (key.get_hatch() is not None) == (name in ("unsnapped", "snapped", "absent"))


def rectangles(patch):
    """Lower left and upper right corners of the rectangles of a region."""
    corners = patch.get_path().vertices.reshape(-1, 5, 2)
    return [(*rectangle[0], *rectangle[2]) for rectangle in corners.tolist()]


def test_open_cells_are_hatched_as_one_region():
    (region,) = artists(map_of(make_cells(["345", "201"])), PathPatch)
    assert region.get_hatch() == maps.OPEN["hatch"]
    assert rectangles(region) == [(50.0, 950.0, 200.0, 1050.0), (200.0, 950.0, 800.0, 1050.0)]


def test_unreproduced_cells_are_hatched_otherwise():
    cells = make_cells(["43", "11"])
    cells["reproduced"] = xr.ones_like(cells.outcome)
    cells.reproduced[{"f0": 0}] = 0
    ax = map_of(cells)
    light, dark = artists(ax, PathPatch)
    assert light.get_hatch() == dark.get_hatch() == maps.UNREPRODUCED["hatch"] != maps.OPEN["hatch"]
    assert rectangles(light) == [(50.0, 950.0, 200.0, 1050.0)]
    assert rectangles(dark) == [(50.0, 1050.0, 200.0, 1150.0)]
    assert light.get_hatchcolor() != dark.get_hatchcolor() == to_rgba("0.8")
    assert legend_words(ax)[-1] == "not reproduced (2)"


def test_map_without_thresholds_has_no_line():
    assert [visible(line) for line in map_of(make_cells(["22", "00"])).lines] == [[], []]


def test_map_shows_the_refined_threshold_dashed_where_late():
    ax = map_of(make_cells(["22", "00"]), make_found().isel(C=0))
    dashed, solid = ax.lines[3:5]
    assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
    assert visible(solid) == [[100.0, 1000.0], [1000.0, 1100.0]]
    assert visible(dashed) == [[1000.0, 1100.0], [10000.0, 2000.0]]
    assert legend_words(ax)[-3:] == [
        "lowest $N$ that snaps",
        "the same, after the pulse",
        "static, impulsive limits",
    ]


def test_map_keeps_its_limits_and_shows_both_asymptotes():
    cells = make_cells(["22", "00"])
    ax = map_of(cells, make_found().isel(C=0))
    assert (ax.get_xlim(), ax.get_ylim()) == (map_of(cells).get_xlim(), map_of(cells).get_ylim())
    static, short = ax.lines[-2:]
    assert static.get_ydata() == [990.0, 990.0]
    f0, N = short.get_xydata().T
    assert N * 1e-5 / (2e-6 * f0) == pytest.approx(np.full(f0.size, 0.5))


def test_all_maps_share_one_legend():
    panels = [(TINY.assign_coords(C=C), make_found().sel(C=C)) for C in (25.0, 200.0)]
    figure = style.double_column(height=3.4)
    axes = maps.draw_maps(figure, panels, "f0", "N")
    titles = [ax.get_title(loc="left") for ax in axes.flat]
    assert titles == [scales.value_text("C", 25.0), scales.value_text("C", 200.0)]
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words[:2] == ["no snap, end open (14)", "never snaps (2)"]
    assert all(ax.get_legend() is None for ax in axes.flat)
    figure.draw_without_rendering()


@pytest.mark.parametrize(("number", "shape"), [(1, (1, 1)), (3, (1, 3)), (4, (2, 3))])
def test_maps_stand_in_rows_of_three(number, shape):
    panels = [(TINY.assign_coords(C=float(C)), None) for C in range(number)]
    assert maps.draw_maps(style.double_column(height=5.0), panels, "f0", "N").shape == shape


def test_shocks_are_pointed_out_by_numbers():
    ax = style.single_column(height=3.6).subplots()
    maps.draw_map(ax, TINY, marks=[("far", 1e3, 1e6), ("drop", 400.0, 1000.0)])
    assert [text.get_text() for text in ax.texts] == ["2"]
    assert ax.get_title(loc="left").splitlines()[-2:] == ["1: far", "2: drop"]


def test_figures_over_durations_are_those_over_frequencies():
    found = scales.along(make_found(), "duration", "C")
    np.testing.assert_allclose(found.duration, [0.1, 1.0, 10.0])
    assert found.N_first.sel(C=25.0).values.tolist() == [2000.0, 1100.0, 1000.0]
    ax = thresholds.draw_thresholds(
        style.double_column(height=3.4).subplots(), found, "duration", "C"
    )
    assert ax.get_xscale() == "log" and ax.get_xlabel() == "pulse duration $1/f_0$ (ms)"
    assert scales.along(found, "f0") is found


def test_margins_of_requirements_are_the_data_with_their_bars():
    verdicts = [
        {"requirement": "drop", "device": "", "C": "25.0", "must_snap": "True"}
        | {"margin": "0.8", "margin_error": "0.01", "verdict": "met"},
        {"requirement": "back", "device": "a", "C": "25.0", "must_snap": "False"}
        | {"margin": "nan", "margin_error": "nan", "verdict": "met"},
        {"requirement": "shelf", "device": "", "C": "0.5", "must_snap": "False"}
        | {"margin": "0.9", "margin_error": "0.02", "verdict": "failed"},
    ]
    ax = requirements.draw_margins(style.double_column(height=2.0).subplots(), verdicts)
    points = {line.get_xydata()[0].tolist()[0] for line in ax.lines if line.get_marker() != "None"}
    assert {0.8, 0.9} <= points
    assert [text.get_text().strip() for text in ax.texts] == ["snaps at no $N$ seen"]
    assert [label.get_text().splitlines()[0] for label in ax.get_yticklabels()] == [
        "drop, trips",
        "back, does not trip",
        "shelf, does not trip",
    ]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["met", "failed"]


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
    }
    axes = {"C": [25.0], "f0": f0, "N": N, "quantile": list(tolerances.LINES)}
    axes |= {"order": ["first", "total"], "value": ["thickness+depth", "N"]}
    return xr.Dataset(variables, axes | {"requirement": ["drop"]}, ATTRIBUTES)


def test_devices_as_made_are_drawn_as_they_are():
    found = make_batch().isel(C=0)
    ax = tolerances.draw_probability(style.single_column(height=3.0).subplots(), found)
    (field,) = ax.collections
    np.testing.assert_allclose(field.get_array(), found.probability.transpose("N", "f0"))
    assert len(ax.lines) == len(tolerances.LINES) + 1
    np.testing.assert_allclose(ax.lines[-1].get_ydata(), found.N_nominal)
    ax = tolerances.draw_sensitivity(style.single_column(height=3.0).subplots(), found)
    drawn = [line.get_ydata()[0] for line in ax.lines if len(line.get_ydata()) == F0.size]
    assert sorted(drawn) == [0.1, 0.1, 0.9, 0.9]
    words = [key.get_label() for key in tolerances.sensitivity_keys(found)]
    assert words == ["thickness and depth", "$N$ of the shock", "alone (first order)"]
    assert "1 of them without a second" in tolerances.batch_text(found, ATTRIBUTES)


def test_devices_under_one_frequency_are_a_curve():
    found = make_batch(np.array([1500.0])).isel(C=0)
    ax = tolerances.draw_probability(style.single_column(height=3.0).subplots(), found)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), found.probability.squeeze())
    tolerances.draw_sensitivity(style.single_column(height=3.0).subplots(), found)


def test_a_requirement_is_drawn_with_the_share_that_meets_it():
    found = make_batch().isel(C=0, requirement=0)
    ax = tolerances.draw_requirement(style.single_column(height=3.0).subplots(), found)
    assert ax.get_title(loc="left").splitlines()[0] == "drop, trips"
    assert "met by 50.0 % (15.0 to 85.0 %)" in ax.get_title(loc="left")
    assert sum(patch.get_height() for patch in ax.patches[1:]) == 3
    assert ax.patches[0].get_x() == 1050.0


def test_a_design_is_drawn_over_both_values():
    along = {"rise": [9.0, 10.0]}
    comment = {"comment": "where the threshold is 1500 g"}
    values = {"thickness": ("rise", [2.5, 2.4], comment), "error": ("rise", [0.01, 0.02])}
    ax = thresholds.draw_design(
        style.single_column(height=3.0).subplots(), xr.Dataset(values, along)
    )
    np.testing.assert_allclose(ax.lines[0].get_xydata(), [[9.0, 2.5], [10.0, 2.4]])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("rise (µm)", "thickness (µm)")


def test_failed_cells_are_crossed_out():
    crosses = [line.get_xydata().tolist() for line in map_of(TINY).lines]
    assert crosses == [[[6400.0, 1300.0]]] * 2


def test_map_states_its_case():
    assert map_of(TINY).get_title(loc="left") == (
        "$C$ = 25 µN µs µm$^{-1}$\nhandout model, followed 1.5 ms beyond the pulse"
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
    assert legend_words(ax)[:2] == ["no snap, end open (25000)", "snaps, end open (25000)"]


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
    assert title == "$N$ = 1000, $f_0$ = 1500 Hz, $C$ = 0.025 µN µs µm$^{-1}$, handout model"


def test_thresholds_are_the_data_dashed_and_hollow_where_late():
    ax = drawn(thresholds.draw_thresholds, make_found())
    for i, N in enumerate([1000.0, 1001.0]):
        dashed, solid = ax.lines[3 * i + 1 : 3 * i + 3]
        assert (dashed.get_linestyle(), solid.get_linestyle()) == ("--", "-")
        assert dashed.get_markerfacecolor() == "white" != solid.get_markerfacecolor()
        assert dashed.get_markevery().tolist() == [False, False, True]
        assert visible(dashed) == [[1000.0, N + 100], [10000.0, N + 1000]]
        assert visible(solid) == [[100.0, N], [1000.0, N + 100]]


def test_every_C_has_a_look_of_its_own():
    ax = drawn(thresholds.draw_thresholds, make_found(C=range(6)))
    keys = ax.get_legend().get_lines()[:6]
    assert len({key.get_color() for key in keys}) == len({key.get_marker() for key in keys}) == 6


def test_of_many_C_the_first_the_last_and_some_between_are_drawn():
    ax = drawn(thresholds.draw_thresholds, make_found(C=range(21)))
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    shown = [float(label.split(",")[0].split("=")[1]) for label in labels if "$C$" in label]
    assert shown == [0, 4, 8, 12, 16, 20]


def test_first_colours_differ_in_grey():
    grey = [np.dot(to_rgb(colour), [0.299, 0.587, 0.114]) for colour, _ in curves.LOOKS[:3]]
    assert (np.diff(grey) > 0.1).all()


def test_thresholds_have_error_bars():
    bars = artists(drawn(thresholds.draw_thresholds, make_found()), LineCollection)[1]
    assert bars.get_segments()[0].tolist() == [[100.0, 993.0], [100.0, 1007.0]]


def test_gaps_are_shaded_and_islands_stroked():
    ax = drawn(thresholds.draw_thresholds, make_found(C=[25.0]))
    (gap,) = artists(ax, FillBetweenPolyCollection)
    assert gap.get_paths()[0].vertices.max(axis=0).tolist() == [10000.0, 2300.0]
    islands, _ = artists(ax, LineCollection)
    ends = [line[:, 1].tolist() for line in islands.get_segments() if len(line)]
    assert ends == [[2000.0, 2050.0], [2100.0, 2150.0]]
    assert legend_words(ax)[-1] == "island of $N$ that snap"


def test_without_islands_there_is_no_gap():
    found = make_found()
    found["islands"] = 0 * found.islands
    ax = drawn(thresholds.draw_thresholds, found)
    assert artists(ax, FillBetweenPolyCollection) == []
    assert legend_words(ax)[-1] == "the same, after the pulse"


def test_thresholds_approach_both_limits():
    ax = drawn(thresholds.draw_thresholds, make_found())
    static, *short = ax.lines[-3:]
    assert static.get_ydata() == [990.0, 990.0]
    for line, v in zip(short, [0.5, 0.6], strict=True):
        f0, N = line.get_xydata().T
        assert N * 1e-5 / (2e-6 * f0) == pytest.approx(np.full(f0.size, v))
    assert legend_words(ax)[0] == r"$C$ = 25, $\Delta v$ = 0.5 m/s"


def test_damage_boundary_is_over_the_velocity_change():
    ax = drawn(thresholds.draw_damage_boundary, make_found())
    # N g / (2 f0), with g = 10 m/s^2
    assert visible(ax.lines[2]) == [pytest.approx([50.0, 1000.0]), pytest.approx([5.5, 1100.0])]
    assert visible(ax.lines[1]) == [pytest.approx([5.5, 1100.0]), pytest.approx([1.0, 2000.0])]
    assert ax.get_xscale() == ax.get_yscale() == "log"


def test_damage_boundary_shades_what_snaps_of_the_first_C():
    ax = drawn(thresholds.draw_damage_boundary, make_found())
    (region,) = artists(ax, Polygon)
    snaps = region.get_path().contains_points
    assert snaps([(1.1, 2000.0), (6.0, 1100.0), (50.0, 1010.0), (0.6, 1e5), (1e3, 1000.0)]).all()
    assert not snaps([(0.9, 1900.0), (5.4, 1000.0), (50.0, 980.0), (0.4, 1e5)]).any()
    assert legend_words(ax)[-1] == "snaps, $C$ = 25"


def test_damage_boundary_has_both_limits_and_guides_of_constant_duration():
    ax = drawn(thresholds.draw_damage_boundary, make_found())
    static, first, second, *guides = ax.lines[6:]
    assert static.get_ydata() == [990.0, 990.0]
    assert [first.get_xdata(), second.get_xdata()] == [[0.5, 0.5], [0.6, 0.6]]
    v, N = guides[1].get_xydata().T
    assert len(guides) == 3 and N * 1e-5 / v == pytest.approx(np.full(2, 2e-3))
    assert "1 ms" in [text.get_text() for text in ax.texts]


@pytest.mark.parametrize("draw", [thresholds.draw_thresholds, thresholds.draw_damage_boundary])
@pytest.mark.parametrize("f0", [[0], [2], [0, 2]])
def test_thresholds_not_found_leave_a_hole(draw, f0):
    found = make_found()
    for name in ("N_first", "N_error", "N_always"):
        found[name] = found[name].where(found.f0 < 1000)
    ax = drawn(draw, found.isel(f0=f0))
    ax.figure.draw_without_rendering()
    assert sum(len(visible(line)) for line in ax.lines[1:3]) == int(0 in f0)


def test_force_and_energy_are_the_data():
    found = make_statics()
    force, energy = (drawn(draw, found) for draw in DRAW_STATICS)
    for ax, values in ((force, found.force), (energy, found.energy)):
        unbranched, followed = ax.lines[:2]
        assert followed.get_xydata().T.tolist() == [
            *found.displacement[:1].values.tolist(),
            values[0].values.tolist(),
        ]
        assert unbranched.get_ydata().tolist() == values[1].values.tolist()
        assert (followed.get_linestyle(), unbranched.get_linestyle()) == ("-", "--")
        assert "µm" in ax.get_xlabel()


DRAW_STATICS = (statics.draw_force_displacement, statics.draw_energy)


def test_statics_mark_wells_saddle_and_peaks():
    force, energy = (drawn(draw, make_statics()) for draw in DRAW_STATICS)
    assert line(force, "stable").get_xydata().tolist() == [[0.0, 0.0], [19.0, 0.0]]
    assert line(force, "saddle").get_xydata().tolist() == [[12.0, 0.0]]
    assert line(energy, "stable").get_ydata().tolist() == [0.0, 385.0]
    assert line(energy, "saddle").get_ydata().tolist() == [490.0]
    words = [text.get_text() for text in (*force.texts, *energy.texts)]
    assert [word.split("= ")[-1] for word in words] == ["70 µN", "−30 µN", "barrier 490 pJ"]


def test_convergence_draws_the_errors_over_number_and_step():
    number, step = drawn(convergence.draw_convergence, make_accuracy(), 1, 2)
    assert line(number, "$n$ elements, consistent").get_xydata().tolist() == [
        [3, 1.6e-2],
        [6, 1e-3],
    ]
    assert line(number, "$n$ cosines, not").get_xydata().tolist() == [[3, 8e-3], [6, 1e-3]]
    assert line(step, "time step").get_xydata().tolist() == [[0.4, 1e-5], [0.8, 4e-5]]
    number.figure.draw_without_rendering()


def test_slopes_have_the_expected_orders():
    axes = drawn(convergence.draw_convergence, make_accuracy(), 1, 2)
    slopes = [line for ax in axes for line in ax.lines if line.get_linestyle() == ":"]
    ratios = [line.get_ydata()[1] / line.get_ydata()[0] for line in slopes]
    assert ratios == pytest.approx([2.0**-4, 2.0**-3, 2.0**2])


def test_what_the_converged_run_does_not_know_is_shaded():
    number, _ = drawn(convergence.draw_convergence, make_accuracy(), 1, 2)
    (shade,) = number.patches
    assert shade.get_y() + shade.get_height() == pytest.approx(2e-5)


STEMS = ("map", "maps", "thresholds", "damage_boundary", "history", "statics", "convergence")


def save_all(folder):
    """Save figures through the rules' own functions; the files' bytes."""
    made = {
        "cube": TINY.expand_dims("C"),
        "threshold": make_found(),
        "history": make_history([10, 0, -8, -12]),
        "statics": make_statics(),
        "accuracy": make_accuracy(),
    }
    files = {name: folder / f"{name}.nc" for name in made}
    for name, dataset in made.items():
        write(dataset, files[name])
    plane = {"name": "map", "x": "f0", "y": "N", "at": {"C": 0}}
    curve = {"name": "thresholds", "x": "f0", "y": "C", "at": {}}
    boundary = curve | {"name": "damage_boundary"}
    draw_maps.draw_maps(files["cube"], files["threshold"], [plane], [plane], [], folder)
    draw_thresholds.draw_thresholds(files["threshold"], [curve], boundary, folder)
    draw_history.draw_history(files["history"], folder / "history")
    draw_statics.draw_statics(files["statics"], folder / "statics")
    draw_convergence.draw_convergence(files["accuracy"], folder / "convergence")
    paths = {folder / f"{name}.{kind}" for name in STEMS for kind in ("pdf", "png")}
    assert set(folder.iterdir()) == {*files.values(), *paths}
    return {path.name: path.read_bytes() for path in paths}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    return save_all(tmp_path_factory.mktemp("figures"))


def test_saved_files_repeat_byte_for_byte(saved, tmp_path):
    assert save_all(tmp_path) == saved


@pytest.mark.parametrize("stem", STEMS)
def test_pdf_embeds_truetype_fonts(saved, stem):
    assert b"/FontFile2" in saved[f"{stem}.pdf"]
    assert b"/Type3" not in saved[f"{stem}.pdf"]


@pytest.mark.parametrize("stem", STEMS)
def test_pdf_carries_provenance_and_no_date(saved, stem):
    pdf = saved[f"{stem}.pdf"]
    assert b"/Title (A title)" in pdf
    assert b"/Creator (0.1.0+abc)" in pdf
    assert b"1.5 ms" in pdf
    assert b"Date" not in pdf


@pytest.mark.parametrize("stem", STEMS)
def test_png_carries_provenance_at_300_dpi(saved, stem):
    with Image.open(io.BytesIO(saved[f"{stem}.png"])) as image:
        single = stem in ("map", "damage_boundary", "statics")
        assert image.size[0] == (1020 if single else 2100)
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
    scripts = root / "workflow" / "scripts"
    names = ", ".join(path.stem for path in scripts.glob("draw_*.py"))
    code = f"import sys, {names}; print('matplotlib.pyplot' in sys.modules)"
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, cwd=scripts, capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


def test_every_figure_is_in_the_report_with_a_caption(root, workflow_text):
    """And every caption belongs to a figure, but for the words at the report's head."""
    outputs = re.findall(r"png=[\[\s]*(report\()?\s*f?\"results/figures/", workflow_text)
    captions = re.findall(r'caption="\.\./report/(\w+\.rst)"', workflow_text)
    assert all(outputs) and len(outputs) == len(captions) == len(set(captions))
    written = list((root / "workflow" / "report").iterdir())
    assert {path.name for path in written} == {*captions, "study.rst"}
    assert all(path.read_text().strip() for path in written)


def test_examples_of_the_page_on_figures_run(root, tmp_path):
    """On a tiny cube, as they stand; the last has ten lines."""
    page = (root / "docs" / "figures.md").read_text()
    examples = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len([line for line in examples[-1].splitlines() if line.strip()]) == 10
    (tmp_path / "results").mkdir()
    write(TINY.expand_dims("C"), tmp_path / "results" / "cube.nc")
    write(make_found(C=[25.0]), tmp_path / "results" / "threshold.nc")
    path = {"PYTHONPATH": str(root / "workflow" / "scripts"), "MPLBACKEND": "agg"}
    for code in examples:
        subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, env=os.environ | path, check=True
        )
    assert {figure.name for figure in tmp_path.glob("*.pdf")} == {"both.pdf", "share.pdf"}

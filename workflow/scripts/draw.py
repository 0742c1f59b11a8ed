"""What the rules of figures run, each a function named like its rule: reads, draws, saves."""

import gc
from contextlib import contextmanager, nullcontext
from pathlib import Path

import xarray as xr

from snapmap.applications.calibration import figure as calibration
from snapmap.applications.histories import figure as histories
from snapmap.applications.requirements import figure as requirements
from snapmap.applications.requirements.corners import corners
from snapmap.applications.statics import figure as statics
from snapmap.applications.tolerances import figure as tolerances
from snapmap.figures import (
    maps,
    scales,
    style,
    thresholds,
)
from snapmap.files.atomic import replacing
from snapmap.files.tables import read_points, read_verdicts
from snapmap.numerics.portable import evenly
from snapmap.study.netcdf import check_alike, open_whole
from snapmap.workflow.job_log import run_rule

COLUMNS, MOST, LINES = 3, 12, 6
"""Panels of devices as made side by side, and in a figure, and lines; of more, evenly chosen."""
ROW, FLAT = 2.6, 1.7
"""Height of a row of these panels, in; and of histograms."""


@contextmanager
def _figure(stem, found, height, columns=2):
    """An empty figure as wide as so many columns, for a dataset; saved when it has been drawn."""
    with style.paper():
        figure = style.double_column(height) if columns == 2 else style.single_column(height)
        yield figure
        style.save(figure, stem, found.attrs)


def draw_snaps(cube_path, threshold_path, views, own_points, folder, traces_path=""):
    """Draw which cells snap, and maps of thresholds; views and own_points as `draw_study` has them.

    traces_path: with the stress of each cell, of devices that have a strength
    """
    own_points = read_points(*own_points) if own_points else ()
    with (
        open_whole(cube_path) as cube,
        open_whole(threshold_path) as found,
        open_whole(traces_path) if traces_path else nullcontext() as traces,
    ):
        check_alike(cube, found, threshold_path)
        stressed = cube
        if traces_path:
            check_alike(cube, traces, traces_path)
            share = traces.stress_max / traces.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            stressed = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        for view in views["snaps"]:
            shown = {"required_shocks": view["required_shocks"], "own_points": own_points}
            data = _along(stressed, view), _along(found, view)
            _draw_map(maps.draw_map, view, folder, *data, **shown)
        if together := views["together"]:
            panels = [(_along(stressed, view), _along(found, view)) for view in together]
            _draw_together(panels, f"{folder}/snap_maps", together[0], own_points)
        for view in views["fields"]:
            _draw_map(thresholds.draw_threshold_map, view, folder, _along(found, view))


def draw_study(
    cube_path, threshold_path, statics_paths, views, own_points, folder, history_paths=()
):
    """Draw what else every study has: in one job, as its start takes longer than a figure.

    views: lists of what is drawn: snaps, times, ends (maps of the cube), together (of them side by
        side), fields (maps of thresholds), curves, boundary; of each its name, x, y, at, the place
        on each other axis, and of maps of cells required_shocks
    own_points: path and SHA-256 of a user's own points, or nothing
    """
    own_points = read_points(*own_points) if own_points else ()
    with open_whole(cube_path) as cube, open_whole(threshold_path) as found:
        check_alike(cube, found, threshold_path)
        _draw_times_and_ends(cube, views, own_points, folder)
        for view in views["curves"]:
            with _figure(f"{folder}/{view['name']}", found, 3.4) as figure:
                axes = view["x"], view["y"]
                thresholds.draw_thresholds(figure.subplots(), _along(found, view), *axes)
        for view in views["boundary"]:
            with _figure(f"{folder}/{view['name']}", found, 3.6, columns=1) as figure:
                lines = found.isel(view["at"])
                thresholds.draw_damage_boundary(figure.subplots(), lines, view["y"])
    for path in statics_paths:
        stem = f"{folder}/{Path(path).stem}"
        with open_whole(path) as found, _figure(stem, found, 3.6, columns=1) as figure:
            statics.draw_statics(figure, found)
    for path in history_paths:
        stem = f"{folder}/history_{Path(path).stem}"
        with open_whole(path) as history, _figure(stem, history, 4.2) as figure:
            axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
            histories.draw_history(axes, history)


def _draw_times_and_ends(cube, views, own_points, folder):
    # Of what is drawn: a cube may be larger than memory.
    colours = maps.snap_times(_along(cube, view) for view in views["times"])
    for view in views["times"]:
        _draw_map(maps.draw_time_map, view, folder, _along(cube, view), ends=colours)
    for view in views["ends"]:
        shown = {"required_shocks": view["required_shocks"], "own_points": own_points}
        _draw_map(maps.draw_map, view, folder, _along(cube, view), None, ends=True, **shown)
    if views["ends"]:
        panels = [(_along(cube, view), None) for view in views["together"]]
        _draw_together(panels, f"{folder}/maps", views["together"][0], own_points, ends=True)


def _along(found, view):
    at = {key: place for key, place in view["at"].items() if key in found.dims}
    return scales.along(found.isel(at), view["x"], view["y"])


def _draw_map(draw, view, folder, *data, **shown):
    with _figure(f"{folder}/{view['name']}", data[0], height=3.6, columns=1) as figure:
        draw(figure.subplots(), *data, view["x"], view["y"], **shown)
        style.fit(figure, maps.RATIO)


def _draw_together(panels, stem, view, own_points, **shown):
    with _figure(stem, panels[0][0], height=9) as figure:
        maps.draw_maps(figure, panels, view["x"], view["y"], own_points, **shown)


def draw_requirements(requirements_path, stem):
    """Draw the margin of each required shock, a row for each device and C."""
    verdicts = read_verdicts(requirements_path)
    about = xr.Dataset(attrs={"title": "Margins of required shocks"})
    with _figure(stem, about, 1.2 + 0.32 * len(corners(verdicts))) as figure:
        requirements.draw_margins(figure.subplots(), verdicts)


def draw_window(window_path, axes, stem):
    """Draw where over two axes, named with their units, all required shocks are met."""
    with open_whole(window_path) as found, _figure(stem, found, 4) as figure:
        requirements.draw_window(figure, found, *axes, axes)


def draw_calibration(calibration_path, stem):
    """Draw measured shots over the fitted threshold and its band, by shape and direction."""
    with open_whole(calibration_path) as found, _figure(stem, found, 3.4) as figure:
        panels = calibration.panels(found)
        axes = figure.subplots(1, len(panels), squeeze=False)[0]
        for ax, panel in zip(axes, panels, strict=True):
            calibration.draw_shots(ax, panel)
        style.legend(figure, style.labelled(axes), calibration.calibration_text(found), 5)


def draw_tolerance(tolerance_path, places, yields, folder):
    """Draw how probably devices snap, and what that depends on, a panel for each C; and the yield.

    places, yields: on the axes of names, by the ending of the figures' names
    """
    with open_whole(tolerance_path) as found:
        for ending, at in places.items():
            here = found.isel(at)
            panels = [here.isel(C=i) for i in evenly(here.C.size, MOST)]
            for name in ("probability", "sensitivity"):
                draw = getattr(tolerances, f"draw_{name}")
                _draw_panels(f"{folder}/{name}{ending}", panels, draw, found.attrs)
        for ending, at in yields.items():
            here = found.isel(at)
            here = here.isel(C=evenly(here.C.size, LINES))
            panels = [
                here.isel(requirement=i, C=j)
                for i in evenly(here.requirement.size, MOST)
                for j in evenly(here.C.size, MOST // min(MOST, here.requirement.size))
            ]
            stem, draw = f"{folder}/yield{ending}", requirements.draw_requirement
            _draw_panels(stem, panels, draw, found.attrs, here)


def _draw_panels(stem, panels, draw, attributes, shares=None):
    """Panels under one legend; above them the shares that meet requirements, if these are given."""
    dampings = len({panel.C.item() for panel in panels})
    columns = dampings if dampings in (2, COLUMNS) else min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    heights = [(ROW if shares is None else FLAT) * rows]
    if shares is not None:
        rows_above = len(list(requirements.each_share(shares))) * shares.C.size
        heights.insert(0, 0.5 + 0.17 * rows_above)
    with _figure(stem, panels[0], 0.9 + sum(heights)) as figure:
        *above, lower = figure.subfigures(len(heights), height_ratios=heights, squeeze=False).flat
        axes = lower.subplots(rows, columns, squeeze=False).flat
        for ax, panel in zip(axes, panels, strict=False):
            draw(ax, panel)
        for ax in axes[len(panels) :]:
            ax.remove()
        if above:
            requirements.draw_yield(above[0].subplots(), shares)
        words = tolerances.batch_text(panels[0], attributes)
        style.legend(figure, style.labelled(figure.axes), words)


def draw_page(cube_path, threshold_path, horizon, path, traces_path=""):
    """Write the page to explore a cube; horizon: us."""
    from snapmap.applications.page.figure import page  # brings Plotly

    with (
        open_whole(cube_path) as cube,
        open_whole(threshold_path) as found,
        open_whole(traces_path) if traces_path else nullcontext() as traces,
        replacing(path) as temporary,
    ):
        check_alike(cube, found, threshold_path)
        if traces_path:
            check_alike(cube, traces, traces_path)
        Path(temporary).write_text(page(cube, traces, found, horizon), encoding="utf-8")


if __name__ == "__main__":
    gc.freeze()  # what was imported stays
    gc.set_threshold(200_000)  # a figure and its fonts are many objects, and hardly any is garbage
    run_rule(globals()[snakemake.rule], snakemake)

"""What the rules of figures run, each a function named like its rule: reads, draws, saves."""

import gc
from contextlib import nullcontext

from snapmap.applications import attached
from snapmap.figures import maps, scales, style
from snapmap.figures.thresholds import draw_threshold_map, draw_thresholds
from snapmap.files.tables import read_points
from snapmap.study.netcdf import check_alike, open_whole
from snapmap.workflow.job_log import run_rule


def draw_snaps(cube_path, threshold_path, views, own_points, folder, stress_path=""):
    """Draw which cells snap, and maps of thresholds; views and own_points as `draw_study` has them.

    stress_path: of each cell, of devices that have a strength
    """
    own_points = read_points(*own_points) if own_points else ()
    with (
        open_whole(cube_path) as cube,
        open_whole(threshold_path) as thresholds,
        open_whole(stress_path) if stress_path else nullcontext() as stress,
    ):
        check_alike(cube, thresholds, threshold_path)
        stressed = cube
        if stress_path:
            check_alike(cube, stress, stress_path)
            share = stress.stress_max / stress.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            stressed = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        for view in views["snaps"]:
            shown = {"required_shocks": view["required_shocks"], "own_points": own_points}
            data = _along(stressed, view), _along(thresholds, view)
            _draw_map(maps.draw_map, view, folder, *data, **shown)
        if together := views["together"]:
            panels = [(_along(stressed, view), _along(thresholds, view)) for view in together]
            _draw_together(panels, f"{folder}/snap_maps", together[0], own_points)
        for view in views["fields"]:
            _draw_map(draw_threshold_map, view, folder, _along(thresholds, view))


def draw_study(cube_path, threshold_path, views, own_points, quick, folder):
    """Draw what else every study has: in one job, as its start takes longer than a figure.

    views: lists of what is drawn: snaps, times, ends (maps of the cube), together (of them side by
        side), fields (maps of thresholds), curves; of each its name, x, y, at, the place on each
        other axis, and of maps of cells required_shocks
    own_points: path and SHA-256 of a user's own points, or nothing
    quick: of applications by the names of their folders: their figures, and the files of these
    """
    own_points = read_points(*own_points) if own_points else ()
    with open_whole(cube_path) as cube, open_whole(threshold_path) as thresholds:
        check_alike(cube, thresholds, threshold_path)
        _draw_times_and_ends(cube, views, own_points, folder)
        for view in views["curves"]:
            with style.saved(f"{folder}/{view['name']}", thresholds.attrs, 3.4) as figure:
                axes = view["x"], view["y"]
                draw_thresholds(figure.subplots(), _along(thresholds, view), *axes)
    for name, (figures, paths) in quick.items():
        attached()[name].draw(figures=figures, folder=folder, **paths)


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


def _along(dataset, view):
    at = {key: place for key, place in view["at"].items() if key in dataset.dims}
    return scales.along(dataset.isel(at), view["x"], view["y"])


def _draw_map(draw, view, folder, *data, **shown):
    with style.saved(f"{folder}/{view['name']}", data[0].attrs, 3.6, columns=1) as figure:
        draw(figure.subplots(), *data, view["x"], view["y"], **shown)
        style.fit(figure, maps.RATIO)


def _draw_together(panels, stem, view, own_points, **shown):
    with style.saved(stem, panels[0][0].attrs, 9) as figure:
        maps.draw_maps(figure, panels, view["x"], view["y"], own_points, **shown)


def function_of(rule):
    """The function of a rule: here, or how an application draws."""
    name = rule.removeprefix("draw_")
    return globals()[rule] if rule in globals() else attached()[name].draw


if __name__ == "__main__":
    gc.freeze()  # what was imported stays
    gc.set_threshold(200_000)  # a figure and its fonts are many objects, and hardly any is garbage
    run_rule(function_of(snakemake.rule), snakemake)

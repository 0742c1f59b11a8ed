"""What the rules of figures run, each a function named like its rule: reads, draws, saves."""

import gc
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import partial
from itertools import compress
from multiprocessing import get_context

import xarray as xr

from snapmap.applications import attached
from snapmap.figures import maps, scales, style
from snapmap.figures.thresholds import draw_threshold_map, draw_thresholds
from snapmap.files.tables import read_points
from snapmap.study.netcdf import check_alike, open_whole
from snapmap.workflow.job_log import end_with, run_rule


def draw_study(
    cube_path, threshold_path, views, own_points, applications, folder, threads, traces_path=""
):
    """Draw what every study has: in one job, as its start takes longer than a figure.

    views: lists of what is drawn: snaps, times, ends (maps of the cube), together (of them side by
        side), fields (maps of thresholds), curves; of each its name, x, y, at, the place on each
        other axis, and of maps of cells required_shocks
    own_points: path and SHA-256 of a user's own points, or nothing
    applications: by the names of their folders: their figures, and the files of these
    traces_path: with the stress of each cell, of devices that have a strength
    """
    files = cube_path, threshold_path, traces_path
    points = read_points(*own_points) if own_points else ()
    with _opened(files, open_whole) as (cube, thresholds):
        check_alike(cube, thresholds, threshold_path)
        # Of what is drawn: a cube may be larger than memory.
        times = maps.snap_times(_along(cube, view) for view in views["times"])
    cells, fields, both = (True, False), (False, True), (True, True)
    curves, panels = views["curves"], views["together"]
    tasks = [
        *(partial(_draw_panels, files, folder, panels, points, True) for _ in views["ends"][:1]),
        *(partial(_draw_panels, files, folder, panels, points, False) for _ in panels[:1]),
        *(partial(_draw_curve, files, folder, view) for view in curves),
    ]
    maps_of = [
        *((view, cells, maps.draw_time_map, {"ends": times}) for view in views["times"]),
        *((view, both, maps.draw_map, _shown(view, points)) for view in views["snaps"]),
        *((view, cells, _draw_ends, _shown(view, points)) for view in views["ends"]),
        *((view, fields, draw_threshold_map, {}) for view in views["fields"]),
    ]
    tasks += [partial(_draw_map, files, folder, *each) for each in maps_of]
    for name, (figures, paths) in applications.items():
        tasks.append(partial(attached()[name].draw, figures=figures, **paths))
    side_by_side(tasks, threads)


def side_by_side(tasks, processes):
    """Do tasks in processes that are forked here: they share what is imported, and no open file."""
    if processes == 1 or sys.platform != "linux":  # elsewhere libraries do not outlive a fork
        for task in tasks:
            task()
        return
    fork = get_context("fork")
    with ProcessPoolExecutor(processes, fork, end_with, [os.getpid()]) as pool:
        for done in [pool.submit(task) for task in tasks]:
            done.result()


@contextmanager
def _opened(files, open_file=xr.open_dataset):
    """Open cube and thresholds; the cube has the share of the strength, if there are traces."""
    cube_path, threshold_path, traces_path = files
    with (
        open_file(cube_path) as cube,
        open_file(threshold_path) as thresholds,
        open_file(traces_path) if traces_path else nullcontext() as traces,
    ):
        if traces_path:
            check_alike(cube, traces, traces_path)
            share = traces.stress_max / traces.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            cube = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        yield cube, thresholds


def _along(dataset, view):
    at = {key: place for key, place in view["at"].items() if key in dataset.dims}
    return scales.along(dataset.isel(at), view["x"], view["y"])


def _shown(view, points):
    return {"required_shocks": view["required_shocks"], "own_points": points}


def _draw_ends(ax, cells, x, y, **shown):
    maps.draw_map(ax, cells, None, x, y, ends=True, **shown)


def _draw_map(files, folder, view, which, draw, shown):
    """Draw one map; which: whether of the cells, and of the thresholds."""
    with _opened(files) as opened:
        data = [_along(dataset, view) for dataset in compress(opened, which)]
        with style.saved(f"{folder}/{view['name']}", data[0].attrs, 3.6, columns=1) as figure:
            draw(figure.subplots(), *data, view["x"], view["y"], **shown)
            style.fit(figure, maps.RATIO)


def _draw_panels(files, folder, views, points, ends):
    name, (x, y) = "maps" if ends else "snap_maps", (views[0]["x"], views[0]["y"])
    with _opened(files) as (cube, thresholds):
        panels = [
            (_along(cube, view), None if ends else _along(thresholds, view)) for view in views
        ]
        with style.saved(f"{folder}/{name}", panels[0][0].attrs, 9) as figure:
            maps.draw_maps(figure, panels, x, y, points, ends=ends)


def _draw_curve(files, folder, view):
    with (
        _opened(files) as (_, thresholds),
        style.saved(f"{folder}/{view['name']}", thresholds.attrs, 3.4) as figure,
    ):
        draw_thresholds(figure.subplots(), _along(thresholds, view), view["x"], view["y"])


def function_of(rule):
    """The function of a rule: here, or how an application draws."""
    name = rule.removeprefix("draw_")
    return globals()[rule] if rule in globals() else attached()[name].draw


if __name__ == "__main__":
    gc.freeze()  # what was imported stays
    gc.set_threshold(200_000)  # a figure and its fonts are many objects, and hardly any is garbage
    run_rule(function_of(snakemake.rule), snakemake)

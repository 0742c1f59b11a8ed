"""Functions of the rules of figures, which read files, draw, and save figures."""

import gc
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import chdir, contextmanager, nullcontext
from functools import partial
from multiprocessing import get_context

gc.set_threshold(200_000)  # of the many objects of imports and figures hardly any is garbage
if __name__ == "__main__":
    sys.modules["dask"] = None  # no array is lazy, for which xarray would import it
    with chdir("/"):  # the folder may have a matplotlibrc, of whoever made it
        import matplotlib  # noqa: F401
# ruff: noqa: E402

import xarray as xr

from snapmap.applications import attached
from snapmap.config.points import read_points
from snapmap.figures import maps, scales, style
from snapmap.figures.thresholds import draw_threshold_map, draw_thresholds
from snapmap.study.provenance import hash_drawing
from snapmap.study.variables import open_whole
from snapmap.workflow.job_log import end_with, run_rule


def draw_study(files, folder, views, applications, threads, watch):
    """Draw the figures that every study has, in one job, as its start takes longer than a figure.

    files: paths of cube and thresholds, and of the largest stresses if beams have a strength
    folder: where figures are saved; threads: number of processes
    views: figures by kind, as `products.Views` has them, in plain values
    applications: arguments of `draw` of applications, by the names of their folders
    watch: as of `run_rule`
    """
    points = read_points(*views["own_points"]) if views["own_points"] else ()
    for key in ("cube", "threshold", "stress"):
        if key in files:
            open_whole(files[key]).close()
    of_thresholds = partial(_draw_thresholds, files, folder)
    tasks = [
        *(partial(_draw_maps, files, folder, points, **figure) for figure in views["maps"]),
        *(partial(of_thresholds, draw_thresholds, 2, view) for view in views["curves"]),
        *(partial(of_thresholds, draw_threshold_map, 1, view) for view in views["fields"]),
    ]
    tasks += [partial(attached()[name].draw, *how) for name, how in applications.items()]
    side_by_side(tasks, threads, watch)


def side_by_side(tasks, processes, watch):
    """Call tasks in forked processes, which share all imports but no open file."""
    if processes == 1 or sys.platform != "linux":  # elsewhere libraries do not outlive a fork
        watch()
        for task in tasks:
            task()
        return
    fork = get_context("fork")
    with ProcessPoolExecutor(processes, fork, end_with, [os.getpid()]) as pool:
        called = [pool.submit(task) for task in tasks]
        watch()
        for done in called:
            done.result()


@contextmanager
def _opened(files):
    """Open cube and thresholds; stresses add their share of the strength to the cube."""
    with (
        xr.open_dataset(files["cube"]) as cube,
        xr.open_dataset(files["threshold"]) as thresholds,
        xr.open_dataset(files["stress"]) if "stress" in files else nullcontext() as stress,
    ):
        if stress is not None:
            share = stress.stress_max / stress.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            cube = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        yield cube, thresholds


def _along(dataset, view):
    at = {key: place for key, place in view["at"].items() if key in dataset.dims}
    return scales.along(dataset.isel(at), view["x"], view["y"])


def _draw_maps(files, folder, points, name, shows, panels):
    """Draw a figure with maps of cells, on two columns, or on one if there is a single map."""
    x, y = panels[0]["x"], panels[0]["y"]
    with _opened(files) as (cube, thresholds):
        bands = (_along(thresholds, view) if shows == "snaps" else None for view in panels)
        pairs = zip(panels, bands, strict=True)
        data = [(_along(cube, view), band, view["required_shocks"]) for view, band in pairs]
        columns = min(len(panels), 2)
        with style.saved(f"{folder}/{name}", cube.attrs, 3.6, columns) as figure:
            if columns == 2:
                maps.draw_maps(figure, data, x, y, points, shows)
                return
            cells, band, shocks = data[0]
            maps.draw_map(figure.subplots(), cells, band, x, y, shocks, points, shows)


def _draw_thresholds(files, folder, draw, columns, view):
    with (
        _opened(files) as (_, thresholds),
        style.saved(f"{folder}/{view['name']}", thresholds.attrs, 3.4, columns) as figure,
    ):
        draw(figure.subplots(), _along(thresholds, view), view["x"], view["y"])


def function_of(rule):
    """Give the function of a rule: one of this module, or `draw` of an application."""
    name = rule.removeprefix("draw_")
    return globals()[rule] if rule in globals() else attached()[name].draw


if __name__ == "__main__":
    gc.freeze()  # what was imported stays
    run_rule(function_of(snakemake.rule), snakemake, partial(hash_drawing, __file__))

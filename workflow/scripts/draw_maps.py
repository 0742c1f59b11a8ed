"""Rule draw_maps: draw maps over two axes of the cube, or of the thresholds, and some together."""

import math
from pathlib import Path

import xarray as xr

from snapmap.figures import maps, scales, style, thresholds
from snapmap.io.job_log import job_log


def draw_maps(cube_path, threshold_path, views, together, marks, folder):
    """Draw each view, one column wide, and some maps of outcomes side by side, as maps.pdf.

    views: name, x, y and at, the place on each other axis; without N as one of these, thresholds
    together: views of outcomes over the same axes; marks: name, f0 and N of shocks to point out
    """
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        style.paper(),
    ):
        for view in views:
            _draw_map(cube, found, **view, marks=marks, folder=folder)
        if together:
            _draw_together(cube, found, together, folder)


def _draw_map(cube, found, name, x, y, at, marks, folder):
    figure = style.single_column(height=3.6)
    lines = scales.along(_at(found, at), x, y)
    if "N" in (x, y, *at):
        cells = scales.along(cube.isel(at), x, y)
        maps.draw_map(figure.subplots(), cells, lines, x, y, marks)
    else:
        thresholds.draw_threshold_map(figure.subplots(), lines, x, y)
    style.save(figure, f"{folder}/{name}", cube.attrs)


def _draw_together(cube, found, views, folder):
    figure = style.double_column(height=1.2 + 2.1 * math.ceil(len(views) / maps.COLUMNS))
    x, y = views[0]["x"], views[0]["y"]
    panels = [
        (scales.along(cube.isel(view["at"]), x, y), scales.along(_at(found, view["at"]), x, y))
        for view in views
    ]
    maps.draw_maps(figure, panels, x, y)
    style.save(figure, f"{folder}/maps", cube.attrs)


def _at(found, at):
    return found.isel({key: place for key, place in at.items() if key != "N"})


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        draw_maps(
            cube_path=snakemake.input.cube,
            threshold_path=snakemake.input.threshold,
            views=snakemake.params.views,
            together=snakemake.params.together,
            marks=snakemake.params.marks,
            folder=Path(snakemake.output.png[0]).parent,
        )

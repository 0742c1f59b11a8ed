"""Rule draw_snap_maps: draw which cells snap, with the thresholds, and maps of thresholds."""

from contextlib import nullcontext

import xarray as xr

from snapmap.figures import layout, maps, scales, style, thresholds
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import check_alike
from snapmap.io.points import read_points


def draw_snap_maps(
    cube_path, threshold_path, views, together, fields, own_points, folder, traces_path=None
):
    """Draw which cells snap, one column wide, and some of it side by side; then thresholds.

    views: of cells: name, x, y, at, the place on each other axis, and required_shocks
    fields: views of thresholds
    together: some of `views` over the same axes, for snap_maps.pdf
    own_points: path and SHA-256 of a user's own points, or nothing
    traces_path: with the stress of each cell, of devices that have a strength, or nothing
    """
    own_points = read_points(*own_points) if own_points else ()
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        xr.open_dataset(traces_path) if traces_path else nullcontext() as traces,
        style.paper(),
    ):
        check_alike(cube, found, threshold_path)
        if traces is not None:
            check_alike(cube, traces, traces_path)
            share = traces.stress_max / traces.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            cube = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        for view in views:
            ax = layout.single_box()
            panel, x, y = _panel(cube, found, view), view["x"], view["y"]
            maps.draw_snap_map(ax, *panel, x, y, view["required_shocks"], own_points)
            _save(ax.figure, f"{folder}/{view['name']}", cube.attrs)
        if together:
            figure = style.double_column(height=9)
            panels = [_panel(cube, found, view) for view in together]
            maps.draw_maps(figure, panels, together[0]["x"], together[0]["y"], own_points)
            style.save(figure, f"{folder}/snap_maps", cube.attrs)
        for view in fields:
            ax = layout.single_box()
            lines = scales.along(found.isel(view["at"]), view["x"], view["y"])
            thresholds.draw_threshold_map(ax, lines, view["x"], view["y"])
            _save(ax.figure, f"{folder}/{view['name']}", found.attrs)


def _panel(cube, found, view):
    x, y, at = view["x"], view["y"], view["at"]
    lines = found.isel({key: place for key, place in at.items() if key != "N"})
    return maps.Panel(scales.along(cube.isel(at), x, y), scales.along(lines, x, y))


def _save(figure, stem, attributes):
    layout.trim(figure)
    style.save(figure, stem, attributes)


if __name__ == "__main__":
    run_rule(draw_snap_maps, snakemake)

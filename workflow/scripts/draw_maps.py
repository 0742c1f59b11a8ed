"""Rule draw_maps: draw maps over two axes of the cube: when beams snap, and where they end."""

import xarray as xr

from snapmap.figures import layout, maps, scales, style
from snapmap.io.job_log import run_rule
from snapmap.io.points import read_points


def draw_maps(cube_path, times, ends, together, own_points, folder):
    """Draw when beams snap, one column wide; then where they end, and some of it side by side.

    times, ends: views: name, x, y, at, the place on each other axis, and required_shocks
    together: some of `ends` over the same axes, for maps.pdf
    own_points: path and SHA-256 of a user's own points, or nothing
    """
    own_points = read_points(*own_points) if own_points else ()
    with xr.open_dataset(cube_path, engine="netcdf4") as cube, style.paper():
        # Of what is drawn: a cube may be larger than memory.
        colours = maps.snap_times(_cells(cube, view) for view in times)
        for view in times:
            _draw(maps.draw_time_map, cube, view, folder, ends=colours)
        for view in ends:
            shown = {"required_shocks": view["required_shocks"], "own_points": own_points}
            _draw(maps.draw_end_map, cube, view, folder, **shown)
        if together:
            x, y = together[0]["x"], together[0]["y"]
            panels = [maps.Panel(_cells(cube, view)) for view in together]
            figure = style.double_column(height=9)
            maps.draw_maps(figure, panels, x, y, own_points)
            style.save(figure, f"{folder}/maps", cube.attrs)


def _draw(draw, cube, view, folder, **others):
    ax = layout.single_box()
    draw(ax, _cells(cube, view), view["x"], view["y"], **others)
    layout.trim(ax.figure)
    style.save(ax.figure, f"{folder}/{view['name']}", cube.attrs)


def _cells(cube, view):
    return scales.along(cube.isel(view["at"]), view["x"], view["y"])


if __name__ == "__main__":
    run_rule(draw_maps, snakemake)

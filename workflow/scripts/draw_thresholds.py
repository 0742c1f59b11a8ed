"""Rule draw_thresholds: draw the thresholds over each axis, and as a damage boundary."""

import xarray as xr

from snapmap.figures import scales, style, thresholds
from snapmap.io.job_log import run_rule


def draw_thresholds(threshold_path, views, boundary, folder):
    """Draw each view, two columns wide, and the damage boundary, one column wide.

    views, boundary: name, x, y (a line for each of its values) and at, the place on other axes
    """
    with xr.open_dataset(threshold_path, engine="netcdf4") as found, style.paper():
        for view in views:
            figure = style.double_column(height=3.4)
            lines = scales.along(found.isel(view["at"]), view["x"], view["y"])
            thresholds.draw_thresholds(figure.subplots(), lines, view["x"], view["y"])
            style.save(figure, f"{folder}/{view['name']}", found.attrs)
        figure = style.single_column(height=3.2)
        lines = found.isel(boundary["at"])
        thresholds.draw_damage_boundary(figure.subplots(), lines, boundary["y"])
        style.save(figure, f"{folder}/{boundary['name']}", found.attrs)


if __name__ == "__main__":
    run_rule(draw_thresholds, snakemake)

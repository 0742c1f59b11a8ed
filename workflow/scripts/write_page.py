"""Rule write_page: write the page to explore a cube."""

from contextlib import nullcontext
from pathlib import Path

import xarray as xr

from snapmap.figures.explore import page
from snapmap.io.atomic import replacing
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import check_alike


def write_page(cube_path, traces_path, threshold_path, horizon, path, tolerance_path=None):
    """Read a cube, its traces and its thresholds, and write the page; horizon: us.

    tolerance_path: of thresholds of devices as made, or nothing
    """
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(traces_path, engine="netcdf4") as traces,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        xr.open_dataset(tolerance_path) if tolerance_path else nullcontext() as made,
    ):
        check_alike(cube, traces, traces_path)
        check_alike(cube, found, threshold_path)
        if made is not None:
            check_alike(cube, made, tolerance_path)
        text = page(cube, traces, found, horizon, made)
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run_rule(write_page, snakemake)

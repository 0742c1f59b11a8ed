"""Rule write_page: write the page to explore a cube."""

from pathlib import Path

import xarray as xr

from snapmap.atomic import replacing
from snapmap.figures.explore import page
from snapmap.journal import journal


def write_page(cube_path, traces_path, path):
    """Read a cube and its traces, packed as they are, and write the page."""
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(traces_path, engine="netcdf4", mask_and_scale=False) as traces,
    ):
        text = page(cube, traces)
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        write_page(
            cube_path=snakemake.input.cube,
            traces_path=snakemake.input.traces,
            path=snakemake.output.page,
        )

"""Rule draw_maps: draw the maps of all C of the cube side by side."""

import math

import xarray as xr

from snapmap.figures import maps, style
from snapmap.journal import journal


def draw_maps(cube_path, threshold_path, pdf_path, png_path):
    """Read a cube and its thresholds and draw the map of every C, as wide as two columns."""
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        style.paper(),
    ):
        figure = style.double_column(height=1.2 + 2.1 * math.ceil(cube.C.size / maps.COLUMNS))
        maps.draw_maps(figure, cube, found.sel(C=cube.C))
        style.save(figure, pdf_path, png_path, cube.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_maps(
            cube_path=snakemake.input.cube,
            threshold_path=snakemake.input.threshold,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

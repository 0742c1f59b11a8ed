"""Rule draw_map: draw the map of one C of the cube."""

import xarray as xr

from snapmap.figures import maps, style
from snapmap.journal import journal


def draw_map(cube_path, threshold_path, damping_index, pdf_path, png_path):
    """Read a cube and its thresholds and draw the map at one index along C, one column wide."""
    with (
        xr.open_dataset(cube_path, engine="netcdf4") as cube,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        style.paper(),
    ):
        cells = cube.isel(C=damping_index)
        figure = style.single_column(height=3.6)
        maps.draw_map(figure.subplots(), cells, found.sel(C=cells.C))
        style.save(figure, pdf_path, png_path, cube.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_map(
            cube_path=snakemake.input.cube,
            threshold_path=snakemake.input.threshold,
            damping_index=snakemake.params.damping_index,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

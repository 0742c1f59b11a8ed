"""Rule draw_map: draw the map of one C of the cube."""

import xarray as xr

from snapmap.figures import maps, style


def draw_map(cube_path, damping_index, pdf_path, png_path):
    """Read a cube and draw its map at one index along C, as wide as one column."""
    with xr.open_dataset(cube_path, engine="netcdf4") as cube, style.paper():
        figure = style.single_column(height=3.4)
        maps.draw_map(figure.subplots(), cube.isel(C=damping_index))
        style.save(figure, pdf_path, png_path, cube.attrs)


if __name__ == "__main__":
    draw_map(
        cube_path=snakemake.input.cube,
        damping_index=snakemake.params.damping_index,
        pdf_path=snakemake.output.pdf,
        png_path=snakemake.output.png,
    )

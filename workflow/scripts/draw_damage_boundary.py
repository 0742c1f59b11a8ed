"""Rule draw_damage_boundary: draw the thresholds of every C as a damage boundary."""

import xarray as xr

from snapmap.figures import style, thresholds
from snapmap.journal import journal


def draw_damage_boundary(threshold_path, pdf_path, png_path):
    """Read the thresholds and draw them over the velocity change, as wide as one column."""
    with xr.open_dataset(threshold_path, engine="netcdf4") as found, style.paper():
        figure = style.single_column(height=3.2)
        thresholds.draw_damage_boundary(figure.subplots(), found)
        style.save(figure, pdf_path, png_path, found.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_damage_boundary(
            threshold_path=snakemake.input.threshold,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

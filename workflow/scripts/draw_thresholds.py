"""Rule draw_thresholds: draw the thresholds of every C over the frequency of the pulse."""

import xarray as xr

from snapmap.figures import style, thresholds
from snapmap.journal import journal


def draw_thresholds(threshold_path, pdf_path, png_path):
    """Read the thresholds and draw them as wide as two columns."""
    with xr.open_dataset(threshold_path, engine="netcdf4") as found, style.paper():
        figure = style.double_column(height=3.4)
        thresholds.draw_thresholds(figure.subplots(), found)
        style.save(figure, pdf_path, png_path, found.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_thresholds(
            threshold_path=snakemake.input.threshold,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

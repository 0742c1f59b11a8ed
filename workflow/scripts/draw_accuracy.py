"""Rule draw_accuracy: draw error against time for every model."""

import xarray as xr

from snapmap.figures import accuracy, style
from snapmap.journal import journal


def draw_accuracy(accuracy_path, pdf_path, png_path):
    """Read the measured errors and draw them as wide as two columns."""
    with xr.open_dataset(accuracy_path, engine="netcdf4") as found, style.paper():
        figure = style.double_column(height=3.6)
        accuracy.draw_accuracy(figure.subplots(), found)
        style.save(figure, pdf_path, png_path, found.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_accuracy(
            accuracy_path=snakemake.input.accuracy,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

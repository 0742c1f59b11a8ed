"""Rule draw_history: draw the time history of one cell."""

import xarray as xr

from snapmap.figures import histories, style
from snapmap.journal import journal


def draw_history(history_path, pdf_path, png_path):
    """Read a history and draw it as wide as two columns."""
    with xr.open_dataset(history_path, engine="netcdf4") as history, style.paper():
        figure = style.double_column(height=4.2)
        axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
        histories.draw_history(axes, history)
        style.save(figure, pdf_path, png_path, history.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_history(
            history_path=snakemake.input.history,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

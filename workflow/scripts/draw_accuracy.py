"""Rule draw_accuracy: draw error against time for every model."""

import xarray as xr

from snapmap.figures import accuracy, style
from snapmap.io.job_log import run_rule


def draw_accuracy(accuracy_path, stem):
    """Read the measured errors and draw them as wide as two columns."""
    with xr.open_dataset(accuracy_path, engine="netcdf4") as found, style.paper():
        figure = style.double_column(height=3.6)
        accuracy.draw_accuracy(figure.subplots(), found)
        style.save(figure, stem, found.attrs)


if __name__ == "__main__":
    run_rule(draw_accuracy, snakemake)

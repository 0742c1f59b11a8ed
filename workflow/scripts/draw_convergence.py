"""Rule draw_convergence: draw how the error of the threshold falls with number and step."""

import xarray as xr

from snapmap.figures import convergence, style
from snapmap.io.job_log import run_rule


def draw_convergence(accuracy_path, stem):
    """Read the measured errors and draw them as wide as two columns."""
    with xr.open_dataset(accuracy_path, engine="netcdf4") as found, style.paper():
        figure = style.double_column(height=3.2)
        axes = figure.subplots(1, 2, sharey=True, width_ratios=[3, 2])
        convergence.draw_convergence(axes, found)
        style.save(figure, stem, found.attrs)


if __name__ == "__main__":
    run_rule(draw_convergence, snakemake)

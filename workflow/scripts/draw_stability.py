"""Rule draw_stability: draw the verdicts on the hard cases."""

import xarray as xr

from snapmap.figures import stability, style
from snapmap.io.job_log import run_rule


def draw_stability(stability_path, stem):
    """Read the hard cases and draw a panel for each model, as wide as two columns."""
    with xr.open_dataset(stability_path, engine="netcdf4") as cases, style.paper():
        figure = style.double_column(height=stability.height(cases))
        stability.draw_panels(figure, cases)
        style.save(figure, stem, cases.attrs)


if __name__ == "__main__":
    run_rule(draw_stability, snakemake)

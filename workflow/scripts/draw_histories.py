"""Rule draw_histories: draw the time history of each cell that was followed in full."""

import xarray as xr

from snapmap.figures import histories, style
from snapmap.io.job_log import run_rule


def draw_histories(history_paths, stems):
    """Read histories and draw each as wide as two columns."""
    for path, stem in zip(history_paths, stems, strict=True):
        with xr.open_dataset(path, engine="netcdf4") as history, style.paper():
            figure = style.double_column(height=4.2)
            axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
            histories.draw_history(axes, history)
            style.save(figure, stem, history.attrs)


if __name__ == "__main__":
    run_rule(draw_histories, snakemake)

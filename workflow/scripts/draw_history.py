"""Rule draw_history: draw the time history of one cell."""

from pathlib import Path

import xarray as xr

from snapmap.figures import histories, style
from snapmap.io.job_log import job_log


def draw_history(history_path, stem):
    """Read a history and draw it as wide as two columns."""
    with xr.open_dataset(history_path, engine="netcdf4") as history, style.paper():
        figure = style.double_column(height=4.2)
        axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
        histories.draw_history(axes, history)
        style.save(figure, stem, history.attrs)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        draw_history(
            history_path=snakemake.input.history,
            stem=Path(snakemake.output.png).with_suffix(""),
        )

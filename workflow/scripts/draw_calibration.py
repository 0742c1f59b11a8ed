"""Rule draw_calibration: draw measured shots over the fitted threshold and its band."""

import xarray as xr

from snapmap.figures import calibration, style
from snapmap.io.job_log import run_rule


def draw_calibration(calibration_path, stem):
    """Draw a panel for each shape and direction of the shots; two columns wide."""
    with xr.open_dataset(calibration_path, engine="netcdf4") as found, style.paper():
        panels = calibration.panels(found)
        figure = style.double_column(height=3.4)
        axes = figure.subplots(1, len(panels), squeeze=False)[0]
        for ax, panel in zip(axes, panels, strict=True):
            calibration.draw_shots(ax, panel)
        keys = calibration.shot_keys()
        title = calibration.calibration_text(found)
        figure.legend(handles=keys, loc="outside lower center", ncols=5, title=title)
        style.save(figure, stem, found.attrs)


if __name__ == "__main__":
    run_rule(draw_calibration, snakemake)

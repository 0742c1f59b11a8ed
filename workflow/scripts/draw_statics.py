"""Rule draw_statics: draw the force and the energy of a beam that is pushed slowly."""

from pathlib import Path

import xarray as xr

from snapmap.figures import statics, style
from snapmap.io.job_log import job_log


def draw_statics(statics_path, stem):
    """Read the statics and draw force and energy, as wide as one column."""
    with xr.open_dataset(statics_path, engine="netcdf4") as found, style.paper():
        figure = style.single_column(height=3.6)
        force, energy = figure.subplots(2, sharex=True, height_ratios=[3, 2])
        statics.draw_force_displacement(force, found)
        statics.draw_energy(energy, found)
        force.label_outer()
        style.save(figure, stem, found.attrs)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        draw_statics(
            statics_path=snakemake.input.statics,
            stem=Path(snakemake.output.png).with_suffix(""),
        )

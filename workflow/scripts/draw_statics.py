"""Rule draw_statics: draw the force and the energy of each beam that was pushed slowly."""

import xarray as xr

from snapmap.figures import statics, style
from snapmap.io.job_log import run_rule


def draw_statics(statics_paths, stems):
    """Read the statics of beams and draw each one's force and energy, as wide as one column."""
    for path, stem in zip(statics_paths, stems, strict=True):
        with xr.open_dataset(path, engine="netcdf4") as found, style.paper():
            figure = style.single_column(height=3.6)
            force, energy = figure.subplots(2, sharex=True, height_ratios=[3, 2])
            statics.draw_force_displacement(force, found)
            statics.draw_energy(energy, found)
            force.label_outer()
            style.save(figure, stem, found.attrs)


if __name__ == "__main__":
    run_rule(draw_statics, snakemake)

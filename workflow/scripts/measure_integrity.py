"""Rule measure_integrity: measure how far cells are from other labels, and how uncertain."""

import xarray as xr

from snapmap.basins.integrity import integrity
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write


def measure_integrity(cube_path, path):
    """Read the cube and write the integrity of its maps."""
    with xr.open_dataset(cube_path, engine="netcdf4") as cube:
        write(integrity(cube), path)


if __name__ == "__main__":
    run_rule(measure_integrity, snakemake)

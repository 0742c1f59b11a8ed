"""Rule trace_cells: follow the cells of a cube again and keep their motion in brief."""

import xarray as xr

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import read_earlier, write
from snapmap.motion.envelopes import trace


def trace_cells(cube_path, study, path, threads):
    """Read a cube, trace its cells and write the traces.

    Cells that stand in the file already, of the same study and code, are not followed again.
    """
    with xr.open_dataset(cube_path, engine="netcdf4") as cube:
        traces = trace(study_from(study, threads), cube, read_earlier(path))
    write(traces, path)
    cells = traces.bin_length.size
    print(f"{path}: {cells} of {cube.outcome.size} cells in {traces.sizes['bin']} time bins each")


if __name__ == "__main__":
    run_rule(trace_cells, snakemake)

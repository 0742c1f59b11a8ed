"""Rule trace_cells: follow the cells of a cube again and keep their motion in brief."""

import xarray as xr

from snapmap.device import devices_from
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import read_earlier, write
from snapmap.io.recorded import shocks_of
from snapmap.motion.envelopes import trace
from snapmap.solver.settings import Settings


def trace_cells(cube_path, device, pulse, model, settings, path, threads):
    """Read a cube, trace its cells and write the traces.

    Cells that stand in the file already, of the same study and code, are not followed again.
    """
    with xr.open_dataset(cube_path, engine="netcdf4") as cube:
        asked = Settings(**settings, threads=threads)
        earlier = read_earlier(path)
        traces = trace(devices_from(device), cube, model, asked, shocks_of(pulse), earlier)
    write(traces, path)
    cells = traces.bin_length.size
    print(f"{path}: {cells} of {cube.outcome.size} cells in {traces.sizes['bin']} time bins each")


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        trace_cells(
            cube_path=snakemake.input.cube,
            device=snakemake.params.device,
            pulse=snakemake.params.pulse,
            model=snakemake.params.model,
            settings=snakemake.params.settings,
            path=snakemake.output.traces,
            threads=snakemake.threads,
        )

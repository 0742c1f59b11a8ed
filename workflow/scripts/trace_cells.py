"""Rule trace_cells: follow the cells of a cube again and keep their motion in brief."""

import xarray as xr

from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.protocol import Protocol
from snapmap.traces import trace


def trace_cells(cube_path, device, model, protocol, path, threads):
    """Read a cube, trace its cells and write the traces."""
    with xr.open_dataset(cube_path, engine="netcdf4") as cube:
        traces = trace(device_from(device), cube, model, Protocol(**protocol), threads)
    write(traces, path)
    cells = traces.bin_length.size
    print(f"{path}: {cells} of {cube.outcome.size} cells in {traces.sizes['bin']} time bins each")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        trace_cells(
            cube_path=snakemake.input.cube,
            device=snakemake.params.device,
            model=snakemake.params.model,
            protocol=snakemake.params.protocol,
            path=snakemake.output.traces,
            threads=snakemake.threads,
        )

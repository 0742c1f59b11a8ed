"""Rule measure_settled: sweep one grid with less and more damping of the beam."""

from dataclasses import replace

import xarray as xr

from snapmap.config import device_document
from snapmap.cube import sweep
from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.portable import geometric, linear
from snapmap.provenance import provenance

GRID = {
    "N": linear(600, 2400, 61),
    "f0": geometric(100, 3e4, 31),
    "C": [0.025, 25.0, 200.0],
}
"""Multiples of g, Hz, uN us/um."""
MODEL = {"model": "cosines", "modes": 4}
HORIZON = 6000.0
"""Followed after the pulse, us."""


def measure_settled(device, beam_dampings, path, threads):
    """Sweep and repeat the grid for each beam damping (1/us) and write all as one dataset."""
    device = device_from(device)
    cubes = []
    for damping in beam_dampings:
        damped = replace(device, beam=replace(device.beam, damping=damping))
        asked = {"horizon": HORIZON, "repeat": True, "threads": threads}
        cubes.append(sweep(damped, **GRID, **MODEL, **asked))
    attributes = {"long_name": "damping rate of the beam itself", "units": "us-1"}
    axis = xr.DataArray(beam_dampings, dims="beam_damping", name="beam_damping", attrs=attributes)
    document = {
        "device": device_document(device),
        "model": {"name": MODEL["model"], "modes": MODEL["modes"]},
        "sweep": {"horizon": f"{HORIZON} us"},
    }
    settled = xr.concat(cubes, dim=axis, combine_attrs="override")
    title = "Cells proven to have settled, by damping of mass and beam"
    settled.attrs = {"Conventions": "CF-1.11", "title": title, **provenance(document)}
    write(settled, path)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        measure_settled(
            device=snakemake.params.device,
            beam_dampings=snakemake.params.beam_dampings,
            path=snakemake.output.settled,
            threads=snakemake.threads,
        )

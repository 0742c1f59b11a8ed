"""Rule measure_settled: sweep one grid with less and more damping of the beam."""

from snapmap.device import device_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.numerics.portable import geometric, linear
from snapmap.sweeps.cube import sweep

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
    asked = {"horizon": HORIZON, "repeat": True, "threads": threads, "damping": beam_dampings}
    settled = sweep(device_from(device), **GRID, **MODEL, **asked)
    settled.attrs["title"] = "Cells proven to have settled, by damping of mass and beam"
    write(settled, path)


if __name__ == "__main__":
    run_rule(measure_settled, snakemake)

"""Rule measure_stability: follow the hard cases with every model at many steps."""

from snapmap.device import device_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from studies.stability.measure import measure


def measure_stability(device, path, threads):
    """Follow the hard cases and write what each was; device in internal units."""
    write(measure(device_from(device), threads=threads), path)


if __name__ == "__main__":
    run_rule(measure_stability, snakemake)

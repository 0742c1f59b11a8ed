"""Rule measure_stability: follow the hard cases with every model at many steps."""

from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.stability.measure import measure


def measure_stability(device, path, threads):
    """Follow the hard cases and write what each was; device in internal units."""
    write(measure(device_from(device), threads=threads), path)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        measure_stability(
            device=snakemake.params.device,
            path=snakemake.output.stability,
            threads=snakemake.threads,
        )

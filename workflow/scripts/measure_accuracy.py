"""Rule measure_accuracy: measure the error from each source, and the time of a simulation."""

from snapmap.accuracy.dataset import summary
from snapmap.accuracy.measure import measure
from snapmap.accuracy.plans import PLANS
from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.protocol import Protocol


def measure_accuracy(device, axes, protocol, plan, path, threads):
    """Measure the cases of a plan, by name; values in internal units, axes as in the cube."""
    found = measure(device_from(device), axes, Protocol(**protocol), PLANS[plan], threads)
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        measure_accuracy(
            device=snakemake.params.device,
            axes=snakemake.params.axes,
            protocol=snakemake.params.protocol,
            plan=snakemake.params.plan,
            path=snakemake.output.accuracy,
            threads=snakemake.threads,
        )

"""Rule measure_accuracy: measure the error from each source, and the time of a simulation."""

from snapmap.device import device_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.io.recorded import shocks_of
from snapmap.solver.settings import Settings
from studies.accuracy.dataset import summary
from studies.accuracy.measure import measure
from studies.accuracy.plans import PLANS


def measure_accuracy(device, pulse, axes, settings, plan, path, threads):
    """Measure the cases of a plan, by name; values in internal units, axes: C, f0 and N."""
    settings = Settings(**settings, threads=threads)
    found = measure(device_from(device), axes, settings, PLANS[plan], shocks_of(pulse))
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    run_rule(measure_accuracy, snakemake)

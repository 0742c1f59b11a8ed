"""Rule find_tolerance: find what thresholds devices have whose values scatter."""

from snapmap.device import devices_from
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import write
from snapmap.io.recorded import shocks_of
from snapmap.tolerances.dataset import summary, tolerance


def find_tolerance(device, pulse, model, axes, asked, requirements, followed, path, threads):
    """Draw the devices, find their thresholds and write them; values in internal units.

    asked: scatters, together, samples, index_samples and seed, as `tolerance` takes them
    followed: horizon and energy_tolerance
    """
    shocks = shocks_of(pulse)
    shocks = {"pulse": shocks.pulse, "direction": shocks.direction}
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    asked = {**axes, **asked, **followed, **shocks, "requirements": required}
    found = tolerance(devices_from(device), model=model, threads=threads, **asked)
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        find_tolerance(
            device=snakemake.params.device,
            pulse=snakemake.params.pulse,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            asked=snakemake.params.asked,
            requirements=snakemake.params.requirements,
            followed=snakemake.params.followed,
            path=snakemake.output.tolerance,
            threads=snakemake.threads,
        )

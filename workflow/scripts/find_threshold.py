"""Rule find_threshold: find where snapping begins, for each point of all axes but N."""

from snapmap.device import devices_from
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import write
from snapmap.thresholds.surface import summary, threshold


def find_threshold(device, model, axes, highest, followed, path, threads):
    """Find the thresholds and write them; values in internal units, axes as in the cube.

    followed: horizon, energy_tolerance, tolerance and skip, as `threshold` takes them
    """
    asked = {**axes, **followed, "highest": highest, "threads": threads}
    found = threshold(devices_from(device), model=model, **asked)
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        find_threshold(
            device=snakemake.params.device,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            highest=snakemake.params.highest,
            followed=snakemake.params.followed,
            path=snakemake.output.threshold,
            threads=snakemake.threads,
        )

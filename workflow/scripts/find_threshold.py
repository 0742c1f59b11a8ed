"""Rule find_threshold: find where snapping begins, for each point of all axes but N."""

from snapmap.device import devices_from
from snapmap.io.atomic import replacing
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import read_earlier, write
from snapmap.io.recorded import shocks_of
from snapmap.thresholds.rows import tidy
from snapmap.thresholds.surface import summary, threshold


def find_threshold(device, pulse, model, axes, highest, followed, path, csv_path, threads):
    """Find the thresholds and write them, also as a table; internal units, axes as in the cube.

    Rows that stand in the file already, of the same study and code, are not found again.
    followed: horizon, energy_tolerance, tolerance and skip, as `threshold` takes them
    """
    shocks = shocks_of(pulse)
    asked = {**axes, **followed, "pulse": shocks.pulse, "direction": shocks.direction}
    limits = {"highest": highest, "threads": threads}
    earlier = read_earlier(path)
    found = threshold(devices_from(device), model=model, **asked, **limits, earlier=earlier)
    write(found, path)
    with replacing(csv_path) as temporary:
        tidy(found).to_csv(temporary, index=False)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        find_threshold(
            device=snakemake.params.device,
            pulse=snakemake.params.pulse,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            highest=snakemake.params.highest,
            followed=snakemake.params.followed,
            path=snakemake.output.threshold,
            csv_path=snakemake.output.table,
            threads=snakemake.threads,
        )

"""Rule find_threshold: find where snapping begins, for each C and f0."""

from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.surface import summary, threshold


def find_threshold(device, model, axes, highest, followed, tolerance, path, threads):
    """Find the thresholds and write them; values in internal units, axes as in the cube.

    followed: horizon and energy_tolerance, as in the sweep
    """
    found = threshold(
        device_from(device),
        **axes,
        model=model,
        **followed,
        tolerance=tolerance,
        highest=highest,
        threads=threads,
    )
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        find_threshold(
            device=snakemake.params.device,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            highest=snakemake.params.highest,
            followed=snakemake.params.followed,
            tolerance=snakemake.params.tolerance,
            path=snakemake.output.threshold,
            threads=snakemake.threads,
        )

"""Rule simulate_slab: follow the cells of one slab of the grid."""

from snapmap.device import devices_from
from snapmap.io.job_log import job_log
from snapmap.io.recorded import shocks_of
from snapmap.solver.settings import Settings
from snapmap.sweeps.slab import write_slab


def simulate_slab(device, pulse, model, axes, settings, skip, path, threads, code):
    """Simulate one slab and write it; values in internal units, axes as in the cube."""
    asked = Settings(**settings, threads=threads)
    shocks = shocks_of(pulse)
    counts = write_slab(devices_from(device), model, axes, asked, path, code, skip, shocks)
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        simulate_slab(
            device=snakemake.params.device,
            pulse=snakemake.params.pulse,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            settings=snakemake.params.settings,
            skip=snakemake.params.skip,
            path=snakemake.output.slab,
            threads=snakemake.threads,
            code=snakemake.params.code,
        )

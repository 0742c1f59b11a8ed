"""Rule simulate_history: follow one cell in full."""

from snapmap.device import device_from
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import write
from snapmap.motion.history import simulate


def simulate_history(device, model, cell, followed, path):
    """Simulate one cell beyond its snap and write its history.

    followed: horizon, until and energy_tolerance, as in the sweep
    """
    name, options = model["name"], {key: model[key] for key in model if key != "name"}
    history = simulate(device_from(device), **cell, model=name, **followed, **options)
    write(history, path)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        simulate_history(
            device=snakemake.params.device,
            model=snakemake.params.model,
            cell=snakemake.params.cell,
            followed=snakemake.params.followed,
            path=snakemake.output.history,
        )

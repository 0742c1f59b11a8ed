"""Rule simulate_history: follow one cell in full."""

from snapmap.device import device_from
from snapmap.io.job_log import job_log
from snapmap.io.netcdf import write
from snapmap.io.recorded import shocks_of
from snapmap.motion.history import simulate


def simulate_history(device, pulse, model, cell, followed, path):
    """Simulate one cell beyond its snap, under the first pulse of a study, and write its history.

    followed: horizon, until and energy_tolerance, as in the sweep
    """
    name, options = model["name"], {key: model[key] for key in model if key != "name"}
    shocks = shocks_of(pulse)
    push = {"pulse": next(iter(shocks.shapes.values())), "direction": shocks.directions[0]}
    history = simulate(device_from(device), **cell, model=name, **followed, **push, **options)
    write(history, path)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        simulate_history(
            device=snakemake.params.device,
            pulse=snakemake.params.pulse,
            model=snakemake.params.model,
            cell=snakemake.params.cell,
            followed=snakemake.params.followed,
            path=snakemake.output.history,
        )

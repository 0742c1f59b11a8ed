"""Rule simulate_history: follow one cell in full."""

from dataclasses import replace

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.motion.history import history_of


def simulate_history(study, cell, path):
    """Simulate one cell beyond its snap, under the first pulse of a study, and write its history.

    cell: N, f0 and C
    """
    study = study_from(study)
    write(history_of(replace(study, shocks=study.shocks.first()), **cell), path)


if __name__ == "__main__":
    run_rule(simulate_history, snakemake)

"""Rule simulate_slab: follow the cells of one slab of the grid."""

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.sweeps.slab import write_slab


def simulate_slab(study, axes, path, threads, code):
    """Simulate one slab and write it; values in internal units, axes as in the cube."""
    counts = write_slab(study_from(study, threads), axes, path, code)
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


if __name__ == "__main__":
    run_rule(simulate_slab, snakemake)

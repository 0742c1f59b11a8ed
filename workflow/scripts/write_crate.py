"""Rule write_crate: pack a finished study with its config and the code."""

from pathlib import Path

from snapmap.io import crate
from snapmap.io.job_log import run_rule


def write_crate(config, named, result_paths, path):
    """Pack the results of a run, the files that its config names, and this project's code."""
    crate.write_crate(path, Path(__file__).parents[2], config, named, result_paths)


if __name__ == "__main__":
    run_rule(write_crate, snakemake)

"""Rule fit_calibration: read values of the device off measured shots."""

from dataclasses import replace

from snapmap.calibration.dataset import calibration_of, summary
from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.io.shots import read_shots


def fit_calibration(study, calibration, path, threads):
    """Fit the unknowns of a config's calibration, its fields by name, and write them."""
    files = calibration["files"]
    table = read_shots(calibration["shots"], files[calibration["shots"]])
    study = study_from(study, threads)
    study = replace(study, shocks=study.shocks.first())
    found = calibration_of(study, table, calibration["unknowns"], calibration["C"], files)
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    run_rule(fit_calibration, snakemake)

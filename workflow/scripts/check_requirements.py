"""Rule check_requirements: hold each required shock against its threshold."""

import csv
from dataclasses import replace
from math import nan

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.recorded import shocks_of
from snapmap.motion.history import Extremes, extremes_of
from snapmap.random_vibration.verdicts import check_vibrations
from snapmap.shock_spectra.verdicts import check_spectra
from snapmap.thresholds.requirements import Verdict, check, summary


def check_requirements(study, requirements, vibrations, spectra, C, tolerance, path, threads):
    """Simulate the required shocks and write a row for each, device and C, with its motion."""
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    study = study_from(study, threads)
    verdicts = check(study, required, C, tolerance)
    moved = [
        extremes_of(
            replace(study, device=device, shocks=one["shocks"]), one["N"], one["f0"], damping
        )
        for one in required
        for device in study.devices().values()
        for damping in C
    ]
    shaken = check_vibrations(study, vibrations, C) + check_spectra(study, spectra, C)
    verdicts += shaken
    moved += [Extremes(*[nan] * len(Extremes._fields))] * len(shaken)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(Verdict._fields + Extremes._fields)
        rows.writerows(told + found for told, found in zip(verdicts, moved, strict=True))
    print(f"{path}: {summary(verdicts)}")


if __name__ == "__main__":
    run_rule(check_requirements, snakemake)

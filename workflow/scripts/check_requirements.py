"""Rule check_requirements: hold each required shock against its threshold."""

import csv
from dataclasses import replace
from itertools import chain, product
from math import nan

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.recorded import shocks_of
from snapmap.motion.history import Extremes, extremes_of
from snapmap.random_vibration.verdicts import check_vibrations
from snapmap.shock_spectra.verdicts import check_spectra
from snapmap.thresholds.requirements import Survival, Verdict, check, judge, summary


def check_requirements(study, requirements, vibrations, spectra, C, tolerance, path, threads):
    """Simulate the required shocks; write a row for each, device and C: motion, and survival."""
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    study = study_from(study, threads)
    verdicts = check(study, required, C, tolerance)
    asked = product(required, study.devices().values(), C)
    moved, survived = [], []
    for place, (one, device, damping) in enumerate(asked):
        pushed = replace(study, device=device, shocks=one["shocks"])
        moved.append(extremes_of(pushed, one["N"], one["f0"], damping))
        verdicts[place], survival = judge(
            verdicts[place], device, moved[-1].stress_max, one["survives"]
        )
        survived.append(survival)
    shaken = check_vibrations(study, vibrations, C) + check_spectra(study, spectra, C)
    verdicts += shaken
    for rows, kind in ((moved, Extremes), (survived, Survival)):
        rows += [kind(*[nan] * len(kind._fields))] * len(shaken)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(Verdict._fields + Extremes._fields + Survival._fields)
        rows.writerows(map(chain.from_iterable, zip(verdicts, moved, survived, strict=True)))
    print(f"{path}: {summary(verdicts)}")


if __name__ == "__main__":
    run_rule(check_requirements, snakemake)

"""Rule check_requirements: hold each required shock against its threshold."""

import csv

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.recorded import shocks_of
from snapmap.thresholds.requirements import Verdict, check, summary


def check_requirements(study, requirements, C, tolerance, path, threads):
    """Simulate the required shocks and write a row for each, device and C."""
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    verdicts = check(study_from(study, threads), required, C, tolerance)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(Verdict._fields)
        rows.writerows(verdicts)
    print(f"{path}: {summary(verdicts)}")


if __name__ == "__main__":
    run_rule(check_requirements, snakemake)

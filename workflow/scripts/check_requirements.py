"""Rule check_requirements: hold each required shock against its threshold."""

import csv

from snapmap.device import devices_from
from snapmap.io.job_log import job_log
from snapmap.io.recorded import shocks_of
from snapmap.thresholds.requirements import Verdict, check, summary


def check_requirements(device, requirements, C, model, followed, path, threads):
    """Simulate the required shocks and write a row for each, device and C."""
    asked = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    verdicts = check(devices_from(device), asked, C, model, followed, threads)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(Verdict._fields)
        rows.writerows(verdicts)
    print(f"{path}: {summary(verdicts)}")


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        check_requirements(
            device=snakemake.params.device,
            requirements=snakemake.params.requirements,
            C=snakemake.params.C,
            model=snakemake.params.model,
            followed=snakemake.params.followed,
            path=snakemake.output.requirements,
            threads=snakemake.threads,
        )

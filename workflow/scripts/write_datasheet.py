"""Rule write_datasheet: write the data sheet of each device."""

from snapmap.config.planned import study_from
from snapmap.datasheet import datasheet
from snapmap.io.atomic import replacing
from snapmap.io.job_log import run_rule
from snapmap.io.recorded import shocks_of
from snapmap.io.rows import read_rows
from snapmap.tolerances.samples import Tolerances


def write_datasheet(study, C, tolerances, requirements, requirements_path, path, threads):
    """Find what the data sheet tells beside the verdicts, and write it; values in internal units.

    tolerances: fields of `Tolerances`, or none
    """
    verdicts = read_rows(requirements_path)
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    asked = Tolerances(**tolerances) if tolerances else None
    text = datasheet(study_from(study, threads), C, asked, required, verdicts)
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    run_rule(write_datasheet, snakemake)

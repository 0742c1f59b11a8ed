"""Rule find_threshold: find where snapping begins, for each point of all axes but N."""

from snapmap.config.planned import study_from
from snapmap.io.atomic import replacing
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import read_earlier, write
from snapmap.thresholds.rows import tidy
from snapmap.thresholds.surface import summary, thresholds_of


def find_threshold(study, axes, tolerance, highest, path, table_path, threads):
    """Find the thresholds and write them, also as a table; internal units, axes as in the cube.

    Rows that stand in the file already, of the same study and code, are not found again.
    """
    asked = study_from(study, threads), axes, tolerance, highest
    found = thresholds_of(*asked, earlier=read_earlier(path))
    write(found, path)
    with replacing(table_path) as temporary:
        tidy(found).to_csv(temporary, index=False)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    run_rule(find_threshold, snakemake)

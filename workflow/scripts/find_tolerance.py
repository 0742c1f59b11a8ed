"""Rule find_tolerance: find what thresholds devices have whose values scatter."""

from snapmap.config.planned import study_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.io.recorded import shocks_of
from snapmap.tolerances.dataset import summary, tolerances_of
from snapmap.tolerances.samples import Tolerances


def find_tolerance(study, axes, tolerances, requirements, left_out, path, threads):
    """Draw the devices, find their thresholds and write them; values in internal units.

    tolerances: fields of `Tolerances`; left_out: names of requirements that the yield leaves out
    """
    required = [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]
    found = tolerances_of(study_from(study, threads), axes, Tolerances(**tolerances), required)
    if required and left_out:
        found["yield"].attrs["leaves_out"] = ", ".join(left_out)
    write(found, path)
    print(f"{path}: {summary(found)}")


if __name__ == "__main__":
    run_rule(find_tolerance, snakemake)

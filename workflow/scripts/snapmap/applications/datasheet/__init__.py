"""A study as a data sheet.  Imports: histories, requirements, statics."""

from ..requirements import plain_shocks, shocks_of

rule, message, priority = "write_datasheet", "Write the data sheet", 30


def outputs(study):
    """The data sheet, of a study with requirements."""
    return {"datasheet": "results/datasheet.md"} if study.requests["requirements"] else {}


def inputs(study):
    """Verdicts and, where values scatter, devices as made."""
    made = {"tolerance": "results/tolerance.nc"} if study.requests.get("tolerances") else {}
    return {"requirements": "results/requirements.csv", **made}


def params(study):
    """Title and required shocks."""
    return {"title": study.title, "requirements": plain_shocks(study)}


def run(study, requirements_path, path, tolerance_path=""):
    """Write verdicts, what is known of devices as made, and the device itself."""
    from contextlib import nullcontext

    from ...files.atomic import write_text
    from ...files.tables import read_verdicts
    from ...study.netcdf import open_whole
    from .datasheet import datasheet

    verdicts = read_verdicts(requirements_path)
    with open_whole(tolerance_path) if tolerance_path else nullcontext() as made:
        text = datasheet(study.of_thresholds(), verdicts, shocks_of(study), made, study.title)
        write_text(text, path)

"""A study as a data sheet.  Imports: histories, requirements, statics."""

from ..requirements import plain_shocks, shocks_of

rule, message, priority = "write_datasheet", "Write the data sheet", 30


def outputs(study):
    """The data sheet, of a study with requirements."""
    return {"datasheet": "results/datasheet.md"} if study.requests["requirements"] else {}


def inputs(study):
    """Verdicts and, if values scatter, devices as made."""
    batch = {"tolerance": "results/tolerance.nc"} if study.requests.get("tolerances") else {}
    return {"requirements": "results/requirements.csv", **batch}


def params(study):
    """The hash of the config, which stands on the sheet, and required shocks."""
    from ...study.provenance import config_hash

    return {"config": config_hash(study.source), "requirements": plain_shocks(study)}


def run(study, requirements_path, path, tolerance_path=""):
    """Write the data sheet of each device, with verdicts and the scatter of devices as made."""
    from contextlib import nullcontext

    from ...files.atomic import write_text
    from ...study.netcdf import open_whole
    from ..requirements.corners import read_verdicts
    from .datasheet import DAMPER, datasheet

    verdicts = read_verdicts(requirements_path)
    with open_whole(tolerance_path) if tolerance_path else nullcontext() as batches:
        sheet = {"made": batches, "title": study.title, "damper": study.units.get("C", DAMPER)}
        sheet |= {"source": study.source}
        devices, shocks = study.of_thresholds(), shocks_of(study)
        write_text(datasheet(devices, verdicts, study.written, shocks, **sheet), path)

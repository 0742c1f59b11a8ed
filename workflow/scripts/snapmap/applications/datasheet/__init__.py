"""A study as a data sheet.  Imports: histories, requirements, statics."""

from typing import Any

from ..application import Application, Config, Files
from ..requirements import plain_shocks, shocks_of


class Datasheet(Application):
    rule, message, priority = "write_datasheet", "Write the data sheet", 30

    def outputs(self, study: Config) -> Files:
        """The data sheet, of a study with requirements."""
        return {"datasheet": "results/datasheet.md"} if study.requests["requirements"] else {}

    def inputs(self, study: Config) -> Files:
        """Verdicts and, if values scatter, devices as made."""
        batch = {"tolerance": "results/tolerance.nc"} if study.requests.get("tolerances") else {}
        return {"requirements": "results/requirements.csv", **batch}

    def params(self, study: Config) -> dict[str, Any]:
        """The hash of the config, which stands on the sheet, and required shocks."""
        from ...study.provenance import config_hash

        return {"config": config_hash(study.source), "requirements": plain_shocks(study)}

    def run(
        self, study: Config, requirements_path: str, path: str, tolerance_path: str = ""
    ) -> None:
        """Write the data sheet of each device, with verdicts and the scatter of devices as made."""
        from contextlib import nullcontext

        from ...files.atomic import write_text
        from ...study.variables import open_whole
        from ..requirements.verdict import read_verdicts
        from ..whole import doubts
        from .datasheet import datasheet

        verdicts = read_verdicts(requirements_path)
        with open_whole(tolerance_path) if tolerance_path else nullcontext() as batches:
            sheet = datasheet(
                study.of_thresholds(),
                verdicts,
                study.source,
                requirements=shocks_of(study),
                made=batches,
                doubts=doubts(study),
                damper=study.units.get("C", (study.unit_of_C, 1.0)),
            )
            write_text(sheet, path)


application = Datasheet()

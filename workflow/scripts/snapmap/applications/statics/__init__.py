"""Force over displacement of a beam that is pushed slowly.  Imports: core alone."""

from ..application import Application, Config, Figures, Files


class Statics(Application):
    quick = True
    part, size = "7 Device", (3.6, 1)

    def outputs(self, study: Config) -> Files:
        """A file for each device, with its name if several; none of a user's own beam."""
        laws = study.model.laws
        if laws and laws.force:
            return {}
        several = len(study.devices()) > 1 or isinstance(study.device, dict)
        names = [f"_{name}" if several else "" for name in study.devices()]
        return {"statics": [f"results/statics{name}.nc" for name in names]}

    def run(self, study: Config, statics_paths: list[str]) -> None:
        """Write the statics of each device."""
        from ...study.variables import write
        from .statics import statics_of

        for device, path in zip(study.devices().values(), statics_paths, strict=True):
            write(statics_of(device), path)

    def figures(self, study: Config) -> Figures:
        """A figure for each device."""
        from pathlib import Path

        return {Path(path).stem: {} for path in self.outputs(study).get("statics", ())}


application = Statics()

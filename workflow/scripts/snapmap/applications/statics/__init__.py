"""Force over displacement of a beam that is pushed slowly.  Imports: core alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..application import Application, Figures, Files

if TYPE_CHECKING:
    from ...config.study import Config


class Statics(Application):
    quick = True
    part = "7 Device"

    def outputs(self, study: Config) -> Files:
        """A file for each device, with its name if several; none of a user's own beam."""
        laws = study.model.laws
        if laws and (laws.force or laws.solver):
            return {}
        several = len(study.devices()) > 1 or isinstance(study.device, dict)
        names = [f"_{name}" if several else "" for name in study.devices()]
        return {"statics": [f"results/statics{name}.nc" for name in names]}

    def run(self, study: Config, statics_paths: list[str]) -> None:
        """Write the statics of each device."""
        from ...study.netcdf import write
        from .statics import statics_of

        for device, path in zip(study.devices().values(), statics_paths, strict=True):
            write(statics_of(device), path)

    def figures(self, study: Config) -> Figures:
        """A figure for each device."""
        from pathlib import Path

        return {Path(path).stem: {} for path in self.outputs(study).get("statics", ())}

    def draw(self, figures: Figures, folder: str, statics_paths: list[str]) -> None:
        """Draw force and energy over displacement, a figure for each device."""
        from ...figures import style
        from ...study.netcdf import open_whole
        from .figure import draw_statics

        for stem, path in zip(figures, statics_paths, strict=True):
            with (
                open_whole(path) as dataset,
                style.saved(f"{folder}/{stem}", dataset.attrs, 3.6, columns=1) as figure,
            ):
                draw_statics(figure, dataset)


application = Statics()

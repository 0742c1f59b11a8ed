"""The damage boundary: thresholds over the velocity change.  Imports: core alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..application import Application, Figures, Files

if TYPE_CHECKING:
    from ...config.study import Config


class Boundary(Application):
    part = "2 Thresholds"

    def drawn_from(self, study: Config) -> Files:
        """The thresholds."""
        return {"threshold": "results/threshold.nc"}

    def figures(self, study: Config) -> Figures:
        """A figure, unless a force pushes the beam: then the frame gains no velocity."""
        from ...config.devices import nominal
        from ...config.views import choose_boundary

        views = choose_boundary(study.grid, nominal(study.device))
        return {view.name: {"lines": view.y, "at": view.at} for view in views}

    def draw(self, figures: Figures, folder: str, threshold_path: str) -> None:
        """Draw the damage boundary of each line."""
        from ...figures import style
        from ...study.netcdf import open_whole
        from .figure import draw_damage_boundary

        with open_whole(threshold_path) as thresholds:
            for stem, view in figures.items():
                with style.saved(f"{folder}/{stem}", thresholds.attrs, 3.6, columns=1) as figure:
                    chosen = thresholds.isel(view["at"])
                    draw_damage_boundary(figure.subplots(), chosen, view["lines"])


application = Boundary()

"""The damage boundary: thresholds over the velocity change.  Imports: core alone."""

from ..application import Application, Config, Figures, Files


class Boundary(Application):
    part, size = "2 Thresholds", (3.6, 1)

    def drawn_from(self, study: Config) -> Files:
        """The thresholds."""
        return {"threshold": "results/threshold.nc"}

    def figures(self, study: Config) -> Figures:
        """A figure, unless a force pushes the beam: then the frame gains no velocity."""
        from ...config.devices import nominal
        from ...config.views import choose_boundary

        views = choose_boundary(study.grid, nominal(study.device))
        return {view.name: {"lines": view.y, "at": view.at} for view in views}


application = Boundary()

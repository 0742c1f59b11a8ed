"""The region of two axes where required shocks are met.  Imports: requirements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..application import Application, Config, Figures, Files
from ..requirements import plain_shocks, shocks_of

if TYPE_CHECKING:
    import numpy as np


def design_axes(study: Config) -> dict[str, np.ndarray]:
    """The axes of a study that a design chooses, with their values."""
    from ...config.study import DESIGN

    return {key: values for key, values in study.axes.items() if key in DESIGN}


def choose_axes(study: Config) -> tuple[str, ...]:
    """Choose the axes of the window: the two design axes of several values, or none."""
    from ...study.axes import DEVICE

    several = {key: values for key, values in study.axes.items() if values.size > 1}
    chosen = tuple(key for key in design_axes(study) if key in several)
    return chosen if len(chosen) == 2 and DEVICE not in several else ()


class Window(Application):
    rule, message = "find_window", "Find the window of the requirements"
    part, size, threads, megabytes, priority = "5 Requirements", (4, 2), 4, 2000, 48

    def outputs(self, study: Config) -> Files:
        """The window, if the study has required shocks and two design axes."""
        is_drawn = shocks_of(study) and choose_axes(study)
        return {"window": "results/window.nc"} if is_drawn else {}

    def params(self, study: Config) -> dict[str, Any]:
        """The axes, required shocks, and the section `tolerances`."""
        tolerances = study.requests.get("tolerances")
        return {
            "axes": {key: values.tolist() for key, values in design_axes(study).items()},
            "requirements": plain_shocks(study),
            "tolerances": tolerances.section if tolerances else {},
        }

    def run(self, study: Config, path: str) -> None:
        """Find where required shocks are met, and which share of devices meets them."""
        from ...study.variables import write_product
        from .window import summary, window_of

        tolerances = study.requests.get("tolerances")
        axes = design_axes(study)
        dataset = window_of(study.of_thresholds(), axes, shocks_of(study), tolerances)
        write_product(dataset, path, lambda window: summary(window, study.units))

    def figures(self, study: Config) -> Figures:
        """A figure over both axes, with their units."""
        units = {key: study.units.get(key) for key in choose_axes(study)}
        return {"window": {"units": units}}


application = Window()

"""A forecast of the core time of verdicts on shocks; vibration and spectra are left out."""

from collections.abc import Sequence

from ...solver.adaptive import choose_model
from ...solver.cost import steps_and_seconds
from ...study.shock import Shock
from ...study.study import Study
from ...thresholds.cost import survey_seconds
from ...thresholds.surface import search_of
from ..histories.history import RECORDED
from .check import each_device

RUNS = 42
"""Number of runs of a required shock to its end, near N."""


def judged_seconds(
    study: Study, required: Sequence[Shock], C: Sequence[float], temperatures: Sequence[float]
) -> float:
    """Forecast the core time of the verdicts on shocks, s; arguments as those of `check`.

    If one fails, the search for changes that meet it takes as long again, or longer.
    """
    seconds = 0.0
    for shock in required:
        for _, shaken in each_device(shock.shaken(study), temperatures):
            grid, settings = shaken.set_out({"C": C, "f0": [shock.f0]}), shaken.run
            search = search_of(shaken, grid)
            cells = search.rows.cells(grid.device, shock.N, settings.horizon)
            finest = choose_model(grid.device, shaken.model, settings.start).levels[-1]
            history, runs = (
                steps_and_seconds(built, cells, settings.but(until=until))[1].sum().item()
                for built, until in ((finest, "moved"), (search.models.decides, "settled"))
            )
            seconds += survey_seconds(search) + RUNS * runs + RECORDED * history
    return seconds

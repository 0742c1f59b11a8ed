"""How long thresholds will take."""

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.cost import steps_and_seconds, tell
from ..solver.models import Follows
from ..solver.settings import Settings

SCANNED, DECIDED = 400, 300
"""Runs of the scanning and the deciding level that a row takes, about; those of finer levels count
as the latter. A ragged row takes ten times as long."""
ROUNDS, WIDTH = 26, 32
"""Refinement asks so often in turn, and fewer cells at a time take as long as WIDTH."""


def run_seconds(model: Follows, rows: Rows, settings: Settings) -> np.ndarray:
    """Core time of one run of each row in the steps of a threshold, s, about; (rows,)."""
    cells, asked = rows.cells(model.device, 0.0, settings.horizon), settings._replace(until="edge")
    return steps_and_seconds(model, cells, asked)[1][:, 0]


def survey_seconds(models: Survey, rows: Rows, settings: Settings) -> float:
    """Core time in which all thresholds of rows are found, s, about."""
    scanned, decided = (
        run_seconds(model, rows, settings) for model in (models.scans, models.decides)
    )
    return float(np.sum(SCANNED * scanned + DECIDED * decided))


def tell_cost(models: Survey, rows: Rows, settings: Settings):
    """Warn of a long search before it begins, in one line; a ValueError refuses one without end."""
    if not rows.f0.size:
        return
    decided = run_seconds(models.decides, rows, settings)
    seconds = (
        survey_seconds(models, rows, settings) / settings.threads + ROUNDS * WIDTH * decided.max()
    )
    slowest = f"f0 = {rows.f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

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
OF_BLOWS = 10
"""Times as many of a row under a drop or a train of blows: seen 6 to 13, as its labels change back
and forth."""
ROUNDS, WIDTH = 26, 32
"""Refinement asks so often in turn, and fewer cells at a time take as long as WIDTH."""


def run_seconds(model: Follows, rows: Rows, settings: Settings) -> np.ndarray:
    """Estimate the core time of one run of each row in the steps of a threshold, s, (rows,)."""
    cells = rows.cells(model.device, 0.0, settings.horizon)
    return steps_and_seconds(model, cells, settings._replace(until="edge"))[1][:, 0]


def survey_seconds(models: Survey, rows: Rows, settings: Settings) -> float:
    """Estimate the core time in which all thresholds of rows are found, s."""
    scanned = run_seconds(models.scans, rows, settings)
    decided = run_seconds(models.decides, rows, settings)
    times = np.array([OF_BLOWS if pulse.blows.size else 1 for pulse in rows.pulses])[rows.pulse]
    return float(np.sum(times * (SCANNED * scanned + DECIDED * decided)))


def tell_cost(models: Survey, rows: Rows, settings: Settings):
    """Warn of a long search before it begins, in one line; a ValueError refuses an endless one."""
    if not rows.f0.size:
        return
    decided = run_seconds(models.decides, rows, settings)
    searched = survey_seconds(models, rows, settings) / settings.threads
    seconds = searched + ROUNDS * WIDTH * decided.max()
    slowest = f"f0 = {rows.f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

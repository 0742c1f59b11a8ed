"""Estimates of how long the search for thresholds takes."""

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.cost import steps_and_seconds, tell
from ..solver.models import Follows
from ..solver.settings import Run

SCANNED, DECIDED = 400, 300
"""Typical number of runs of the scanning model for a row, and of the deciding and finer models. A
ragged row takes ten times as long."""
OF_BLOWS = 10
"""Factor on the runs of a row under a drop or a train of blows, whose labels change back and forth:
6 to 13 were measured."""
ROUNDS, WIDTH = 26, 32
"""Number of rounds of a refinement, and number of cells below which a round takes no less time."""


def run_seconds(model: Follows, rows: Rows, settings: Run) -> np.ndarray:
    """Estimate the core time of a run of each row in the time steps of thresholds, s, (rows,)."""
    cells = rows.cells(model.device, 0.0, settings.horizon)
    return steps_and_seconds(model, cells, settings.but(until="edge"))[1][:, 0]


def survey_seconds(models: Survey, rows: Rows, settings: Run) -> float:
    """Estimate the core time of the search for the thresholds of all rows, s."""
    scanned = run_seconds(models.scans, rows, settings)
    decided = run_seconds(models.decides, rows, settings)
    times = np.array([OF_BLOWS if pulse.blows.size else 1 for pulse in rows.pulses])[rows.pulse]
    return float(np.sum(times * (SCANNED * scanned + DECIDED * decided)))


def tell_cost(models: Survey, rows: Rows, settings: Run):
    """Warn of a long search, in one line; an endless one is refused with a ValueError."""
    if not rows.f0.size:
        return
    decided = run_seconds(models.decides, rows, settings)
    searched = survey_seconds(models, rows, settings) / settings.threads
    seconds = searched + ROUNDS * WIDTH * decided.max()
    slowest = f"f0 = {rows.f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

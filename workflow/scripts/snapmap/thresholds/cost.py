"""Estimates of how long the search for thresholds takes."""

import numpy as np

from ..solver.cost import steps_and_seconds, tell
from .probe import Probe
from .search import Search

SCANNED, DECIDED = 400, 300
"""Typical number of runs of the scanning model for a row, and of the deciding and finer models. A
ragged row takes ten times as long."""
OF_BLOWS = 10
"""Factor on the runs of a row under a drop or a train of blows, whose labels change back and forth:
6 to 13 were measured."""
ROUNDS, WIDTH = 26, 32
"""Number of rounds of a refinement, and number of cells below which a round takes no less time."""


def run_seconds(probe: Probe) -> np.ndarray:
    """Estimate the core time of a run of each row, s, (rows,)."""
    model, rows, settings, until = probe
    cells = rows.cells(model.device, 0.0, settings.horizon)
    return steps_and_seconds(model, cells, settings.but(until=until))[1][:, 0]


def survey_seconds(search: Search) -> float:
    """Estimate the core time of the search for the thresholds of all rows, s."""
    models, rows = search.models, search.rows
    scanned, decided = (run_seconds(search.probe(each)) for each in (models.scans, models.decides))
    times = np.array([OF_BLOWS if pulse.blows.size else 1 for pulse in rows.pulses])[rows.pulse]
    return float(np.sum(times * (SCANNED * scanned + DECIDED * decided)))


def tell_cost(search: Search) -> None:
    """Warn of a long search, in one line; an endless one is refused with a ValueError."""
    f0 = search.rows.f0
    if not f0.size:
        return
    decided = run_seconds(search.probe(search.models.decides))
    searched = survey_seconds(search) / search.settings.threads
    seconds = searched + ROUNDS * WIDTH * decided.max()
    slowest = f"f0 = {f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

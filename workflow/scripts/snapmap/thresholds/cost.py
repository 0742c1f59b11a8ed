"""How long thresholds will take."""

import numpy as np

from ..pulse.pulse import Pulse
from ..solver.adaptive import Survey
from ..solver.cells import Rows, to_rows
from ..solver.cost import steps_and_seconds, tell
from ..solver.models import Follows
from ..solver.settings import Settings

SCANNED, DECIDED = 400, 300
"""Runs of the scanning and the deciding level that a row takes, about; those of finer levels count
as the latter. A ragged row takes ten times as long."""
OF_BLOWS = 10
"""Times as many of a row under a drop or a train of blows: seen 6 to 13, as its labels change back
and forth."""
PER_RECORD = 120
"""Runs that one record of vibration takes: 12 levels, each ten times as long as told."""
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


def record_seconds(model: Follows, rows: Rows, settings: Settings, records: int) -> float:
    """Estimate the core time in which rows are followed under so many records like theirs, s."""
    return PER_RECORD * records * float(run_seconds(model, rows, settings).sum())


def tell_records(
    what: str,
    model: Follows,
    rows: Rows,
    pulse: Pulse,
    settings: Settings,
    records: int,
    drawn: float = 0.0,
) -> None:
    """Warn of rows long followed under records like a pulse, or refuse them, as `tell_cost`.

    rows: of which f0 and pulse are of no account; drawn: time in which records are, s
    """
    under = to_rows(rows.device, 1e6 / pulse.duration, rows.C, 0, (pulse,))
    seconds = drawn + record_seconds(model, under, settings, records) / settings.threads
    lasts = f"a record of {1e-6 * pulse.duration:.3g} s"
    tell(what, seconds, lasts, "write a higher lowest frequency", stacklevel=4)


def tell_cost(models: Survey, rows: Rows, settings: Settings):
    """Warn of a long search before it begins, in one line; a ValueError refuses an endless one."""
    if not rows.f0.size:
        return
    decided = run_seconds(models.decides, rows, settings)
    searched = survey_seconds(models, rows, settings) / settings.threads
    seconds = searched + ROUNDS * WIDTH * decided.max()
    slowest = f"f0 = {rows.f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

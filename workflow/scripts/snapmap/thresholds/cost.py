"""How long thresholds will take."""

import warnings

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.cost import MOST_SECONDS, steps_and_costs
from ..solver.settings import Settings

SCANNED, DECIDED = 400, 50
"""Cells of a row that the scanning and the deciding level follow, about."""
ROUNDS, WIDTH = 13, 32
"""Refinement asks so often in turn, and fewer cells at a time take as long as WIDTH."""
WORTH_SAYING = 60.0
"""What takes longer, s, is told before it begins."""


def tell_cost(models: Survey, rows: Rows, settings: Settings):
    """Warn of a long search before it begins, in one line; a ValueError refuses one without end."""
    if not rows.f0.size:
        return
    lasts = 1e6 / rows.f0 + settings.horizon
    scanned, decided = (
        steps_and_costs(model)[1][rows.device] * lasts for model in (models.scans, models.decides)
    )
    work = np.sum(SCANNED * scanned + DECIDED * decided) / settings.threads
    seconds = work + ROUNDS * WIDTH * decided.max()
    if seconds > WORTH_SAYING:
        slowest = rows.f0[np.argmax(decided)]
        told = f"thresholds: about {_spoken(seconds)}; f0 = {slowest:g} Hz takes longest"
        if seconds > MOST_SECONDS:
            raise ValueError(f"{told}; write a higher f0 or a shorter horizon")
        warnings.warn(told, stacklevel=4)


def _spoken(seconds):
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds > 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.2g} s"

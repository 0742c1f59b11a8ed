"""How long thresholds will take."""

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows, to_cells
from ..solver.cost import steps_and_seconds, tell
from ..solver.settings import Settings

SCANNED, DECIDED = 400, 50
"""Cells of a row that the scanning and the deciding level follow, about."""
ROUNDS, WIDTH = 26, 32
"""Refinement asks so often in turn, and fewer cells at a time take as long as WIDTH."""


def tell_cost(models: Survey, rows: Rows, settings: Settings):
    """Warn of a long search before it begins, in one line; a ValueError refuses one without end."""
    if not rows.f0.size:
        return
    device = models.scans.device
    cells = to_cells(device, rows.device, 0.0, rows.f0, rows.C, settings.horizon, rows.pulse)
    asked = settings._replace(until="edge")
    scanned, decided = (
        steps_and_seconds(model, cells, asked)[1] for model in (models.scans, models.decides)
    )
    work = np.sum(SCANNED * scanned + DECIDED * decided) / settings.threads
    seconds = work + ROUNDS * WIDTH * decided.max()
    slowest = f"f0 = {rows.f0[np.argmax(decided)]:g} Hz"
    tell("thresholds", seconds, slowest, "write a higher f0 or a shorter horizon", stacklevel=3)

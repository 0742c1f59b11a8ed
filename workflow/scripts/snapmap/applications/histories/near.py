"""Shocks near a required one, followed to their end."""

from collections.abc import Sequence

import numpy as np

from ...solver.adaptive import choose_model
from ...solver.cells import Observations
from ...solver.models import follow_twice
from ...study.axes import Grid, rows_of
from ...study.study import Study

# ASSUME: a shock machine repeats its peak to 1 % at best, so a beam that must stay has to stay at
# these factors of N, too.
NEAR = 1 + np.arange(-10, 11) / 1000


def follow_near(study: Study, grid: Grid, N: Sequence[float]) -> list[Observations]:
    """Follow the rows of a grid to the end twice, at each N by the finest level.

    Returns observations, (rows, N), of each step.
    """
    settings = study.run.but(until="settled")
    cells = rows_of(grid).cells(grid.device, N, settings.horizon)
    finest = choose_model(grid.device, study.model, settings.start).levels[-1]
    return follow_twice(finest, cells, settings)

"""Above which amplitude a device stays latched."""

from functools import partial

import numpy as np

from ..solver.cells import Rows
from ..solver.cost import steps_and_seconds
from ..solver.models import Follows
from ..solver.outcome import LATCHED, label
from ..solver.settings import Settings
from .search import amplitudes, walk

LATCHED_STEP = 0.01
"""Relative distance of the amplitudes that are followed to their end."""
LONGER = 4.0
"""Times its own, of steps in which the highest must latch, too: ringing beams do by chance."""
RUN_STEPS = 2e6
"""At most in a run to its end: rows of slower pulses are left out."""


def lowest_latched(
    model: Follows, rows: Rows, low: np.ndarray, high: np.ndarray, settings: Settings
) -> np.ndarray:
    """Find the lowest N above which every cell seen latches, (rows,); NaN if the highest does not.

    The highest must in LONGER steps, too.
    low, high: amplitudes between which cells are looked at, multiples of g, (rows,); NaN for
        none. The search goes down from the highest as far as all latch.
    """
    cells = rows.cells(model.device, 0.0, settings.horizon)
    lasts = (cells.t_end / steps_and_seconds(model, cells, settings)[0])[:, 0]
    N = amplitudes(np.where(lasts <= RUN_STEPS, low, np.nan), high, LATCHED_STEP)
    size = np.count_nonzero(np.isfinite(N), axis=1)
    every = np.arange(len(N))

    def leaves(by, which, below):
        """Whether cells so many places below the highest are not proven to stay, (rows, n)."""
        # Ascending, as a model may ask for its rows; the lowest once more for what is not there.
        places = np.maximum(size[which, np.newaxis] - 1 - below, 0)[:, ::-1]
        ascending = N[which[:, np.newaxis], places]
        cells = rows.take(which).cells(model.device, ascending, settings.horizon)
        runs = by.follow(cells, settings)
        return (label(*runs[:4], settings.energy_tolerance) != LATCHED)[:, ::-1]

    highest = walk(partial(leaves, model.with_step(LONGER)), every, 0, np.minimum(size, 1))
    down = walk(partial(leaves, model), every, 0, highest * size)
    return np.where(down > 0, N[every, size - np.maximum(down, 1)], np.nan)

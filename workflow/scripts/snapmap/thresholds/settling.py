"""The amplitude above which a device stays latched."""

from functools import partial

import numpy as np

from ..solver.cost import steps_and_seconds
from ..solver.outcome import LATCHED, REPEATED_STEP, label
from .probe import Probe, amplitudes, walk

LATCHED_STEP = 0.01
"""Relative step of the amplitudes that are followed to their end."""
RUN_STEPS = 2e6
"""Most time steps of a run to its end; rows of slower pulses are left out."""


def lowest_latched(probe: Probe, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Find the lowest N from which on all cells tried latch, (rows,); NaN if the highest does not.

    low, high: range of N that is tried, multiples of g, (rows,), NaN for none
    Runs go to their end, whatever the probe asks. The search goes down from the highest N, which
    must latch in the REPEATED_STEP, too, as ringing beams may do so by chance.
    """
    model, rows, settings, *_ = probe
    cells = rows.cells(model.device, 0.0, settings.horizon)
    steps = (cells.t_end / steps_and_seconds(model, cells, settings)[0])[:, 0]
    N = amplitudes(np.where(steps <= RUN_STEPS, low, np.nan), high, LATCHED_STEP)
    size = np.count_nonzero(np.isfinite(N), axis=1)
    every = np.arange(len(N))

    def leaves(model, which, below):
        """Tell whether cells some places below the highest do not latch, (rows, n)."""
        # A model may need N ascending; the lowest stands for places below it.
        places = np.maximum(size[which, np.newaxis] - 1 - below, 0)[:, ::-1]
        ascending = N[which[:, np.newaxis], places]
        cells = rows.take(which).cells(model.device, ascending, settings.horizon)
        runs = model.follow(cells, settings)
        return (label(runs, settings.energy_tolerance) != LATCHED)[:, ::-1]

    highest = walk(partial(leaves, model.with_step(REPEATED_STEP)), every, 0, np.minimum(size, 1))
    down = walk(partial(leaves, model), every, 0, highest * size)
    return np.where(down > 0, N[every, size - np.maximum(down, 1)], np.nan)

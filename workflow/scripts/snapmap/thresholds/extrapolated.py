"""Thresholds of slow smooth pulses, taken to the limits of short steps and many modes."""

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.search import asker, refine
from ..solver.settings import Settings

CLOSE = 3e-5
"""A tolerance below which thresholds are extrapolated, where they can be."""
SLOWEST = 0.08
"""Frequency of a pulse over the device's own up to which errors go with powers of step and modes.
"""
EXACT = 1e-6
"""Tolerance of each threshold that is extrapolated from."""
SHOWN = 0.2
"""How far from 2, over 2, the ratio may be of what two lengthenings of the step, each by the root
of 2, move: an order of two; moves of less than 3 EXACT show nothing, and matter as little."""
LEFT = 0.25
"""Of all that extrapolation moves, what it may leave; docs/thresholds.md."""


def extrapolate(
    models: Survey, rows: Rows, settings: Settings, N_first: np.ndarray, N_error: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Take thresholds of `auto`, (rows,), to the limits where they are shown to go there.

    Of step h, N = N0 + a h^2, by three steps of five cosines; of M cosines, N = N0 + b/M^4.
    Returns N and its error; those given where that is not shown.
    """
    device = models.decides.device
    swings, smooth = np.array([(one.swings, one.is_smooth) for one in rows.pulses])[rows.pulse].T
    slow = 2e-6 * np.pi * rows.f0 * swings <= SLOWEST * device.own_frequency[rows.device]
    which = np.flatnonzero(slow & (smooth > 0) & np.isfinite(N_first))
    part, bar = rows.take(which), N_error[which]

    def exactly(model):
        ends = N_first[which] - bar, N_first[which] + bar
        return refine(asker(model, part, settings), *ends, EXACT)[1]

    few, many = (_modes(model, part.device) for model in (models.decides, models.judge))
    steps = (models.decides.with_step(factor) for factor in (1.0, np.sqrt(2.0), 2.0))
    N, longer, longest = map(exactly, steps)
    by_step, by_modes = N - longer, (exactly(models.judge) - N) * many**4 / (many**4 - few**4)
    second_order = abs(longer - longest - 2 * by_step) <= 2 * SHOWN * abs(by_step)
    shown = second_order | (abs(longer - longest) <= 3 * EXACT * N)
    shown &= np.isfinite(longest + by_modes)
    new, error = N_first.copy(), N_error.copy()
    new[which[shown]] = (N + by_step + by_modes)[shown]
    left = LEFT * (abs(by_step) + abs(by_modes)) + 4 * EXACT * N
    error[which[shown]] = left[shown]
    return new, error


def _modes(model, device):
    """How many modes each device of the batch has."""
    modes = np.empty(device.size)
    for mine, part in model.split(device):
        modes[mine] = part.modes
    return modes

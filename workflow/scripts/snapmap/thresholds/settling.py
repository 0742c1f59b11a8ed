"""Above which amplitude a device stays latched."""

import numpy as np

from ..solver.bracket import amplitudes
from ..solver.cells import Rows, to_cells
from ..solver.cost import steps_and_seconds
from ..solver.model import Follows
from ..solver.outcome import LATCHED, label
from ..solver.settings import Settings

STEP = 0.01
"""Relative distance of the amplitudes that are followed to their end."""
TOGETHER = 8
MOST_STEPS = 2e6
"""Of a run to its end: rows of slower pulses are left out."""


def lowest_latched(
    model: Follows, rows: Rows, low: np.ndarray, high: np.ndarray, settings: Settings
) -> np.ndarray:
    """Find the lowest N above which every cell seen latches, (rows,); NaN if the highest does not.

    low, high: amplitudes from and to which cells are looked at, multiples of g, (rows,); NaN for
        none. From the highest down, as far as all latch.
    """
    columns = rows.device, 0.0, rows.f0, rows.C, settings.horizon, rows.pulse
    cells = to_cells(model.device, *columns)
    lasts = cells.t_end / steps_and_seconds(model, cells, settings)[0]
    N = amplitudes(np.where(lasts <= MOST_STEPS, low, np.nan), high, STEP)
    found = np.full(len(N), np.nan)
    last = np.count_nonzero(np.isfinite(N), axis=1)
    left = np.flatnonzero(last > 0)
    while left.size:
        places = last[left, np.newaxis] - np.arange(1, TOGETHER + 1)
        chosen = N[left[:, np.newaxis], np.maximum(places, 0)]
        latched = _latched(model, rows.some(left), chosen, settings)
        # Places before the first are none; they end the row like a cell that does not latch.
        latched &= places >= 0
        count = np.where(latched.all(axis=1), TOGETHER, np.argmin(latched, axis=1))
        last[left] -= count
        some = count > 0
        found[left[some]] = N[left[some], last[left[some]]]
        left = left[count == TOGETHER]
    return found


def _latched(model, rows, N, settings):
    """Whether cells, (rows, n), are proven to stay in the second shape."""
    device, f0, C, pulse = (column[:, np.newaxis] for column in rows)
    order = np.argsort(N, axis=1)  # a model may ask for rows of ascending amplitude
    ascending = np.take_along_axis(N, order, axis=1)
    cells = to_cells(model.device, device, ascending, f0, C, settings.horizon, pulse)
    seen = model.follow(cells, settings)
    outcome = label(*seen[:4], settings.energy_tolerance)
    latched = np.empty(N.shape, bool)
    np.put_along_axis(latched, order, outcome == LATCHED, axis=1)
    return latched

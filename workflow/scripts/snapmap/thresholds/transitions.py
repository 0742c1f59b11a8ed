"""Changes of label along N, row by row: where to look for them, and how they are read."""

from typing import NamedTuple

import numpy as np

from .search import Edges, amplitudes

FINE_STEP = 0.005
"""Relative distance of the amplitudes between which islands are looked for."""
FINEST_STEP, CLOSEST_STEP = 0.001, 0.00025
"""Relative steps in ragged rows, where labels change back and forth, and to see which rows are."""
BESIDE, FAR_BESIDE = 1.02, 1.05
"""How far around the changes seen so far is looked closely, in clean and ragged rows."""
SCAN_STEPS = 400
"""A row's scan in finer steps takes no more of them, unless they are as wide as FINE_STEP."""


class Window(NamedTuple):
    """Where each row is scanned, (rows,): from low to high, in multiples of g, in relative steps.

    A row whose ends are NaN is not scanned.
    """

    low: np.ndarray
    high: np.ndarray
    step: np.ndarray

    @property
    def N(self) -> np.ndarray:
        """Amplitudes of the scan, (rows, n); NaN after a row's last."""
        return amplitudes(*self)


def around(
    limits: Window, first: np.ndarray, last: np.ndarray, beside: float, step: float | np.ndarray
) -> Window:
    """Make a window that reaches `beside` times beyond two N of each row, within limits.

    step: relative; wider where it would take more than SCAN_STEPS
    """
    low, high = np.maximum(limits.low, first / beside), np.minimum(limits.high, last * beside)
    return Window(low, high, np.clip((high / low - 1) / SCAN_STEPS, step, FINE_STEP))


def chosen(rows: np.ndarray, those: Window, others: Window) -> Window:
    """Take one window where `rows`, (rows,), is true, and another elsewhere."""
    return Window(*(np.where(rows, a, b) for a, b in zip(those, others, strict=True)))


def outermost(row: np.ndarray, N: np.ndarray, n_rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the least and the largest N of each row, (n_rows,); NaN where there is none."""
    least, largest = np.full((2, n_rows), np.nan)
    np.fmin.at(least, row, N)
    np.fmax.at(largest, row, N)
    return least, largest


def stretches(edges: Edges, open_end: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Read N_first and N_always, (rows,), and the islands' ends, (2, rows, most), off the edges.

    open_end: whether a row's highest N does not snap, so that nothing always does; (rows,)
    """
    n_rows = open_end.size
    row, starts = edges.row[edges.rising], edges.high[edges.rising]
    N_first, N_always = outermost(row, starts, n_rows)
    ends_row, ends = edges.row[~edges.rising], edges.low[~edges.rising]
    most = np.bincount(ends_row, minlength=1).max()
    islands = np.full((2, n_rows, most), np.nan)
    for i in np.unique(ends_row):
        to = np.sort(ends[ends_row == i])
        islands[0, i, : to.size] = np.sort(starts[row == i])[: to.size]
        islands[1, i, : to.size] = to
    return N_first, np.where(open_end, np.nan, N_always), islands

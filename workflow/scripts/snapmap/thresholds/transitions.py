"""Changes of label along N, row by row: found on scans, refined, and read as islands."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..solver.bracket import amplitudes, refine

FINE_STEP = 0.005
"""Relative distance of the amplitudes between which islands are looked for."""
MOST_STEPS = 400
"""A row's scan in finer steps takes no more of them, unless they are as wide as FINE_STEP."""


class Window(NamedTuple):
    """Where each row is scanned, (rows,): from low to high, in multiples of g, in relative steps.

    A row whose ends are NaN is not scanned.
    """

    low: np.ndarray
    high: np.ndarray
    step: np.ndarray


class Edges(NamedTuple):
    """Changes between what snaps and what does not along N; each lies between low and high.

    row: which row; rising: whether it is high that snaps
    """

    row: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rising: np.ndarray


def scan(ask: Callable, window: Window) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges in each row's window, and whether its first and last amplitude snap, (rows,).

    ask: gives t_snap of N, (rows, n); not finite for none
    """
    N = amplitudes(*window)
    snapped, known = np.isfinite(ask(N)), np.isfinite(N)
    row, k = np.nonzero((snapped[:, 1:] != snapped[:, :-1]) & known[:, 1:])
    last = np.maximum(np.count_nonzero(known, axis=1) - 1, 0)
    edges = Edges(row, N[row, k], N[row, k + 1], snapped[row, k + 1])
    return edges, snapped[:, 0], snapped[np.arange(len(N)), last]


def around(
    whole: Window, first: np.ndarray, last: np.ndarray, beside: float, step: float | np.ndarray
) -> Window:
    """Make a window that reaches `beside` times beyond two N of each row, within the whole.

    step: relative; wider where it would take more than MOST_STEPS
    """
    low, high = np.maximum(whole.low, first / beside), np.minimum(whole.high, last * beside)
    return Window(low, high, np.clip((high / low - 1) / MOST_STEPS, step, FINE_STEP))


def chosen(rows: np.ndarray, those: Window, others: Window) -> Window:
    """Take one window where `rows`, (rows,), is true, and another elsewhere."""
    return Window(*(np.where(rows, a, b) for a, b in zip(those, others, strict=True)))


def outermost(row: np.ndarray, N: np.ndarray, n_rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the least and the largest N of each row, (n_rows,); NaN where there is none."""
    least, largest = np.full((2, n_rows), np.nan)
    np.fmin.at(least, row, N)
    np.fmax.at(largest, row, N)
    return least, largest


def refine_edges(ask_rows: Callable, edges: Edges, tolerance: float) -> Edges:
    """Narrow every edge to a relative tolerance; ask_rows(rows) is the `ask` of `scan` for some."""
    found = np.array([edges.low, edges.high])
    for rising in (True, False):
        some = np.flatnonzero(edges.rising == rising)
        ask = ask_rows(edges.row[some])
        told = ask if rising else lambda N, ask=ask: np.where(np.isfinite(ask(N)), np.nan, 0.0)
        found[:, some] = refine(told, *found[:, some], tolerance)
    return edges._replace(low=found[0], high=found[1])


def stretches(edges: Edges, open_end: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Read the edges: N_first and N_always, (rows,), and the islands' ends, (2, rows, most).

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


def balance(edges: Edges, n_rows: int) -> np.ndarray:
    """Sum of the rising less that of the falling edges, (n_rows,).

    Of a row that begins quiet and ends snapping: where as much snaps below as does not above.
    """
    return np.bincount(edges.row, np.where(edges.rising, edges.high, -edges.high), n_rows)

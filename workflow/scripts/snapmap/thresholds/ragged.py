"""Ragged rows, whose labels change back and forth: all changes of all models, and their ends."""

from collections.abc import Sequence

import numpy as np

from .edges import Edges, Seen, Window, around, joined, nothing_seen, outermost, scan_on
from .probe import Ask, Probe, refine

CLEAN_REACH, RAGGED_REACH = 1.02, 1.05
"""Factors on N up to which the deciding model looks around changes, in clean and ragged rows."""


def scan_ragged(
    ask: Ask, others: Sequence[Ask], window: Window, lowest: np.ndarray, seen: Seen
) -> tuple[Seen, np.ndarray]:
    """Find all edges in a window of which a part was seen, and where other models begin to snap.

    others: of the other models, which scan the window in twice the step
    lowest: N to which the window may grow, (rows,): it goes on to RAGGED_REACH below all changes
    The deciding model looks within CLEAN_REACH of all changes of any model, and on to the lower end
    of the window while it snaps there, or to the upper end while it does not.
    Returns what was seen, and N at which each other model begins to snap, (others, rows).
    """
    scans = [nothing_seen(window.low.size)] * len(others)
    while True:
        coarse = window._replace(step=2 * window.step)
        scans = [scan_on(other, coarse, part) for other, part in zip(others, scans, strict=True)]
        edges = joined(seen.edges, *(part.edges for part in scans))
        ends = outermost(edges.row, edges.high, window.low.size)
        begins = np.any([part.begins for part in scans], axis=0)
        first = np.where(begins, window.low, ends[0])
        lower = np.fmin(window.low, np.maximum(lowest, first / RAGGED_REACH))
        ends = (np.where(np.isnan(a), b, a) for a, b in zip(ends, window[:2], strict=True))
        near = around(window, *ends, CLEAN_REACH, window.step)
        new = np.isnan(seen.low)
        low = np.where(seen.begins, window.low, near.low)
        high = np.where(seen.ends | new, near.high, window.high)
        left = np.isfinite(low) & (new | (low < seen.low) | (high > seen.high))
        grows = lower < window.low
        if not (left | grows).any():
            break
        seen = scan_on(ask, near._replace(low=low, high=high).of(left), seen)
        window = window._replace(low=lower)
    firsts = np.array([begins_at(part.edges, part.begins, window) for part in scans])
    return seen._replace(edges=seen.edges.take(~seen.begins[seen.edges.row])), firsts


def begins_at(edges: Edges, begins: np.ndarray, window: Window) -> np.ndarray:
    """Give N at which a scan begins to snap, (rows,), or the end of the window on that side.

    begins: as in `Seen`
    """
    first, _ = outermost(edges.row[edges.rising], edges.high[edges.rising], begins.size)
    return np.where(begins, window.low, np.where(np.isnan(first), window.high, first))


def refine_edges(probe: Probe, edges: Edges, which: np.ndarray, tolerance: float) -> Edges:
    """Refine the edges of some rows to a relative tolerance; which: a mask of rows, (rows,)."""
    part, others = edges.take(which[edges.row]), edges.take(~which[edges.row])
    row, *ends, rising = part
    ends = refine(probe.take(row), *ends, tolerance, rising)
    return joined(others, Edges(row, *ends, rising))

"""Labels close to a threshold, known by how near runs come to a snap, or by a scan.

Below a threshold that stands alone, each run comes nearer to a snap than those at lower N; above
it, each snaps the later, the closer N lies to it. A stretch of the other label bends this far
beyond its own ends: near it, too, runs come close to the saddle, and dwell there.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import Settings
from .lattice import nearby
from .search import Edges, asker, edges_of, joined, observer, refine
from .transitions import CLOSEST_STEP

STEPS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80])
"""Distances from a threshold, up to BESIDE, in CLOSEST_STEP, at which runs are looked at."""
NEAREST = 24
"""Up to which of them another model must show no other below a clean threshold: 0.6 %."""
BESIDE_OPEN = 2
"""Intervals of STEPS on either side of one in which runs do not come nearer that are scanned too.
So no stretch wider than 0.06 % was missed beside 414 thresholds of random devices, a third of them
ragged; docs/thresholds.md, "Width of islands"."""
BELOW, ABOVE = -1, 1


class Close(NamedTuple):
    """What was seen close to edges: the edges there, and the labels of the ends, as `edges_of`.

    low, high: these ends, in multiples of g, (rows,); NaN where nothing was looked at
    """

    edges: Edges
    begins: np.ndarray
    ends: np.ndarray
    low: np.ndarray
    high: np.ndarray


def edges_about(
    models: Survey,
    rows: Rows,
    settings: Settings,
    tolerance: float,
    rings: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> Close:
    """Find the edges close to one that the model `looks` sees: refined, if it is alone.

    low, high: the edge, (rows,); NaN for rows that are not looked at
    rings: rows in which there may be others, (rows,)
    Where another model decides, it is that one's, unless that sees none near, or other labels: then
    the row begins snapping.
    """

    def close(model, low, high, sides, farthest):
        ends = (np.where(rings, end, np.nan) for end in (low, high))
        edges, begins, ends = close_edges(model, rows, settings, *ends, sides, farthest)
        others = np.flatnonzero(~rings & np.isfinite(high))
        ends[others] = True
        rising = np.ones(others.size, bool)
        return joined(edges, Edges(others, low[others], high[others], rising)), begins, ends

    looks, decides = models.looks, models.decides
    low, high = refine(asker(looks, rows, settings), low, high, models.rough(tolerance))
    edges, begins, ends = close(looks, low, high, (BELOW, ABOVE), STEPS[-1])
    reach = [
        np.where(rings, _beside(low, high, side, STEPS[-1]), end)
        for side, end in ((BELOW, low), (ABOVE, high))
    ]
    if looks is decides:
        return Close(edges, begins, ends, *reach)
    alone = ~begins & (np.bincount(edges.row, minlength=high.size) == 1)
    sides = nearby(decides, rows, settings, np.where(alone, high, np.nan), tolerance)
    exact, begins_exact, _ = close(decides, *sides, [BELOW], NEAREST)
    decided = np.isfinite(sides[1]) & ~begins_exact
    edges = joined(edges.take(~decided[edges.row]), exact.take(decided[exact.row]))
    return Close(edges, begins | (alone & ~decided), ends, *reach)


def close_edges(
    model: Follows,
    rows: Rows,
    settings: Settings,
    low: np.ndarray,
    high: np.ndarray,
    sides: Sequence[int] = (BELOW, ABOVE),
    farthest: int = STEPS[-1],
) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges close to one, as on a scan in CLOSEST_STEP, by fewer runs.

    low, high: the edge, refined, (rows,); NaN for rows that are not looked at
    sides: on which it is looked; farthest: of STEPS
    Where runs at STEPS show other labels, FINEST_STEP suffices.
    """
    observe, ask = observer(model, rows, settings), asker(model, rows, settings)
    steps = STEPS[farthest >= STEPS]
    between = np.setdiff1d(np.arange(farthest), steps)[1:]
    inside = np.searchsorted(steps, between) - 1
    runs = [observe(_beside(low, high, side, steps)) for side in sides]
    others = [np.isfinite(run.t_snap) == (side < 0) for side, run in zip(sides, runs, strict=True)]
    mixed = np.any(np.hstack(others), axis=1)[:, np.newaxis]
    known = [low[:, np.newaxis], high[:, np.newaxis]]
    t_snap = [np.full((low.size, 1), np.nan), np.zeros((low.size, 1))]
    for side, run in zip(sides, runs, strict=True):
        nearer = -run.lowest if side < 0 else run.t_snap
        wanted = _open(nearer)[:, inside] & (~mixed | (between % 4 == 0))
        N = np.where(wanted, _beside(low, high, side, between), np.nan)
        known += _beside(low, high, side, steps), N
        t_snap += run.t_snap, ask(N)
    N, t_snap = np.hstack(known), np.hstack(t_snap)
    order = np.argsort(N, axis=1)
    return edges_of(*(np.take_along_axis(a, order, axis=1) for a in (N, t_snap)))


def _beside(low, high, side, steps):
    """Place N so many steps below or above an edge, (rows, steps)."""
    return np.multiply.outer(low if side < 0 else high, 1 + CLOSEST_STEP * side * steps)


def _open(nearer):
    """Intervals of steps in which, or close to which, values do not fall outward, (rows, n)."""
    with np.errstate(invalid="ignore"):
        rises = ~(nearer[:, 1:] < nearer[:, :-1])
    padded = np.pad(rises, ((0, 0), (BESIDE_OPEN, BESIDE_OPEN)))
    shifts = range(2 * BESIDE_OPEN + 1)
    return np.any([padded[:, i : i + rises.shape[1]] for i in shifts], axis=0)

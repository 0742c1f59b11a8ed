"""Labels close to a threshold, known by how near runs come to a snap, or by a scan.

Below a threshold that stands alone, each run comes nearer to a snap than those at lower N; above
it, each snaps the later, the closer N lies to it. A stretch of the other label bends this far
beyond its own ends: near it, too, runs come close to the saddle, and dwell there.
"""

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.search import Edges, asker, edges_of, observer
from ..solver.settings import Settings
from .transitions import CLOSEST_STEP

STEPS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80])
"""Distances from a threshold, up to BESIDE, in CLOSEST_STEP, at which runs are looked at."""
BETWEEN = np.setdiff1d(np.arange(STEPS[-1]), STEPS)[1:]
"""All others."""
BESIDE_OPEN = 2
"""Intervals of STEPS on either side of one in which runs do not come nearer that are scanned too.
So no stretch wider than 0.06 % was missed beside 414 thresholds of random devices, a third of them
ragged; docs/thresholds.md, "Width of islands"."""


def close_edges(
    model: Follows, rows: Rows, settings: Settings, low: np.ndarray, high: np.ndarray
) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges within BESIDE of one, as on a scan in CLOSEST_STEP, by fewer runs.

    low, high: the edge, refined, (rows,); NaN for rows that are not looked at
    Where runs at STEPS show other labels, FINEST_STEP suffices.
    """
    observe, ask = observer(model, rows, settings), asker(model, rows, settings)
    near, far = _about(low, high, STEPS)
    below, above = observe(near), observe(far)
    mixed = ~(np.isnan(below.t_snap) & np.isfinite(above.t_snap)).all(axis=1)
    known = [near, low[:, np.newaxis], high[:, np.newaxis], far]
    t_snap = [below.t_snap, np.full((low.size, 1), np.nan), np.zeros((low.size, 1)), above.t_snap]
    inside = np.searchsorted(STEPS, BETWEEN) - 1
    for nearer, N in zip((-below.lowest, above.t_snap), _about(low, high, BETWEEN), strict=True):
        wanted = _open(nearer)[:, inside] & (~mixed[:, np.newaxis] | (BETWEEN % 4 == 0))
        known.append(np.where(wanted, N, np.nan))
        t_snap.append(ask(known[-1]))
    N, t_snap = np.hstack(known), np.hstack(t_snap)
    order = np.argsort(N, axis=1)
    return edges_of(*(np.take_along_axis(a, order, axis=1) for a in (N, t_snap)))


def _about(low, high, steps):
    """N so many steps below and above an edge, (rows, steps)."""
    below, above = (1 + CLOSEST_STEP * sign * steps for sign in (-1, 1))
    return np.multiply.outer(low, below), np.multiply.outer(high, above)


def _open(nearer):
    """Intervals of STEPS in which, or close to which, values do not fall outward, (rows, n)."""
    rises = ~falls(nearer)
    padded = np.pad(rises, ((0, 0), (BESIDE_OPEN, BESIDE_OPEN)))
    shifts = range(2 * BESIDE_OPEN + 1)
    return np.any([padded[:, i : i + rises.shape[1]] for i in shifts], axis=0)


def falls(values: np.ndarray) -> np.ndarray:
    """Whether each value of rows lies below the one before, (rows, n - 1); NaN does not."""
    with np.errstate(invalid="ignore"):
        return values[:, 1:] < values[:, :-1]

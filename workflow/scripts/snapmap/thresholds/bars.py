"""Error bars of thresholds, by other time steps and models."""

import numpy as np

from .edges import outermost, scan
from .effort import CLOSE_PLACES, CLOSE_STEP, ISLAND_STEP, RAGGED_STEP
from .probe import Ask
from .ragged import CLEAN_REACH, begins_at
from .search import Changes, Search, close_edges

OPEN_BAR = 10 * RAGGED_STEP
"""Largest relative bar of a ragged row whose changes are refined. Also how far below a clean
threshold the finest model is asked for islands."""
AGREEMENTS = 4
"""Number of successive distances at which another model must see a threshold in between."""
MAX_DISTANCE = 0.25
"""Relative distance within which another model's threshold is sought; a row without is ragged."""


def make_bars(search: Search, changes: Changes) -> tuple[np.ndarray, np.ndarray]:
    """Compare thresholds with those of another time step and of other models.

    Returns the error of N_first, multiples of g, and whether a row is ragged, as its labels change
    back and forth or as models differ by far; (rows,).
    """
    models, rings, tolerance = search.models, search.rings, search.tolerance
    N_first, ragged = changes.N_first, changes.ragged
    clean = np.where(ragged, np.nan, N_first)
    near = _clean_bars(search, clean)
    if models.finest is not None:
        # An island that finer time steps open below the threshold belongs to the bar.
        high = np.where(rings, clean, np.nan)
        low = (1 - tolerance) * high
        close = close_edges(search.probe(models.finest), low, high, (-1,), OPEN_BAR).edges
        islands = close.take(close.high < low[close.row])
        near = np.fmax(near, N_first - outermost(islands.row, islands.low, low.size)[0])
    apart = np.isinf(near)
    window = changes.limits.of(apart)
    scans = [scan(search.probe(each, "snap"), window.N) for each in search.others_of_ragged]
    firsts = [begins_at(edges, begins, window) for edges, begins, _ in scans]
    firsts = np.where(apart, firsts, changes.firsts)
    far = np.fmax(_spread(changes.edges, N_first), np.max(abs(N_first - firsts), axis=0))
    step = np.where(ragged, RAGGED_STEP, np.where(rings, CLOSE_STEP * CLOSE_PLACES[0], 0.0))
    step = np.where(apart, ISLAND_STEP, step)
    ragged = ragged | apart
    return np.where(ragged, far, near) + (step + tolerance) * N_first, ragged


def _clean_bars(search, N_first):
    """Add up the distances of clean thresholds in time step and model, (rows,)."""
    probes = map(search.probe, search.others)
    in_time, *in_space = [distance(probe, N_first, search.tolerance) for probe in probes]
    # The second of `models.others`, the better one, may itself be off by as much.
    return in_time + np.max(in_space, axis=0) + sum(in_space[1 : len(search.models.others)])


def _spread(edges, N_first):
    """Give the distance from N_first up to the last change within CLEAN_REACH above it, (rows,)."""
    spread = np.zeros(N_first.size)
    above = edges.low - N_first[edges.row]
    close = edges.high <= CLEAN_REACH * N_first[edges.row]
    np.fmax.at(spread, edges.row[close], above[close])
    return spread


def distance(ask: Ask, N_first: np.ndarray, tolerance: float) -> np.ndarray:
    """Find the distance from N_first within which another model's threshold lies, (rows,).

    ask: of the other model; tolerance: relative, a quarter of which is the first distance tried
    At that distance and the next AGREEMENTS - 1 doublings the model does not snap below and snaps
    above: where labels change back and forth, agreement at a single distance is luck. The distance
    is known to an eighth; it is infinite beyond MAX_DISTANCE, and NaN where N_first is.
    """

    def differ(which, reaches):
        """Tell whether labels at relative distances, (n, m), are not those around a threshold."""
        N = np.full((N_first.size, 2 * reaches.shape[1]), np.nan)
        N[which] = N_first[which, np.newaxis] * np.hstack([1 - reaches, 1 + reaches])
        below, above = np.hsplit(np.isfinite(ask(N))[which], 2)
        return below | ~above

    distances = np.where(np.isnan(N_first), np.nan, np.inf)
    reach = np.full(N_first.size, tolerance / 4)
    while (left := np.flatnonzero(np.isinf(distances) & (reach < MAX_DISTANCE))).size:
        doubled = np.ldexp(reach[left, np.newaxis], np.arange(AGREEMENTS))
        other = differ(left, np.minimum(doubled, MAX_DISTANCE))
        passed = np.where(other.any(axis=1), AGREEMENTS - np.argmax(other[:, ::-1], axis=1), 0)
        distances[left[passed == 0]] = (reach * N_first)[left[passed == 0]]
        reach[left] = np.ldexp(reach[left], passed)
    near = np.flatnonzero(np.isfinite(distances))
    same = ~differ(near, np.multiply.outer(reach[near], [7 / 8, 6 / 8, 5 / 8]))
    distances[near] *= 1 - np.logical_and.accumulate(same, axis=1).sum(axis=1) / 8
    return distances

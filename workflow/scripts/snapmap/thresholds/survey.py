"""Thresholds of rows, each searched by the models that it needs; their error bars; the time."""

from typing import NamedTuple

import numpy as np

from ..solver.cost import OF_THRESHOLD, steps_and_seconds, tell
from .edges import outermost, scan, stretches
from .effort import CLOSE_PLACES, CLOSE_STEP, ISLAND_STEP, RAGGED_STEP
from .probe import Ask, Probe
from .ragged import CLEAN_REACH, begins_at, refine_edges
from .search import Changes, Search, close_edges, find_changes, is_fast

OPEN_BAR = 10 * RAGGED_STEP
"""Largest relative bar of a ragged row whose changes are refined. Also how far below a clean
threshold the finest model is asked for islands."""
DOUBLINGS, EIGHTHS = np.array([1.0, 2.0, 4.0, 8.0]), np.array([7, 6, 5]) / 8
"""Distances, over the first that is tried, at all of which another model must see a threshold in
between; and shorter ones, to which a distance is known."""
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
    At all DOUBLINGS of that distance the model does not snap below and snaps above: where labels
    change back and forth, agreement at a single distance is luck. The distance is known to an
    eighth; it is infinite beyond MAX_DISTANCE, and NaN where N_first is.
    """
    distances = np.where(np.isnan(N_first), np.nan, np.inf)
    reach, steps = np.full(N_first.size, tolerance / 4), np.r_[DOUBLINGS, EIGHTHS]
    while (left := np.flatnonzero(np.isinf(distances) & (reach < MAX_DISTANCE))).size:
        tried = np.minimum(np.multiply.outer(reach[left], steps), MAX_DISTANCE)
        N = np.full((N_first.size, 2 * steps.size), np.nan)
        N[left] = N_first[left, np.newaxis] * np.hstack([1 - tried, 1 + tried])
        below, above = np.hsplit(np.isfinite(ask(N))[left], 2)
        other, inner = np.hsplit(below | ~above, [DOUBLINGS.size])
        passed = np.where(other.any(axis=1), other.shape[1] - np.argmax(other[:, ::-1], axis=1), 0)
        eighths = np.logical_and.accumulate(~inner, axis=1).sum(axis=1) / 8
        distances[left] = np.where(passed > 0, np.inf, reach[left] * N_first[left] * (1 - eighths))
        reach[left] = np.ldexp(reach[left], passed)
    return distances


STATUS = "no_device", "found", "nothing_snaps", "not_followed"
"""Whether a row has a threshold, and if not, why: nothing snaps up to the highest N tried, or runs
fail, as those of a pulse too short for any time step, or those just below the first snap."""
NO_DEVICE, FOUND, NOTHING_SNAPS, NOT_FOLLOWED = range(len(STATUS))


class Thresholds(NamedTuple):
    """Thresholds of rows, each (rows,), in multiples of g; NaN where there is none.

    status: index into STATUS
    N_bound: N below which nothing can snap, by energy
    N_looked: the highest N tried
    N_first: the lowest N seen to snap, a place of the search's lattice; stretches that snap below
        its bar are no wider than docs/thresholds.md, "Width of islands", says
    N_error: error of N_first, from other models, another time step and the refinement
    ragged: 1 where labels change back and forth, or models differ by far, else 0
    N_always: the lowest N from which on every N tried snaps
    t_snap: time of the snap at N_first after the pulse's start, us
    level: number of finer levels that took over, for a fast pulse or as the bar was too wide
    islands: number of separate stretches of N below N_always that snap
    island_from, island_to: their ends, (rows, most islands), NaN where a row has fewer
    """

    status: np.ndarray
    N_bound: np.ndarray
    N_looked: np.ndarray
    N_first: np.ndarray
    N_error: np.ndarray
    ragged: np.ndarray
    N_always: np.ndarray
    t_snap: np.ndarray
    level: np.ndarray
    islands: np.ndarray
    island_from: np.ndarray
    island_to: np.ndarray


def survey(search: Search) -> Thresholds:
    """Find thresholds.

    Finer models take fast pulses, and clean rows whose bar exceeds the models' tolerance.
    """
    models = search.models
    if models.finer is None:
        return _survey_level(search)
    is_fine, thresholds = is_fast(models.decides.device, search.rows), None
    coarse = np.flatnonzero(~is_fine)
    if coarse.size or not is_fine.size:
        new = _survey_level(search.take(coarse))
        unsure = (new.ragged == 0) & (new.N_error > models.tolerance * new.N_first)
        is_fine[coarse[unsure]] = True
        thresholds = _merged(is_fine.size, None, coarse, new)
    if is_fine.any():
        new = survey(search.take(is_fine)._replace(models=models.finer))
        new = new._replace(level=new.level + 1)
        thresholds = _merged(is_fine.size, thresholds, np.flatnonzero(is_fine), new)
    return thresholds


def lowest(search: Search) -> np.ndarray:
    """Find N_first of rows, (rows,), without error bars; NaN where nothing snaps."""
    if not search.rows.f0.size:
        return np.empty(0)
    # With `highest` = 0, islands far above the first N that snaps do not count.
    changes = find_changes(search._replace(highest=0.0))
    edges, n_rows = changes.edges.take(changes.edges.rising), changes.ragged.size
    first, _ = outermost(edges.row, edges.high, n_rows)
    edges = edges.take(edges.high == first[edges.row])
    decides = search.probe(search.models.ragged)
    edges = refine_edges(decides, edges, changes.ragged, search.tolerance)
    return outermost(edges.row, edges.high, n_rows)[0]


def _survey_level(search):
    """Find thresholds by one level; the deciding model scans rows in which the cheap one fails."""
    thresholds, models = _search_once(search), search.models
    lost = np.flatnonzero(thresholds.status == NOT_FOLLOWED)
    if lost.size:
        by_better = models._replace(scans=models.decides)
        new = _search_once(search.take(lost)._replace(models=by_better, from_bound=True))
        thresholds = _merged(thresholds.status.size, thresholds, lost, new)
    return thresholds


def _search_once(search):
    """Find thresholds of rows by the five steps."""
    changes = find_changes(search)
    N_error, ragged = make_bars(search, changes)
    decides, of_ragged = map(search.probe, (search.models.decides, search.models.ragged))
    refined = changes.ragged & (N_error <= OPEN_BAR * changes.N_first)
    edges = refine_edges(of_ragged, changes.edges, refined, search.tolerance)
    N_first, N_always, islands = stretches(edges, changes.is_open)
    if search.highest is not None:
        N_always = np.where(N_always <= search.highest, N_always, np.nan)
    first = edges.take(edges.rising & (edges.high == N_first[edges.row]))
    below, scanned = outermost(first.row, first.low, N_first.size)[1], changes.ragged[:, np.newaxis]
    clean_N, ragged_N = np.where([~scanned, scanned], np.column_stack([N_first, below]), np.nan)
    t_snap, t_below = np.fmax(decides(clean_N), of_ragged(ragged_N)).T
    hidden, found = np.isneginf(t_below), [N_first, N_error, N_always, t_snap]
    # A failed run below the first snap may hide the threshold.
    N_first, N_error, N_always, t_snap = np.where(hidden, np.nan, found)
    islands = np.where(hidden[:, np.newaxis], np.nan, islands)
    reason = np.where(changes.quiet, NOTHING_SNAPS, NOT_FOLLOWED)
    return Thresholds(
        status=np.where(np.isnan(N_first), reason, FOUND).astype(np.int8),
        N_bound=changes.bound,
        N_looked=changes.highest,
        N_first=N_first,
        N_error=N_error,
        ragged=(ragged & ~hidden).astype(np.int8),
        N_always=N_always,
        t_snap=t_snap,
        level=np.zeros(N_first.size, np.int8),
        islands=np.count_nonzero(np.isfinite(islands[0]), axis=1),
        island_from=islands[0],
        island_to=islands[1],
    )


def _merged(n_rows, old, which, new):
    """Put new thresholds, of the rows with these indices, into old ones, which may be None."""
    pairs = zip(old or [None] * len(new), new, strict=True)
    return Thresholds(*(with_rows(n_rows, which, values, before) for before, values in pairs))


def with_rows(
    n_rows: int, which: np.ndarray, new: np.ndarray, old: np.ndarray | None
) -> np.ndarray:
    """Put new values of some rows into a variable, (n_rows, ...).

    which: indices of the rows, (new,); old: (n_rows, ...), or None
    The last axis of new or old values may be shorter; it is filled with NaN or 0.
    """
    widest = max((part.shape[1:] for part in (new, old) if part is not None), key=np.prod)
    blank = np.nan if new.dtype.kind == "f" else 0
    values = np.full((n_rows, *widest), blank, new.dtype)
    if old is not None:
        values[(slice(None), *map(slice, old.shape[1:]))] = old
    values[which] = blank
    values[(which, *map(slice, new.shape[1:]))] = new
    return values


def run_seconds(probe: Probe) -> np.ndarray:
    """Estimate the core time of a run of each row, s, (rows,)."""
    model, rows, settings, until = probe
    cells = rows.cells(model.device, 0.0, settings.horizon)
    return steps_and_seconds(model, cells, settings.but(until=until))[1][:, 0]


def tell_cost(search: Search) -> None:
    """Warn of a long search, in one line; an endless one is refused with a ValueError."""
    if (f0 := search.rows.f0).size:
        seconds = OF_THRESHOLD * run_seconds(search.probe(search.models.decides))
        slowest, total = f"f0 = {f0[np.argmax(seconds)]:g} Hz", float(seconds.sum())
        cure = "write a higher f0 or a shorter horizon"
        tell("thresholds", total / search.settings.threads, slowest, cure)

"""The search for thresholds of rows: where snapping begins and is certain, with error bars.

The search has five steps:
1. The cheap model scans N upwards until a cell snaps (`first_seen`).
2. The cheap model scans a window about this N for islands (`find_islands`).
3. The deciding model locates the changes of label, and refines a single one (`decide`).
4. If the device rings, the deciding model looks closely beside that change (`look_closely`).
5. Another time step and other models give the error bar (`compare`).
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ..solver.adaptive import Survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Run
from .search import (
    SCAN_STEP,
    TOGETHER,
    Ask,
    Edges,
    Seen,
    Window,
    amplitudes,
    around,
    asker,
    edges_of,
    first_snap,
    joined,
    nothing_seen,
    observer,
    outermost,
    refine,
    scan,
    scan_on,
    stretches,
)

ISLANDS_FROM, ISLANDS_TO = 0.7, 2.0
"""Ends of the window that is scanned for islands, as multiples of the first N that snaps."""
ISLAND_STEP, RAGGED_STEP, CLOSE_STEP = 0.005, 0.001, 0.00025
"""Relative steps of N: in the scan for islands, in ragged rows (whose labels change back and
forth), and close to a threshold."""
CLEAN_REACH, RAGGED_REACH = 1.02, 1.05
"""Factors on N up to which the deciding model looks around changes, in clean and ragged rows."""
RINGING = 0.25
"""Least time of a device's response, over that of the pulse's steepest rise, with which the device
rings after the pulse; islands then lie close to its threshold."""
FAST_PULSE = 0.7
"""Least frequency of a pulse, over the device's own, at which the finer models take its rows."""
CLOSE_PLACES = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80])
"""Distances from a threshold at which runs are compared, in CLOSE_STEP; the last is CLEAN_REACH."""
OPEN_BAR = 10 * RAGGED_STEP
"""Largest relative bar of a ragged row whose changes are refined. Also how far below a clean
threshold the finest model is asked for islands."""
STEP_RATIO = math.sqrt(2.0)
"""Factor on the deciding time step, of the runs that show its error: as that is of second order,
it doubles, and the difference is the error itself."""
AGREEMENTS = 4
"""Number of successive distances at which another model must see a threshold in between."""
MAX_DISTANCE = 0.25
"""Relative distance within which another model's threshold is sought; a row without is ragged."""
SLACK = 0.99
"""Share of the bound by energy at which scans may begin, as a model may itself be off."""
STATUS = "no_device", "found", "nothing_snaps", "not_followed"
"""Whether a row has a threshold, and if not, why: nothing snaps up to the highest N tried, or runs
fail, as those of a pulse too short for any time step."""
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


class Changes(NamedTuple):
    """Where the deciding model changes its label; edges apart, arrays are (rows,).

    edges: the changes, refined in clean rows
    is_open: whether a ragged row does not snap at the highest N, and so has no N_always
    limits: window in which islands count
    ragged: whether labels change back and forth
    rings: whether the device rings after the pulse
    firsts: N at which each of the other models begins to snap in ragged rows, (others, rows)
    highest: the largest N tried
    quiet: whether all runs of the first scan succeeded without a snap
    """

    edges: Edges
    is_open: np.ndarray
    limits: Window
    ragged: np.ndarray
    rings: np.ndarray
    firsts: np.ndarray
    highest: np.ndarray
    quiet: np.ndarray


def survey(
    models: Survey,
    rows: Rows,
    settings: Run,
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
) -> Thresholds:
    """Find the thresholds of rows, to a relative tolerance.

    highest: largest N at which islands count; by default ISLANDS_TO times the threshold
    Finer models take fast pulses, and clean rows whose bar exceeds the models' tolerance.
    """
    options = settings, tolerance, highest
    if models.finer is None:
        return _survey_level(models, rows, *options)
    is_fine, thresholds = is_fast(models.decides.device, rows), None
    coarse = np.flatnonzero(~is_fine)
    if coarse.size or not is_fine.size:
        new = _survey_level(models, rows.take(coarse), *options)
        unsure = (new.ragged == 0) & (new.N_error > models.tolerance * new.N_first)
        is_fine[coarse[unsure]] = True
        thresholds = _merged(is_fine.size, None, coarse, new)
    if is_fine.any():
        new = survey(models.finer, rows.take(is_fine), *options)
        new = new._replace(level=new.level + 1)
        thresholds = _merged(is_fine.size, thresholds, np.flatnonzero(is_fine), new)
    return thresholds


def lowest(models: Survey, rows: Rows, settings: Run, tolerance: float) -> np.ndarray:
    """Find N_first of rows, (rows,), without error bars; NaN where nothing snaps."""
    if not rows.f0.size:
        return np.empty(0)
    bound = lower_bound(models, rows, settings)
    # With `highest` = 0, islands far above the first N that snaps do not count.
    changes = find_changes(models, rows, settings, tolerance, 0.0, bound)
    edges = changes.edges.take(changes.edges.rising)
    first, _ = outermost(edges.row, edges.high, bound.size)
    edges = edges.take(edges.high == first[edges.row])
    edges = refine_edges(models.ragged, rows, settings, tolerance, edges, changes.ragged)
    return outermost(edges.row, edges.high, bound.size)[0]


def _survey_level(models, rows, settings, tolerance, highest):
    """Find thresholds by one level; the deciding model scans rows in which the cheap one fails."""
    bound = lower_bound(models, rows, settings)
    options = settings, tolerance, highest
    thresholds = _search(models, rows, *options, bound)
    lost = np.flatnonzero(thresholds.status == NOT_FOLLOWED)
    if lost.size:
        better = models._replace(scans=models.decides)
        new = _search(better, rows.take(lost), *options, bound[lost], SLACK * bound[lost])
        thresholds = _merged(bound.size, thresholds, lost, new)
    return thresholds


def _search(models, rows, settings, tolerance, highest, bound, islands_from=None):
    """Find thresholds of rows by the five steps; bound, islands_from: as in `find_changes`."""
    changes = find_changes(models, rows, settings, tolerance, highest, bound, islands_from)
    N_first, *_ = stretches(changes.edges, changes.is_open)
    N_error, ragged = compare(models, rows, settings, tolerance, changes, N_first)
    refined = changes.ragged & (N_error <= OPEN_BAR * N_first)
    edges = refine_edges(models.ragged, rows, settings, tolerance, changes.edges, refined)
    N_first, N_always, islands = stretches(edges, changes.is_open)
    if highest is not None:
        N_always = np.where(N_always <= highest, N_always, np.nan)
    clean_N, ragged_N = np.where([~changes.ragged, changes.ragged], N_first, np.nan)
    t_snap = snap_times(models.decides, rows, settings, clean_N)
    t_snap = np.fmax(t_snap, snap_times(models.ragged, rows, settings, ragged_N))
    reason = np.where(changes.quiet, NOTHING_SNAPS, NOT_FOLLOWED)
    return Thresholds(
        status=np.where(np.isnan(N_first), reason, FOUND).astype(np.int8),
        N_bound=bound,
        N_looked=changes.highest,
        N_first=N_first,
        N_error=N_error,
        ragged=ragged.astype(np.int8),
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


def lower_bound(models: Survey, rows: Rows, settings: Run) -> np.ndarray:
    """Bound N that snap from below, (rows,): by energy, and by a small share of the static one."""
    bound = least_amplitudes(models.decides, rows, settings.start)
    return np.maximum(bound, 1e-4 * models.static[rows.device])


def find_changes(
    models: Survey,
    rows: Rows,
    settings: Run,
    tolerance: float,
    highest: float | None,
    bound: np.ndarray,
    islands_from: np.ndarray | None = None,
) -> Changes:
    """Find the changes of label of rows by the first four steps.

    highest: as in `survey`; bound: N below which nothing can snap, (rows,)
    islands_from: N from which on islands count, (rows,), instead of ISLANDS_FROM times the first
    """
    device = models.scans.device
    rings, slow = is_ringing(device, rows), ~is_ringing(device, rows, RINGING / 5)
    N = amplitudes(*scan_range(device, models.static, rows, bound, settings.start), SCAN_STEP)
    ask_cheap = asker(models.scans, rows, settings, until="snap")
    first, quiet = first_seen(ask_cheap, N, bound)
    limits = island_limits(first, islands_from, highest, slow)
    window, ragged = find_islands(ask_cheap, limits)
    look = partial(look_closely, models.decides, rows, settings, tolerance, rings)
    seen, clean = decide(asker(models.decides, rows, settings), look, window, ragged)
    ragged = np.isfinite(first) & ~clean
    window = around(limits, window.low, window.high, RAGGED_REACH, RAGGED_STEP).of(ragged)
    others = [asker(model, rows, settings, until="snap") for model in _ragged_others(models)]
    ask = asker(models.ragged, rows, settings)
    lowest = np.minimum(limits.low, SLACK * bound)
    scanned, firsts = scan_ragged(ask, others, window, lowest, seen.of(ragged))
    return Changes(
        edges=joined(seen.of(clean).edges, scanned.edges),
        is_open=ragged & ~scanned.ends,
        limits=limits,
        ragged=ragged,
        rings=rings,
        firsts=firsts,
        highest=np.where(np.isnan(first), np.fmax.reduce(N, axis=1), limits.high),
        quiet=quiet,
    )


def is_fast(device, rows):
    """Tell whether a pulse excites more than the first modes of the beam, (rows,)."""
    swings = np.array([pulse.swings for pulse in rows.pulses])[rows.pulse]
    return 2e-6 * np.pi * rows.f0 * swings > FAST_PULSE * device.own_frequency[rows.device]


def is_ringing(device, rows, least=RINGING):
    """Tell whether the device rings after a pulse, (rows,); least: the share that RINGING is."""
    frequency, spring = device.own_frequency[rows.device], device.spring[rows.device]
    steepest = np.array([pulse.steepest for pulse in rows.pulses])[rows.pulse]
    C = np.where(device.is_alone[rows.device], 0.0, rows.C)
    return 2e-6 * np.pi * rows.f0 * steepest * (1 / frequency + C / spring) >= least


def scan_range(device, static, rows, bound, start=FIRST) -> tuple[np.ndarray, np.ndarray]:
    """Choose the lowest and the highest N of the first scan, (rows,): around any threshold.

    static: threshold of slow pulses, multiples of g, (devices,)
    bound: N below which nothing can snap, (rows,); start: as in `Run`
    A pulse amplifies by at most its variation (2 or more): the scan begins at two thirds of the
    static threshold over that. It ends at five times the static threshold, and higher for short
    pulses, by their change of velocity, and damped masses. A record that goes back and forth counts
    as a change of at least 2 % of peak times duration, and a pulse that pulls counts as pressing
    with at least a quarter of its peak.
    """
    ahead = [pulse if start == FIRST else pulse.reversed() for pulse in rows.pulses]
    columns = static, device.own_frequency, device.mass
    static, frequency, mass = (column[rows.device] for column in columns)
    facts = [(p.variation, max(abs(p.impact), 0.02 * p.swing), max(p.highest, 0.25)) for p in ahead]
    variation, area, press = (column[rows.pulse] for column in np.array(facts).T)
    fast = 1e-6 * np.pi * rows.f0 / (frequency * area)
    damped = np.divide(rows.C, 2 * frequency * mass, out=np.zeros(mass.shape), where=mass > 0)
    low = static / (1.5 * np.fmax(variation, 2))
    # A flying mass strikes with energy that a far weaker shock can give it. A beam that leaves a
    # mass at its stop may swing further than a lasting push moves it.
    from_bound = np.isfinite(device.stop_toward) | (start != FIRST) & ~device.is_alone
    low = np.where(from_bound[rows.device], np.minimum(low, SLACK * bound), low)
    return low, 5 * static / press * (1 + fast) * (1 + damped)


def first_seen(ask: Ask, N: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the first of ascending N, (rows, n), that snaps, and the rows without a snap.

    bound: N below which nothing can snap, (rows,); the scan goes down to it where the first N snaps
    Returns N, (rows,), NaN where nothing snaps, and whether nothing does, (rows,), false where a
    run failed.
    """
    t_snap = np.full(N.shape, np.nan)
    for part in np.split(np.arange(N.shape[1]), range(TOGETHER, N.shape[1], TOGETHER)):
        quiet = ~np.isfinite(t_snap).any(axis=1, keepdims=True)
        t_snap[:, part] = ask(np.where(quiet, N[:, part], np.nan))
    first = first_snap(N, np.isfinite(t_snap))[1]
    quiet = np.isnan(t_snap).all(axis=1) & np.isfinite(N[:, 0])
    begins = np.isfinite(t_snap[:, 0])
    if begins.any():
        lower = amplitudes(np.where(begins, SLACK * bound, np.nan), N[:, 0], SCAN_STEP)
        first = np.where(begins, first_snap(lower, np.isfinite(ask(lower)))[1], first)
    return first, quiet


def island_limits(
    first: np.ndarray, islands_from: np.ndarray | None, highest: float | None, slow: np.ndarray
) -> Window:
    """Choose the window that is scanned for islands, around the first N that snaps, (rows,).

    islands_from: lower ends, (rows,), instead of those by ISLANDS_FROM
    highest: upper end, multiples of g, instead of those by ISLANDS_TO
    slow: whether a pulse is too slow for ringing, so that islands lie within RAGGED_REACH, (rows,)
    """
    near = first / RAGGED_REACH, first * RAGGED_REACH
    low = np.where(slow, near[0], ISLANDS_FROM * first) if islands_from is None else islands_from
    high = ISLANDS_TO * first if highest is None else np.fmax(highest, near[1])
    high = np.where(np.isfinite(first), np.where(slow, near[1], high), np.nan)
    return Window(low, high, np.full(first.size, ISLAND_STEP))


def find_islands(ask: Ask, limits: Window) -> tuple[Window, np.ndarray]:
    """Find the window around the cheap model's changes, and the rows that are ragged, (rows,).

    A row is ragged where labels of the cheap model change more than once: then they do in every
    model, in each at other N.
    """
    n_rows = limits.low.size
    edges, *_ = scan(ask, limits.N)
    ends = outermost(edges.row, edges.high, n_rows)
    ragged = np.bincount(edges.row, minlength=n_rows) > 1
    return around(limits, *ends, CLEAN_REACH, ISLAND_STEP), ragged


def decide(ask: Ask, look: Callable, window: Window, ragged: np.ndarray) -> tuple[Seen, np.ndarray]:
    """Find the edges of rows that have a single one, and the rows that are clean, (rows,).

    ask: of the deciding model; ragged: rows that are skipped, (rows,)
    look: looks beside the single edge of each row, given low and high, (rows,), as `look_closely`
    """
    edges, begins, _ = scan(ask, window.of(~ragged).N)
    single = edges.take(is_single(edges, begins)[edges.row])
    ends = np.full((2, ragged.size), np.nan)
    ends[:, single.row] = single.low, single.high
    seen = look(*ends)
    return seen, is_single(seen.edges, seen.begins)


def is_single(edges: Edges, begins: np.ndarray) -> np.ndarray:
    """Tell which rows have one edge alone, from quiet to snap, (rows,); begins: as in `Seen`."""
    return ~begins & (np.bincount(edges.row, minlength=begins.size) == 1)


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
        near = around(window, *ends, CLEAN_REACH, RAGGED_STEP)
        new = np.isnan(seen.low)
        low = np.where(seen.begins, window.low, near.low)
        high = np.where(seen.ends | new, near.high, window.high)
        left = np.isfinite(low) & (new | (low < seen.low) | (high > seen.high))
        grows = lower < window.low
        if not (left | grows).any():
            break
        seen = scan_on(ask, near._replace(low=low, high=high).of(left), seen)
        window = window._replace(low=lower)
    firsts = np.array([_begins((part.edges, part.begins, part.ends), window) for part in scans])
    return seen._replace(edges=seen.edges.take(~seen.begins[seen.edges.row])), firsts


def _begins(scanned, window):
    """Give N at which a scan begins to snap, (rows,), or the end of the window on that side."""
    edges, begins, _ = scanned
    first, _ = outermost(edges.row[edges.rising], edges.high[edges.rising], begins.size)
    return np.where(begins, window.low, np.where(np.isnan(first), window.high, first))


def look_closely(
    model: Follows,
    rows: Rows,
    settings: Run,
    tolerance: float,
    rings: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> Seen:
    """Refine the single edge of rows, and find others close to it where the device rings.

    low, high: ends of the edge, (rows,), NaN for rows that are skipped
    rings: whether the device rings, (rows,)
    """
    low, high = refine(asker(model, rows, settings), low, high, tolerance)
    seen = close_edges(
        model, rows, settings, *(np.where(rings, end, np.nan) for end in (low, high))
    )
    others = np.flatnonzero(~rings & np.isfinite(high))
    rising = np.ones(others.size, bool)
    edges = joined(seen.edges, Edges(others, low[others], high[others], rising))
    low, high = np.where(rings, [seen.low, seen.high], [low, high])
    return Seen(edges, seen.begins, np.where(rings, seen.ends, np.isfinite(high)), low, high)


def refine_edges(
    model: Follows,
    rows: Rows,
    settings: Run,
    tolerance: float,
    edges: Edges,
    which: np.ndarray,
) -> Edges:
    """Refine the edges of some rows to a relative tolerance; which: a mask of rows, (rows,)."""
    part, others = edges.take(which[edges.row]), edges.take(~which[edges.row])
    row, *ends, rising = part
    ends = refine(asker(model, rows.take(row), settings), *ends, tolerance, rising)
    return joined(others, Edges(row, *ends, rising))


def close_edges(
    model: Follows,
    rows: Rows,
    settings: Run,
    low: np.ndarray,
    high: np.ndarray,
    sides: tuple[int, ...] = (-1, 1),
    reach: float = np.inf,
) -> Seen:
    """Find further edges close to a refined one, as a scan in CLOSE_STEP would, by fewer runs.

    low, high: ends of the edge, (rows,), NaN for rows that are skipped
    sides: sides that are looked at, -1 below and 1 above
    reach: largest relative distance of CLOSE_PLACES
    Below a single threshold, runs come nearer to a snap as N grows; above, they snap later the
    closer N is to it. A stretch of the other label disturbs this order far beyond its own ends, as
    runs beside it dwell at the saddle, too. Where the order is broken, all steps in between are
    tried, above every second one, unless a run has shown another label already.
    """
    observe, ask = observer(model, rows, settings), asker(model, rows, settings)
    steps = CLOSE_PLACES[reach >= CLOSE_STEP * CLOSE_PLACES]
    between = np.setdiff1d(np.arange(2, steps[-1]), steps)
    inside = np.searchsorted(steps, between) - 1
    runs = [observe(_beside(low, high, side, steps)) for side in sides]
    others = [np.isfinite(run.t_snap) == (side < 0) for side, run in zip(sides, runs, strict=True)]
    alone = ~np.any(np.hstack(others), axis=1, keepdims=True)
    N, t_snap = [low, high], [np.full(low.size, np.nan), np.zeros(low.size)]
    for side, run in zip(sides, runs, strict=True):
        nearer = -run.lowest if side < 0 else run.t_snap
        # Above the threshold a gap of one step does not matter.
        wanted = alone & _out_of_order(nearer)[:, inside] & ((side < 0) | (between % 2 == 0))
        more = np.where(wanted, _beside(low, high, side, between), np.nan)
        N += _beside(low, high, side, steps), more
        t_snap += run.t_snap, ask(more)
    N, t_snap = np.column_stack(N), np.column_stack(t_snap)
    order = np.argsort(N, axis=1)
    N, t_snap = (np.take_along_axis(a, order, axis=1) for a in (N, t_snap))
    return Seen(*edges_of(N, t_snap), np.fmin.reduce(N, axis=1), np.fmax.reduce(N, axis=1))


def _beside(low, high, side, steps):
    """Give N at some numbers of steps below or above an edge, (rows, steps)."""
    return np.multiply.outer(low if side < 0 else high, 1 + CLOSE_STEP * side * steps)


def _out_of_order(nearer, beside=2):
    """Find intervals, (rows, n), in which values do not fall outward, or within `beside` of such.

    docs/thresholds.md, "Width of islands", has what this misses.
    """
    with np.errstate(invalid="ignore"):
        rises = ~(nearer[:, 1:] < nearer[:, :-1])
    padded = np.pad(rises, ((0, 0), (beside, beside)))
    shifts = range(2 * beside + 1)
    return np.any([padded[:, i : i + rises.shape[1]] for i in shifts], axis=0)


def compare(
    models: Survey,
    rows: Rows,
    settings: Run,
    tolerance: float,
    changes: Changes,
    N_first: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Compare thresholds with those of another time step and of other models.

    Returns the error of N_first, multiples of g, and whether a row is ragged, as its labels change
    back and forth or as models differ by far; (rows,).
    """
    ragged, rings, others = changes.ragged, changes.rings, _ragged_others(models)
    clean = np.where(ragged, np.nan, N_first)
    near = _clean_bars(models, rows, settings, tolerance, clean)
    if models.finest is not None:
        # An island that finer time steps open below the threshold belongs to the bar.
        high = np.where(rings, clean, np.nan)
        low = (1 - tolerance) * high
        close = close_edges(models.finest, rows, settings, low, high, (-1,), OPEN_BAR).edges
        islands = close.take(close.high < low[close.row])
        near = np.fmax(near, N_first - outermost(islands.row, islands.low, low.size)[0])
    apart = np.isinf(near)
    window = changes.limits.of(apart)
    scans = [scan(asker(model, rows, settings, "snap"), window.N) for model in others]
    firsts = np.where(apart, [_begins(part, window) for part in scans], changes.firsts)
    far = np.fmax(_spread(changes.edges, N_first), np.max(abs(N_first - firsts), axis=0))
    step = np.where(ragged, RAGGED_STEP, np.where(rings, CLOSE_STEP, 0.0))
    step = np.where(apart, ISLAND_STEP, step)
    ragged = ragged | apart
    return np.where(ragged, far, near) + (step + tolerance) * N_first, ragged


def _clean_bars(models, rows, settings, tolerance, N_first):
    """Add up the distances of clean thresholds in time step and model, (rows,)."""
    asks = (asker(model, rows, settings) for model in _others(models))
    in_time, *in_space = [distance(ask, N_first, tolerance) for ask in asks]
    # The second of `models.others`, the better one, may itself be off by as much.
    return in_time + np.max(in_space, axis=0) + sum(in_space[1 : len(models.others)])


def _others(models):
    """Give the models that thresholds are compared with, the deciding one in another step first."""
    return models.decides.with_step(STEP_RATIO), *models.others, *models.judges


def _ragged_others(models):
    """Give the models that ragged rows are compared with: those of clean rows, and the finest."""
    return *_others(models), models.finest or models.decides


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


def snap_times(model, rows, settings, N):
    """Find when each row snaps at N, (rows,): us after the pulse's start, NaN where it does not."""
    return asker(model, rows, settings)(N[:, np.newaxis])[:, 0]

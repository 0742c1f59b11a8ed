"""Thresholds as a product: where snapping begins and where it is certain, with an error bar.

The search has five steps:
1. The cheap model scans upwards until something snaps (`first_seen`).
2. It looks for islands within a window about that (`find_islands`).
3. One model decides where labels change, and refines (`decide`).
4. Where the device rings, it looks closely beside a threshold that stands alone (`look_closely`).
5. The threshold is compared with that of another step and of other models (`compare`).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..solver.adaptive import Survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Settings
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
    observer,
    outermost,
    refine,
    scan,
    scan_on,
    stretches,
)

ISLANDS_FROM, ISLANDS_TO = 0.7, 2.0
"""Where islands are looked for, as multiples of the first N that snaps."""
ISLAND_STEP, RAGGED_STEP, CLOSE_STEP = 0.005, 0.001, 0.00025
"""Relative steps between which islands are looked for: anywhere, in ragged rows, where labels
change back and forth, and close to a threshold."""
CLEAN_REACH, RAGGED_REACH = 1.02, 1.05
"""How far around the changes seen so far the model that decides looks, in clean and ragged rows."""
RINGING = 0.25
"""The time in which a device follows a pulse, over that of its steepest rise, from which on it
rings after the pulse: islands lie close to its threshold."""
FAST_PULSE = 0.7
"""Frequency of a pulse over the device's own from which on the finer models take its rows."""
CLOSE_PLACES = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80])
"""Distances from a threshold, up to CLEAN_REACH, in CLOSE_STEP, at which runs are looked at."""
OPEN_BAR = 10 * RAGGED_STEP
"""Relative bar from which on a ragged row stays open: the step of its scan suffices. So far below a
clean threshold the finest model must show no other."""
STEP_RATIO = 2.0**0.5
"""Times the step that decides, of the runs by which the error of time is seen: of second order, it
changes by itself."""
AGREEMENTS = 4
"""At so many distances another level must agree that a threshold lies between."""
MAX_DISTANCE = 0.25
"""Relative distance up to which another level's threshold is looked for; beyond, a row is ragged.
"""
SLACK = 0.99
"""Of the bound by energy, down to which amplitudes are looked at: a model may itself be off."""
STATUS = "no_device", "found", "nothing_snaps", "not_followed"
"""Whether there is a threshold, and if not, why: nothing snaps up to the highest N looked at, or
runs fail, as of a pulse too short for any step."""
NO_DEVICE, FOUND, NOTHING_SNAPS, NOT_FOLLOWED = range(len(STATUS))


class Thresholds(NamedTuple):
    """Thresholds of rows, (rows,), in multiples of g; NaN where there is none.

    status: whether there is an N_first, or why not: index into STATUS
    N_bound: below it nothing can snap, by energy
    N_looked: the highest N looked at
    N_first: the lowest N seen to snap, a place of the search's lattice; below its bar, nothing
        wider does than docs/thresholds.md, "Width of islands", says
    N_error: of N_first: what other levels, another step and the refinement leave open
    ragged: 1 where labels change back and forth, or levels differ by far, else 0
    N_always: the lowest above which every N looked at snaps: from here on snapping is the rule
    t_snap: at N_first, us after the pulse's start
    level: of the models that decided: 1 of fast pulses, or where the first left too much open
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
    """Where labels of rows change, as the model that decides sees it; all but edges (rows,).

    edges: refined, but for those of ragged rows
    is_open: whether the highest N of a row is quiet, so that nothing always snaps
    limits: of where islands count
    ragged, rings: whether labels change back and forth, and whether the device rings
    firsts: where others begin to snap in ragged rows, (others, rows)
    highest: largest N looked at; quiet: whether nothing snaps up to there
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
    settings: Settings,
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
) -> Thresholds:
    """Find the thresholds of rows, to a relative tolerance.

    highest: up to which N islands are looked for; ISLANDS_TO times the threshold if not given
    Rows of fast pulses, and clean ones that are left open by more than the models' tolerance, are
    taken by finer models. Where the cheap model fails, the one that decides scans.
    """
    options = settings, tolerance, highest
    if models.finer is None:
        return _followed(models, rows, *options)
    fast, thresholds = is_fast(models.decides.device, rows), None
    slow = np.flatnonzero(~fast)
    if slow.size or not fast.size:
        new = _followed(models, rows.take(slow), *options)
        unsure = (new.ragged == 0) & (new.N_error > models.tolerance * new.N_first)
        fast[slow[unsure]] = True
        thresholds = _merged(fast.size, None, slow, new)
    if fast.any():
        new = survey(models.finer, rows.take(fast), *options)
        new = new._replace(level=new.level + 1)
        thresholds = _merged(fast.size, thresholds, np.flatnonzero(fast), new)
    return thresholds


def lowest(models: Survey, rows: Rows, settings: Settings, tolerance: float) -> np.ndarray:
    """Find N_first, (rows,), without a bar; NaN for none."""
    bound = lower_bound(models, rows, settings)
    alone = models._replace(others=(), judges=())  # which are for bars
    # No island above the first counts.
    changes = find_changes(alone, rows, settings, tolerance, 0.0, bound)
    edges = changes.edges.take(changes.edges.rising)
    first, _ = outermost(edges.row, edges.high, bound.size)
    edges = edges.take(edges.high == first[edges.row])
    edges = refine_edges(models.ragged, rows, settings, tolerance, edges, changes.ragged)
    return outermost(edges.row, edges.high, bound.size)[0]


def _followed(models, rows, settings, tolerance, highest):
    """Find thresholds by these models; where the cheap one fails, the one that decides scans."""
    bound = lower_bound(models, rows, settings)
    options = settings, tolerance, highest
    thresholds = _survey(models, rows, *options, bound)
    lost = np.flatnonzero(thresholds.status == NOT_FOLLOWED)
    if lost.size:
        better = models._replace(scans=models.decides)
        again = _survey(better, rows.take(lost), *options, bound[lost], SLACK * bound[lost])
        thresholds = _merged(bound.size, thresholds, lost, again)
    return thresholds


def _survey(models, rows, settings, tolerance, highest, bound, islands_from=None):
    """Find thresholds of rows by the five steps; islands_from: N, as in `find_changes`."""
    changes = find_changes(models, rows, settings, tolerance, highest, bound, islands_from)
    N_first, *_ = stretches(changes.edges, changes.is_open)
    N_error, ragged = compare(models, rows, settings, tolerance, changes, N_first)
    refined = changes.ragged & (N_error <= OPEN_BAR * N_first)
    edges = refine_edges(models.ragged, rows, settings, tolerance, changes.edges, refined)
    N_first, N_always, islands = stretches(edges, changes.is_open)
    if highest is not None:
        N_always = np.where(N_always <= highest, N_always, np.nan)
    t_snap = snap_times(models.decides, rows, settings, np.where(changes.ragged, np.nan, N_first))
    ragged_N = np.where(changes.ragged, N_first, np.nan)
    t_snap = np.fmax(t_snap, snap_times(models.ragged, rows, settings, ragged_N))
    none = np.where(changes.quiet, NOTHING_SNAPS, NOT_FOLLOWED)
    return Thresholds(
        status=np.where(np.isnan(N_first), none, FOUND).astype(np.int8),
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


def _merged(n_rows, thresholds, which, again):
    """Put new thresholds of rows, by their indices, into thresholds, or into none."""
    pairs = zip(again, thresholds or [None] * len(again), strict=True)
    return Thresholds(*(with_rows(n_rows, which, new, old) for new, old in pairs))


def with_rows(
    n_rows: int, which: np.ndarray, new: np.ndarray, others: np.ndarray | None
) -> np.ndarray:
    """Put new values of some rows of a variable beside those of the others, which may be missing.

    which: indices of the new, (new,); others: (n_rows, ...); either may have fewer islands
    """
    widest = max((part.shape[1:] for part in (new, others) if part is not None), key=np.prod)
    blank = np.nan if new.dtype.kind == "f" else 0
    values = np.full((n_rows, *widest), blank, new.dtype)
    if others is not None:
        values[(slice(None), *map(slice, others.shape[1:]))] = others
    values[which] = blank
    values[(which, *map(slice, new.shape[1:]))] = new
    return values


def lower_bound(models: Survey, rows: Rows, settings: Settings) -> np.ndarray:
    """Bound N that snap from below, (rows,): by energy, or far below static ones."""
    bound = least_amplitudes(models.decides, rows, settings.start)
    return np.maximum(bound, 1e-4 * models.static[rows.device])


def find_changes(
    models: Survey,
    rows: Rows,
    settings: Settings,
    tolerance: float,
    highest: float | None,
    bound: np.ndarray,
    islands_from: np.ndarray | None = None,
) -> Changes:
    """Find the changes of rows by the first four steps.

    highest: as in `survey`; bound: below which nothing can snap, (rows,)
    islands_from: the N from which islands count, (rows,), in place of that of ISLANDS_FROM
    """
    rings = is_ringing(models.scans.device, rows)
    label = asker(models.scans, rows, settings, until="snap")
    wide = amplitudes(
        *scan_range(models.scans.device, models.static, rows, bound, settings.start), SCAN_STEP
    )
    first, quiet = first_seen(label, wide, bound)
    slow = ~is_ringing(models.scans.device, rows, RINGING / 5)
    limits = island_limits(first, islands_from, highest, slow)
    window, ragged = find_islands(label, limits)

    def closely(low, high):
        return look_closely(models.decides, rows, settings, tolerance, rings, low, high)

    seen, clean = decide(asker(models.decides, rows, settings), closely, window, ragged)
    ragged = np.isfinite(first) & ~clean
    window = around(limits, window.low, window.high, RAGGED_REACH, RAGGED_STEP).of(ragged)
    others = [asker(model, rows, settings, until="snap") for model in _others(models)]
    ask = asker(models.ragged, rows, settings)
    scanned, firsts = scan_ragged(ask, others, window, seen.of(ragged))
    top = np.where(np.isnan(first), np.fmax.reduce(wide, axis=1), limits.high)
    return Changes(
        edges=joined(seen.of(clean).edges, scanned.edges),
        is_open=ragged & ~scanned.ends,
        limits=limits,
        ragged=ragged,
        rings=rings,
        firsts=firsts,
        highest=top,
        quiet=quiet,
    )


def is_fast(device, rows):
    """Tell whether the beam follows a pulse by more than its first modes, (rows,)."""
    swings = np.array([pulse.swings for pulse in rows.pulses])[rows.pulse]
    return 2e-6 * np.pi * rows.f0 * swings > FAST_PULSE * device.own_frequency[rows.device]


def is_ringing(device, rows, least=RINGING):
    """Tell whether the device rings after a pulse, (rows,); least: as RINGING."""
    frequency, spring = device.own_frequency[rows.device], device.spring[rows.device]
    steepest = np.array([pulse.steepest for pulse in rows.pulses])[rows.pulse]
    C = np.where(device.is_alone[rows.device], 0.0, rows.C)
    return 2e-6 * np.pi * rows.f0 * steepest * (1 / frequency + C / spring) >= least


def scan_range(device, static, rows, bound, start=FIRST) -> tuple[np.ndarray, np.ndarray]:
    """Choose between which N rows are scanned, (rows,): from below any threshold to far above.

    static: threshold of slow pulses, (devices,); bound: below which nothing can snap, (rows,)
    start: as in `Settings`
    A pulse amplifies no more than it varies: the scan begins at two thirds of the static threshold
    by that. It ends at five times the static threshold, for a short pulse where it brings as much
    velocity, against damping. A record that goes back and forth counts as if it changed the
    velocity by 2 % of peak times duration, and a pulse that pulls as if it pressed with a quarter
    of its peak.
    """
    ahead = [pulse if start == FIRST else pulse.reversed() for pulse in rows.pulses]
    columns = static, device.own_frequency, device.mass
    static, frequency, mass = (column[rows.device] for column in columns)
    facts = [(p.variation, max(abs(p.impact), 0.02 * p.swing), max(p.highest, 0.25)) for p in ahead]
    variation, area, presses = (column[rows.pulse] for column in np.array(facts).T)
    fast = 1e-6 * np.pi * rows.f0 / (frequency * area)
    damped = np.divide(rows.C, 2 * frequency * mass, out=np.zeros(mass.shape), where=mass > 0)
    low = static / (1.5 * np.fmax(variation, 2))
    # A mass that flies from afar may strike with the energy of a far weaker shock, and a beam that
    # leaves a mass at its stop may swing further than a lasting push moves it.
    from_bound = np.isfinite(device.stop_toward) | (start != FIRST) & ~device.is_alone
    low = np.where(from_bound[rows.device], np.minimum(low, SLACK * bound), low)
    return low, 5 * static / presses * (1 + fast) * (1 + damped)


def first_seen(ask: Ask, wide: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the first of wide amplitudes, (rows, n), that snaps, and in which rows all are quiet.

    bound: below which nothing can snap, (rows,); where the lowest snaps, the scan goes down to it
    Returns N, (rows,), NaN for none, and bools, (rows,), false where a run failed
    """
    t_snap = np.full(wide.shape, np.nan)
    for part in np.split(np.arange(wide.shape[1]), range(TOGETHER, wide.shape[1], TOGETHER)):
        quiet = ~np.isfinite(t_snap).any(axis=1, keepdims=True)
        t_snap[:, part] = ask(np.where(quiet, wide[:, part], np.nan))
    first = first_snap(wide, np.isfinite(t_snap))[1]
    quiet = np.isnan(t_snap).all(axis=1) & np.isfinite(wide[:, 0])
    begins = np.isfinite(t_snap[:, 0])
    if begins.any():
        lower = amplitudes(np.where(begins, SLACK * bound, np.nan), wide[:, 0], SCAN_STEP)
        first = np.where(begins, first_snap(lower, np.isfinite(ask(lower)))[1], first)
    return first, quiet


def island_limits(
    first: np.ndarray, islands_from: np.ndarray | None, highest: float | None, slow: np.ndarray
) -> Window:
    """Limit where islands are looked for, about the first of wide amplitudes that snaps, (rows,).

    islands_from, highest: the ends, in place of those of ISLANDS_FROM and ISLANDS_TO
    slow: whether a pulse moves the device from rest to rest: then islands lie within RAGGED_REACH
    """
    near = first / RAGGED_REACH, first * RAGGED_REACH
    low = np.where(slow, near[0], ISLANDS_FROM * first) if islands_from is None else islands_from
    high = ISLANDS_TO * first if highest is None else np.fmax(highest, near[1])
    high = np.where(np.isfinite(first), np.where(slow, near[1], high), np.nan)
    return Window(low, high, np.full(first.size, ISLAND_STEP))


def find_islands(ask: Ask, limits: Window) -> tuple[Window, np.ndarray]:
    """Find where the model that decides is to look, and which rows are ragged, (rows,).

    A row is ragged where labels of the cheap model change more than once; so it is by every other,
    each in its own way.
    """
    n_rows = limits.low.size
    edges, *_ = scan(ask, limits.N)
    ends = outermost(edges.row, edges.high, n_rows)
    ragged = np.bincount(edges.row, minlength=n_rows) > 1
    return around(limits, *ends, CLEAN_REACH, ISLAND_STEP), ragged


def decide(
    ask: Ask, closely: Callable, window: Window, ragged: np.ndarray
) -> tuple[Seen, np.ndarray]:
    """Find the only edge of rows, as the deciding model sees it, and where it is the only one.

    closely: looks beside the only edge of each row, between two N, (rows,), as `look_closely`
    ragged: rows that are not looked at, (rows,)
    """
    edges, begins, _ = scan(ask, window.of(~ragged).N)
    alone = ~begins & (np.bincount(edges.row, minlength=ragged.size) == 1)
    only, sides = edges.take(alone[edges.row]), np.full((2, ragged.size), np.nan)
    sides[:, only.row] = only.low, only.high
    seen = closely(*sides)
    count = np.bincount(seen.edges.row, minlength=ragged.size)
    return seen, ~seen.begins & (count == 1)


def scan_ragged(
    ask: Ask, others: Sequence[Ask], window: Window, seen: Seen
) -> tuple[Seen, np.ndarray]:
    """Find the edges in a window of which a part was seen, and where others begin to snap.

    The others scan in twice the step and say where to look: within CLEAN_REACH of all changes, and
    to the end of the window on a side where labels are not those beyond it.
    """
    coarse = window._replace(step=2 * window.step)
    scans = [scan(other, coarse.N) for other in others]
    firsts = np.array([_begins(part, window) for part in scans])
    while True:
        edges = joined(seen.edges, *(edges for edges, *_ in scans))
        ends = outermost(edges.row, edges.high, window.low.size)
        ends = (np.where(np.isnan(a), b, a) for a, b in zip(ends, window[:2], strict=True))
        near = around(window, *ends, CLEAN_REACH, RAGGED_STEP)
        new = np.isnan(seen.low)
        low = np.where(seen.begins, window.low, near.low)
        high = np.where(seen.ends | new, near.high, window.high)
        left = np.isfinite(low) & (new | (low < seen.low) | (high > seen.high))
        if not left.any():
            break
        seen = scan_on(ask, near._replace(low=low, high=high).of(left), seen)
    return seen._replace(edges=seen.edges.take(~seen.begins[seen.edges.row])), firsts


def _begins(scanned, window):
    """Where a scan begins to snap, (rows,), or the end of the window beyond which it does."""
    edges, begins, _ = scanned
    first, _ = outermost(edges.row[edges.rising], edges.high[edges.rising], begins.size)
    return np.where(begins, window.low, np.where(np.isnan(first), window.high, first))


def look_closely(
    model: Follows,
    rows: Rows,
    settings: Settings,
    tolerance: float,
    rings: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> Seen:
    """Refine the only edge of rows, and find those close to it where the device rings.

    low, high: the edge, (rows,); NaN for rows that are not looked at; rings: (rows,)
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
    settings: Settings,
    tolerance: float,
    edges: Edges,
    which: np.ndarray,
) -> Edges:
    """Refine the edges of some rows, a mask of them, (rows,)."""
    part, others = edges.take(which[edges.row]), edges.take(~which[edges.row])
    row, *ends, rising = part
    ends = refine(asker(model, rows.take(row), settings), *ends, tolerance, rising)
    return joined(others, Edges(row, *ends, rising))


def close_edges(
    model: Follows,
    rows: Rows,
    settings: Settings,
    low: np.ndarray,
    high: np.ndarray,
    sides: tuple[int, ...] = (-1, 1),
    reach: float = np.inf,
) -> Seen:
    """Find the edges close to one, as on a scan in CLOSE_STEP, by fewer runs.

    low, high: the edge, refined, (rows,); NaN for rows that are not looked at
    sides: on which it is looked, -1 below and 1 above; reach: relative, of CLOSE_PLACES
    Below a threshold that stands alone, each run comes nearer to a snap than those at lower N;
    above it, each snaps the later, the closer N lies to it. A stretch of the other label bends this
    far beyond its own ends: near it, too, runs come close to the saddle, and dwell there. Where
    this order is broken, it is scanned, above in twice the step, unless runs show other labels.
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
        # Above, a gap that is so narrow is of no account.
        wanted = alone & _out_of_order(nearer)[:, inside] & ((side < 0) | (between % 2 == 0))
        more = np.where(wanted, _beside(low, high, side, between), np.nan)
        N += _beside(low, high, side, steps), more
        t_snap += run.t_snap, ask(more)
    N, t_snap = np.column_stack(N), np.column_stack(t_snap)
    order = np.argsort(N, axis=1)
    N, t_snap = (np.take_along_axis(a, order, axis=1) for a in (N, t_snap))
    return Seen(*edges_of(N, t_snap), np.fmin.reduce(N, axis=1), np.fmax.reduce(N, axis=1))


def _beside(low, high, side, steps):
    """Place N so many steps below or above an edge, (rows, steps)."""
    return np.multiply.outer(low if side < 0 else high, 1 + CLOSE_STEP * side * steps)


def _out_of_order(nearer, beside=2):
    """Intervals in which values do not fall outward, and so many beside these, (rows, n).

    So no stretch wider than 0.06 % was missed beside 414 thresholds of random devices, a third of
    them ragged; docs/thresholds.md, "Width of islands".
    """
    with np.errstate(invalid="ignore"):
        rises = ~(nearer[:, 1:] < nearer[:, :-1])
    padded = np.pad(rises, ((0, 0), (beside, beside)))
    shifts = range(2 * beside + 1)
    return np.any([padded[:, i : i + rises.shape[1]] for i in shifts], axis=0)


def compare(
    models: Survey,
    rows: Rows,
    settings: Settings,
    tolerance: float,
    changes: Changes,
    N_first: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Compare with another step and other models: errors of N_first, and ragged rows, (rows,)."""
    edges, _, limits, ragged, rings, firsts, *_ = changes

    def ask(model, until="edge"):
        return asker(model, rows, settings, until)

    in_steps, *_ = others = _others(models)
    clean = np.where(ragged, np.nan, N_first)
    in_time = distance(ask(in_steps), clean, tolerance)
    in_space = [distance(ask(other), clean, tolerance) for other in models.others]
    by_judges = [distance(ask(judge), clean, tolerance) for judge in models.judges]
    # The second, the better one, may itself be off by as much.
    near = in_time + np.max(in_space + by_judges, axis=0) + sum(in_space[1:])
    if models.finest is not None:
        # An island below that finer steps open belongs to the bar.
        alone = np.where(rings, clean, np.nan)
        ends = (1 - tolerance) * alone, alone
        close = close_edges(models.finest, rows, settings, *ends, (-1,), OPEN_BAR).edges
        islands = close.take(close.high < ends[0][close.row])
        near = np.fmax(near, N_first - outermost(islands.row, islands.low, alone.size)[0])
    apart = np.isinf(near)
    window = limits.of(apart)
    far_firsts = [_begins(scan(ask(other, "snap"), window.N), window) for other in others]
    firsts = np.where(apart, far_firsts, firsts)
    far = np.fmax(_spread(edges, N_first), np.max(abs(N_first - firsts), axis=0))
    step = np.where(ragged, RAGGED_STEP, np.where(rings, CLOSE_STEP, 0.0))
    step = np.where(apart, ISLAND_STEP, step)
    ragged = ragged | apart
    return np.where(ragged, far, near) + (step + tolerance) * N_first, ragged


def _others(models):
    """The models with which ragged rows are compared: in another step the one that decides."""
    return models.decides.with_step(STEP_RATIO), *models.others, *models.judges


def _spread(edges, N_first):
    """How far above N_first the last change lies that is close to it, (rows,), but for a step."""
    spread = np.zeros(N_first.size)
    above = edges.low - N_first[edges.row]
    close = edges.high <= CLEAN_REACH * N_first[edges.row]
    np.fmax.at(spread, edges.row[close], above[close])
    return spread


def distance(ask: Ask, N_first: np.ndarray, tolerance: float) -> np.ndarray:
    """Find how far from N_first, at most, another level changes from quiet to snap, (rows,).

    There and at each of the next AGREEMENTS - 1 doublings it is quiet below and snaps above: where
    labels change back and forth closely, a single look is luck. It is known to an eighth.
    """

    def differ(which, reaches):
        """Whether labels at distances, (n, m), are others than those about a threshold."""
        N = np.full((N_first.size, 2 * reaches.shape[1]), np.nan)
        N[which] = N_first[which, np.newaxis] * np.hstack([1 - reaches, 1 + reaches])
        below, above = np.hsplit(np.isfinite(ask(N))[which], 2)
        return below | ~above

    distances = np.where(np.isnan(N_first), np.nan, np.inf)
    reach = np.full(N_first.size, tolerance / 4)
    while (left := np.flatnonzero(np.isinf(distances) & (reach < MAX_DISTANCE))).size:
        doubled = np.multiply.outer(reach[left], 2.0 ** np.arange(AGREEMENTS))
        other = differ(left, np.minimum(doubled, MAX_DISTANCE))
        passed = np.where(other.any(axis=1), AGREEMENTS - np.argmax(other[:, ::-1], axis=1), 0)
        distances[left[passed == 0]] = (reach * N_first)[left[passed == 0]]
        reach[left] *= 2.0**passed
    near = np.flatnonzero(np.isfinite(distances))
    same = ~differ(near, np.multiply.outer(reach[near], [7 / 8, 6 / 8, 5 / 8]))
    distances[near] *= 1 - np.logical_and.accumulate(same, axis=1).sum(axis=1) / 8
    return distances


def snap_times(model, rows, settings, N):
    """Find when each row snaps at an N, us after the pulse's start, (rows,); NaN for never."""
    return asker(model, rows, settings)(N[:, np.newaxis])[:, 0]

"""Thresholds as a product: where snapping begins and where it is certain, with an error bar."""

from typing import NamedTuple

import numpy as np

from ..solver.adaptive import DECIDING_STEPS, Survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Settings
from .bars import OTHERS_STEP, Scan, error_bars
from .search import SCAN_STEP, Ask, Edges, amplitudes, asker, first_snap, joined, refine, scan, walk
from .transitions import (
    BESIDE,
    FAR_BESIDE,
    FINE_STEP,
    FINEST_STEP,
    Window,
    around,
    chosen,
    outermost,
    stretches,
)
from .witness import edges_about

NARROW = 0.0005
"""Relative width of a stretch between two changes down to which it counts: narrower ones, which
another level may not have, belong to no definition."""
ISLANDS_FROM, ISLANDS_TO = 0.7, 2.0
"""Where islands are looked for, as multiples of the first that snaps."""
SLOW = 0.05
"""A pulse that lasts 1 / SLOW times longer than the device's response moves it from rest to rest:
it snaps where no rest is left, and at every N above."""
FAST_PULSE = 0.7
"""Frequency of a pulse over the device's own from which on the finer models take its rows."""
RINGS = 0.25
"""From this share on, reckoned as SLOW, a device rings after the pulse: islands lie close below."""
SLOW_REACH, SLOW_BESIDE = 2.0, 1.05
"""How far around the static threshold slow pulses are looked at, and then around their own."""
LEAST_AREA = 0.02
"""A recorded shock may go back and forth; as if it changed the velocity at least by this share of
peak times duration, amplitudes are looked at."""
LEAST_PUSH = 0.25
"""Of a pulse that pulls, amplitudes are looked at as if it pressed with this share of its peak."""
LEAST = 1e-4
"""Of the static threshold, down to which N are looked at where no bound by energy is known."""
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
    N_first: the lowest N seen to snap; below its bar, nothing
        wider than NARROW does within BESIDE of a clean threshold of a row that rings, than
        FINEST_STEP near a ragged one, OTHERS_STEP times that under fast pulses, and than FINE_STEP
        elsewhere
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


def survey(
    models: Survey,
    rows: Rows,
    settings: Settings,
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
) -> Thresholds:
    """Find the thresholds of rows, to a relative tolerance.

    highest: up to which N islands are looked for; ISLANDS_TO times the threshold if not given
    The cheap model scans; the next looks again where labels change; the one that decides refines;
    the others, and another step, tell what that is worth. Where the cheap one fails, or sees
    another threshold than the next, that one scans too. Ragged rows that were looked at in long
    steps begin where they do in the steps of maps. Rows of fast pulses, and clean ones that
    are left open by more than the models' tolerance, are taken by finer models.
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


def _followed(models, rows, settings, tolerance, highest):
    """Find thresholds by these models; where the cheap one fails, the one that decides scans."""
    bound = least_amplitudes(models.decides, rows, settings.start)
    bound = np.maximum(bound, LEAST * models.static[rows.device])
    options = settings, tolerance, highest
    thresholds = _survey(models, rows, *options, bound)
    lost = np.flatnonzero(thresholds.status == NOT_FOLLOWED)
    if lost.size:
        better = models._replace(scans=models.decides, looks=models.decides)
        again = _survey(better, rows.take(lost), *options, bound[lost], SLACK * bound[lost])
        thresholds = _merged(bound.size, thresholds, lost, again)
    return thresholds


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


def lowest(models: Survey, rows: Rows, settings: Settings, tolerance: float) -> np.ndarray:
    """Find N_first, (rows,), without a bar; NaN for none."""
    bound = least_amplitudes(models.decides, rows, settings.start)
    bound = np.maximum(bound, LEAST * models.static[rows.device])
    # No island above the first counts.
    changes = _changes(models, rows, settings, tolerance, 0.0, bound)
    return stretches(changes.edges, changes.open_end)[0]


class _Changes(NamedTuple):
    """Where labels of rows change: refined edges, and whether the highest N is quiet.

    window, limits: of the scan, and of where islands are looked for; ragged, rings: of rows
    wide: amplitudes of the first scan; quiet: rows in which nothing snaps there
    """

    edges: Edges
    open_end: np.ndarray
    window: Window
    limits: Window
    ragged: np.ndarray
    rings: np.ndarray
    wide: np.ndarray
    quiet: np.ndarray


def _changes(models, rows, settings, tolerance, highest, bound, lowest=None):
    """Find changes of rows; lowest: from which N islands count, if not from ISLANDS_FROM."""
    device = models.scans.device
    slow, rings = pace(device, rows) < SLOW, is_ringing(device, rows)
    label = asker(models.scans, rows, settings, until="snap")
    wide = wide_scan(device, models.static, rows, bound, settings.start, slow)
    first, quiet = first_seen(label, wide, bound)
    limits = _island_limits(first, lowest, highest, slow)
    window, ragged = _closer_window(label, limits)

    def closely(low, high):
        return edges_about(models, rows, settings, tolerance, rings, low, high)

    ask = asker(models.looks, rows, settings)
    edges, open_end, window, ragged = _decide(ask, closely, window, limits, ragged)
    row, *ends, rising = edges
    ask = asker(models.looks, rows.take(row), settings)
    edges = Edges(row, *refine(ask, *ends, tolerance, rising), rising)
    return _Changes(edges, open_end, window, limits, ragged, rings, wide, quiet)


def _first_decided(model, rows, settings, tolerance, which, edges, window, N_first):
    """Replace the first edges of some rows, by their numbers, by those that another model sees.

    It looks from BESIDE below, in OTHERS_STEP times the scan's steps, up to where it snaps; what
    lies from there to the next edge that falls is replaced.
    """
    low = np.maximum(window.low, N_first / BESIDE)
    N = window._replace(low=low, step=OTHERS_STEP * window.step).N[which]
    size = np.count_nonzero(np.isfinite(N), axis=1)
    every = np.arange(which.size)

    def label(numbers, places):
        at = N[numbers[:, np.newaxis], np.minimum(places, N.shape[1] - 1)]
        return np.isfinite(asker(model, rows.take(which[numbers]), settings)(at))

    place = walk(label, every, 0, size)
    known = (place > 0) & (place < size)
    which, place, every = which[known], place[known], every[known]
    ends = N[every, place - 1], N[every, place]
    low, high = refine(asker(model, rows.take(which), settings), *ends, tolerance)
    first = np.full(N_first.size, -np.inf)
    first[which] = high
    above = edges.take(edges.high > first[edges.row])
    falls = above.take(~above.rising)
    next_fall, _ = outermost(falls.row, falls.low, N_first.size)
    within = above.rising & ~(above.high >= next_fall[above.row]) & np.isin(above.row, which)
    return joined(above.take(~within), Edges(which, low, high, np.ones(which.size, bool)))


def _survey(models, rows, settings, tolerance, highest, bound, lowest=None):
    """Find thresholds of rows by the deciding level; lowest: as in `_changes`."""
    edges, open_end, window, limits, ragged, rings, wide, quiet = _changes(
        models, rows, settings, tolerance, highest, bound, lowest
    )
    decides = models.decides
    of_maps = decides.with_step(1 / DECIDING_STEPS)
    N_first, *_ = stretches(edges, open_end)
    N_before = N_first
    if models.looks is not decides:
        which = np.flatnonzero(ragged & np.isfinite(N_first))
        before = edges, window, N_first
        edges = _first_decided(of_maps, rows, settings, tolerance, which, *before)
        N_first, *_ = stretches(edges, open_end)
    done = Scan(edges, N_first, ragged, window, limits)
    N_error, ragged = error_bars(models, rows, settings, tolerance, done, rings)
    N_error = np.fmax(N_error, abs(N_first - N_before))
    *_, N_always, islands = stretches(edges, open_end)
    if highest is not None:
        N_always = np.where(N_always <= highest, N_always, np.nan)
    t_snap = snap_times(decides, rows, settings, N_first)
    for model in (of_maps, models.looks):
        unseen = np.flatnonzero(np.isnan(t_snap) & np.isfinite(N_first))
        t_snap[unseen] = snap_times(model, rows.take(unseen), settings, N_first[unseen])
    none = np.where(quiet, NOTHING_SNAPS, NOT_FOLLOWED)
    return Thresholds(
        status=np.where(np.isnan(N_first), none, FOUND).astype(np.int8),
        N_bound=bound,
        N_looked=np.fmax(np.fmax.reduce(wide, axis=1), limits.high),
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


def is_fast(device, rows):
    """Tell whether the beam follows a pulse by more than its first modes, (rows,)."""
    swings = np.array([pulse.swings for pulse in rows.pulses])[rows.pulse]
    return 2e-6 * np.pi * rows.f0 * swings > FAST_PULSE * device.own_frequency[rows.device]


def is_ringing(device, rows):
    """Tell whether the device rings after a pulse, (rows,)."""
    return pace(device, rows) >= RINGS


def pace(device, rows):
    """Divide the time that the device takes to follow a pulse by the pulse's duration, (rows,)."""
    frequency, spring = device.own_frequency[rows.device], device.spring[rows.device]
    steepest = np.array([pulse.steepest for pulse in rows.pulses])[rows.pulse]
    C = np.where(device.is_alone[rows.device], 0.0, rows.C)
    return 2e-6 * np.pi * rows.f0 * steepest * (1 / frequency + C / spring)


def wide_scan(device, static, rows, bound, start=FIRST, slow=False) -> np.ndarray:
    """Space amplitudes, (rows, n), from below any threshold to far above, also of short pulses.

    static: threshold of slow pulses, (devices,); bound: below which nothing can snap, (rows,)
    start: as in `Settings`; slow: whether a row's pulse is one, (rows,)
    """
    ahead = [pulse if start == FIRST else pulse.reversed() for pulse in rows.pulses]
    columns = static, device.own_frequency, device.mass
    static, frequency, mass = (column[rows.device] for column in columns)
    facts = [(p.variation, max(abs(p.impact), LEAST_AREA * p.swing), p.highest) for p in ahead]
    variation, area, highest = (column[rows.pulse] for column in np.array(facts).T)
    # A pulse amplifies no more than it varies; a short one must bring a velocity, against damping.
    fast = 1e-6 * np.pi * rows.f0 / (frequency * area)
    damped = np.divide(rows.C, 2 * frequency * mass, out=np.zeros(mass.shape), where=mass > 0)
    low = np.where(slow, static / SLOW_REACH, static / (1.5 * np.fmax(variation, 2)))
    if start != FIRST:
        # A mass that flies from afar may strike with the energy of a far weaker shock.
        flies = ~device.is_alone[rows.device] & ~np.asarray(slow)
        low = np.where(flies, np.minimum(low, SLACK * bound), low)
    # What mostly pulls must do so far more strongly.
    static = static / np.fmax(highest, LEAST_PUSH)
    high = np.where(slow, SLOW_REACH * static, 5 * static * (1 + fast) * (1 + damped))
    return amplitudes(low, high, SCAN_STEP)


def first_seen(ask: Ask, wide: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the first of wide amplitudes, (rows, n), that snaps, and in which rows all are quiet.

    bound: below which nothing can snap, (rows,); where the lowest snaps, the scan goes down to it
    Returns N, (rows,), NaN for none, and bools, (rows,), false where a run failed
    """
    t_snap = ask(wide)
    first = first_snap(wide, np.isfinite(t_snap))[1]
    quiet = np.isnan(t_snap).all(axis=1) & np.isfinite(wide[:, 0])
    begins = np.isfinite(t_snap[:, 0])
    if begins.any():
        lower = amplitudes(np.where(begins, SLACK * bound, np.nan), wide[:, 0], SCAN_STEP)
        first = np.where(begins, first_snap(lower, np.isfinite(ask(lower)))[1], first)
    return first, quiet


def _island_limits(rough, lowest, highest, slow):
    """Limit where islands are looked for, about the first of wide amplitudes that snaps."""
    top = ISLANDS_TO * rough if highest is None else np.fmax(highest, FAR_BESIDE * rough)
    low = np.where(slow, rough / SLOW_BESIDE, ISLANDS_FROM * rough if lowest is None else lowest)
    high = np.where(slow, SLOW_BESIDE * rough, np.where(np.isfinite(rough), top, np.nan))
    return Window(low, high, np.full(rough.size, FINE_STEP))


def _closer_window(ask, limits):
    """Find where labels change along N, as the cheapest level sees it, and which rows are ragged.

    A row is ragged where they change more than once; so it is by every level, each in its own way.
    """
    n_rows = limits.low.size
    edges, *_ = scan(ask, limits.N)
    ends = outermost(edges.row, edges.high, n_rows)
    ragged = np.bincount(edges.row, minlength=n_rows) > 1
    clean = around(limits, *ends, BESIDE, FINE_STEP)
    return chosen(ragged, around(limits, *ends, FAR_BESIDE, FINEST_STEP), clean), ragged


def _decide(ask, closely, window, limits, ragged):
    """Find edges as the deciding level sees them, whether the highest N is quiet, what is ragged.

    The only edge of a row is looked at closely. Rows in which it sees other than the cheapest level
    did are ragged too, and scanned on to either side.
    """
    edges, begins, ends = scan(ask, window.N)
    alone = ~ragged & ~begins & (np.bincount(edges.row, minlength=ragged.size) == 1)
    only, sides = edges.take(alone[edges.row]), np.full((2, ragged.size), np.nan)
    sides[:, only.row] = only.low, only.high
    close = closely(*sides)
    edges = joined(edges.take(~alone[edges.row]), close.edges)
    begins, ends = np.where(alone, [close.begins, close.ends], [begins, ends])
    surprising = begins | (~ends & (window.high < limits.high))
    surprising |= ~ragged & (np.bincount(edges.row, minlength=ragged.size) != 1)
    low, high = (np.where(surprising, end, np.nan) for end in (window.low, window.high))
    wider = around(limits, low, high, FAR_BESIDE, FINEST_STEP)
    # From where it was looked closely on, which may not be the window's ends.
    low, high = np.where(surprising & alone, [close.low, close.high], [low, high])
    below, begins_below, _ = scan(ask, wider._replace(high=low).N)
    above, _, ends_above = scan(ask, wider._replace(low=high).N)
    begins, ends = np.where(surprising, [begins_below, ends_above], [begins, ends])
    edges = joined(below, edges, above)
    edges = edges.take(~begins[edges.row])
    return edges, ~ends, chosen(surprising, wider, window), ragged | surprising


def snap_times(model, rows, settings, N):
    """Find when each row snaps at an N, us after the pulse's start, (rows,); NaN for never."""
    return asker(model, rows, settings)(N[:, np.newaxis])[:, 0]

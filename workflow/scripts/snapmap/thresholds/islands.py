"""Thresholds as a product: where snapping begins and where it is certain, with an error bar."""

from typing import NamedTuple

import numpy as np

from ..solver.adaptive import Survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.search import SCAN_STEP, Ask, Edges, amplitudes, asker, first_snap, refine, scan
from ..solver.settings import THRESHOLD_TOLERANCE, Settings
from ..solver.steps import stiffness_share
from .reuse import joined
from .transitions import FINE_STEP, Window, around, balance, chosen, outermost, stretches

FINEST_STEP, CLOSEST_STEP = 0.001, 0.00025
"""Relative steps in ragged rows, where labels change back and forth, and to see which rows are."""
NARROW = 0.0005
"""Relative width of a stretch between two changes down to which it counts: narrower ones, which
another level may not have, belong to no definition."""
BELOW, ABOVE = 0.7, 2.0
"""Where islands are looked for, as multiples of the threshold found first."""
BESIDE, FAR_BESIDE = 1.02, 1.05
"""How far around the changes seen so far is looked closely, in clean and ragged rows."""
SLOW = 0.05
"""A pulse that lasts 1 / SLOW times longer than the device's response moves it from rest to rest:
it snaps where no rest is left, and at every N above."""
RINGS = 0.25
"""From this share on, reckoned as SLOW, a device rings after the pulse: islands lie close below."""
SLOW_REACH, SLOW_BESIDE = 2.0, 1.05
"""How far around the static threshold slow pulses are looked at, and then around their own."""
LEAST_AREA = 0.02
"""A recorded shock may go back and forth; as if it changed the velocity at least by this share of
peak times duration, amplitudes are looked at."""
LEAST_PUSH = 0.25
"""Of a pulse that pulls, amplitudes are looked at as if it pressed with this share of its peak."""
LOOKS = 4
"""At so many distances another level must agree that a threshold lies between."""
SLACK = 0.99
"""Of the bound by energy, down to which amplitudes are looked at: a model may itself be off."""
STATUS = "no_device", "found", "nothing_snaps", "not_followed"
"""Whether there is a threshold, and if not, why: nothing snaps up to the highest N looked at, or
runs fail, as of a pulse too short for any step."""
NO_DEVICE, FOUND, NOTHING_SNAPS, NOT_FOLLOWED = range(len(STATUS))
OTHER_STEP = 2.0**0.5
"""Times the own step, of the runs by which the error of time is seen: of second order, it changes
by itself."""
FINE_STEPS, CHATTERS = 0.25, 0.5
"""Times the own step, where the mass may chatter, which takes short steps to see: under a pulse
with corners, or on a contact so near a hard one."""
ISLANDS = 0.005
"""How far below a clean threshold, relative, the best model looks again where a row rings."""
JUDGED_STEP = 4.0
"""Steps of the judge's scan of a ragged row, over those of the others."""
FARTHEST = 0.25
"""Relative distance up to which another level's threshold is looked for; beyond, a row is ragged.
"""


class Thresholds(NamedTuple):
    """Thresholds of rows, (rows,), in multiples of g; NaN where none was found.

    status: whether N_first was found, or why not: index into STATUS
    N_bound: below it nothing can snap, by energy
    N_looked: the highest N looked at
    N_first: the lowest N seen to snap; below its bar, nothing wider than NARROW does within
        BESIDE of a clean threshold of a row that rings, than FINEST_STEP near a ragged one, and
        than FINE_STEP elsewhere
    N_error: of N_first: what other levels, another step and the refinement leave open
    N_half: N_always less the lengths of the islands: as much snaps below it as does not above
    half_error: of N_half, likewise
    ragged: 1 where labels change back and forth, or levels differ by far, else 0
    N_always: the lowest above which every N looked at snaps: from here on snapping is the rule
    N_pulse: the lowest N that snaps while the pulse lasts
    t_snap: at N_first, us after the pulse's start
    level: of the models that decided: 1 where the first left too much open, else 0
    islands: number of separate stretches of N below N_always that snap
    island_from, island_to: their ends, (rows, most islands), NaN where a row has fewer
    """

    status: np.ndarray
    N_bound: np.ndarray
    N_looked: np.ndarray
    N_first: np.ndarray
    N_error: np.ndarray
    N_half: np.ndarray
    half_error: np.ndarray
    ragged: np.ndarray
    N_always: np.ndarray
    N_pulse: np.ndarray
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

    highest: up to which N islands are looked for; ABOVE times the threshold if not given
    The cheap model scans; the one that decides looks again where labels change, and refines; the
    others, and another step, tell what that is worth. Where the cheap one fails, or sees another
    threshold than the one that decides, that one scans too. Clean rows that are left open by more
    than the models' tolerance are taken by finer ones.
    """
    bound = least_amplitudes(models.decides, rows)
    found = _survey(models, rows, settings, tolerance, highest, bound)
    lost = np.flatnonzero(found.status == NOT_FOLLOWED)
    if lost.size:
        finer = models._replace(scans=models.decides), rows.some(lost)
        again = _survey(*finer, settings, tolerance, highest, bound[lost], SLACK * bound[lost])
        found = _taken(found, lost, again)
    unsure = (found.ragged == 0) & (found.N_error > models.tolerance * found.N_first)
    if models.finer is not None and unsure.any():
        again = survey(models.finer, rows.some(unsure), settings, tolerance, highest)
        found = _taken(found, np.flatnonzero(unsure), again._replace(level=again.level + 1))
    return found


def _taken(found, which, again):
    """Thresholds with those of some rows, by their indices, in the place of the others."""
    pairs = zip(again, found, strict=True)
    return Thresholds(*(joined(found.status.size, which, new, old) for new, old in pairs))


def _survey(models, rows, settings, tolerance, highest, bound, lowest=None):
    """Thresholds of rows; lowest: from which N islands are looked for, if not from BELOW."""

    def ask(model, some=slice(None), horizon=settings.horizon):
        return asker(model, rows.some(some), settings._replace(horizon=horizon))

    def scan_by(model):
        """In the longer steps of a label, which tell where to look."""
        return asker(model, rows, settings, until="snap")

    scans, decides, doubts, better, static, judge, *_ = models
    pace = _pace(scans.device, rows)
    slow = pace < SLOW
    wide = wide_scan(scans.device, static, rows, slow)
    rough, quiet = first_seen(scan_by(scans), wide, bound)
    whole = _whole_window(rough, lowest, highest, slow)
    window, ragged = _closer_window(scan_by(scans), whole, pace >= RINGS)
    closest = np.where(pace >= RINGS, CLOSEST_STEP, 0.0)
    edges, open_end, window, ragged = _decide(ask(decides), window, whole, ragged)
    row, *ends, rising = edges
    edges = Edges(row, *refine(ask(decides, row), *ends, tolerance, rising), rising)
    N_first, N_always, islands = stretches(edges, open_end)
    N_half = np.where(np.isnan(N_always), np.nan, balance(edges, N_first.size))
    if highest is not None:
        N_always = np.where(N_always <= highest, N_always, np.nan)
    others = [m for m in (decides.with_step(OTHER_STEP), doubts, better) if m is not None]
    clean = np.where(ragged, np.nan, N_first)
    in_time, *in_space = (_distance(ask(other), clean, tolerance) for other in others)
    chatters = _chatters(scans.device, rows)
    fine = (better or judge or decides).with_step(FINE_STEPS)
    in_fine = _distance(ask(fine), np.where(chatters, clean, np.nan), tolerance)
    in_time = np.fmax(in_time, in_fine)
    # The better level may itself be off by as much.
    near = in_time + np.max(in_space, axis=0) + (in_space[1] if better else 0.0)
    # An island below that finer steps open belongs to the bar.
    below = Window((1 - ISLANDS) * N_first, N_first, np.full(N_first.size, CLOSEST_STEP))
    near = np.fmax(near, N_first - _elsewhere(ask(fine), below, ~ragged & (pace >= RINGS))[0])
    apart = np.isinf(near)
    ragged |= apart
    window = chosen(apart, whole, window)
    found = [_elsewhere(scan_by(other), window, ragged) for other in others]
    wider = window._replace(step=JUDGED_STEP * window.step)
    if judge is not None:
        found.append(_elsewhere(scan_by(judge), wider, ragged))
    seen = _elsewhere(scan_by(fine), wider, ragged & chatters)
    found.append([np.where(chatters, *pair) for pair in zip(seen, (N_first, N_half), strict=True)])
    first_error = np.fmax(_spread(edges, N_first), _farthest(N_first, [one[0] for one in found]))
    half_error = _farthest(N_half, [one[1] for one in found])
    N_error, half_error = (np.where(ragged, far, near) for far in (first_error, half_error))
    resolution = np.where(ragged, window.step, closest) + tolerance
    none = np.where(quiet, NOTHING_SNAPS, NOT_FOLLOWED)
    return Thresholds(
        np.where(np.isnan(N_first), none, FOUND).astype(np.int8),
        bound,
        np.fmax(np.fmax.reduce(wide, axis=1), whole.high),
        N_first,
        N_error + resolution * N_first,
        N_half,
        half_error + resolution * N_half,
        ragged.astype(np.int8),
        N_always,
        *_pulse(ask, decides, rows.f0, N_first, highest, tolerance),
        np.zeros(N_first.size, np.int8),
        np.count_nonzero(np.isfinite(islands[0]), axis=1),
        *islands,
    )


def _pace(device, rows):
    """What the device takes to follow a pulse, over how long that lasts, (rows,)."""
    own, spring = device.own_frequency[rows.device], device.spring[rows.device]
    steepest = np.array([pulse.steepest for pulse in rows.pulses])[rows.pulse]
    C = np.where(device.is_alone[rows.device], 0.0, rows.C)
    return 2e-6 * np.pi * rows.f0 * steepest * (1 / own + C / spring)


def _chatters(device, rows):
    """Whether the mass of a row may chatter on its contact, (rows,)."""
    smooth = np.array([pulse.is_smooth for pulse in rows.pulses])[rows.pulse]
    share = stiffness_share(device)[rows.device]
    return (share > CHATTERS) | ((share > 0) & ~smooth)


def wide_scan(device, static, rows, slow=False) -> np.ndarray:
    """Amplitudes, (rows, n), from below any threshold to far above, also of short pulses.

    static: threshold of slow pulses, (devices,); slow: whether a row's pulse is one, (rows,)
    """
    columns = static, device.own_frequency, device.mass
    static, own, mass = (column[rows.device] for column in columns)
    facts = [
        (one.variation, max(abs(one.impact), LEAST_AREA * one.swing), one.highest)
        for one in rows.pulses
    ]
    variation, area, highest = (column[rows.pulse] for column in np.array(facts).T)
    # A pulse amplifies no more than it varies; a short one must bring a velocity, against damping.
    fast = 1e-6 * np.pi * rows.f0 / (own * area)
    damped = np.divide(rows.C, 2 * own * mass, out=np.zeros(mass.shape), where=mass > 0)
    low = np.where(slow, static / SLOW_REACH, static / (1.5 * np.fmax(variation, 2)))
    # What mostly pulls must do so far more strongly.
    static = static / np.fmax(highest, LEAST_PUSH)
    high = np.where(slow, SLOW_REACH * static, 5 * static * (1 + fast) * (1 + damped))
    return amplitudes(low, high, SCAN_STEP)


def first_seen(ask: Ask, wide: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the first of wide amplitudes, (rows, n), that snaps, and in which rows all are quiet.

    bound: below which nothing can snap, (rows,); down to there it is looked where the lowest snaps
    Returns N, (rows,), NaN where none was found, and bools, (rows,), false where a run failed
    """
    told = ask(wide)
    first = first_snap(wide, np.isfinite(told))[1]
    quiet = np.isnan(told).all(axis=1) & np.isfinite(wide[:, 0])
    begins = np.isfinite(told[:, 0])
    if begins.any():
        lower = amplitudes(np.where(begins, SLACK * bound, np.nan), wide[:, 0], SCAN_STEP)
        first = np.where(begins, first_snap(lower, np.isfinite(ask(lower)))[1], first)
    return first, quiet


def _whole_window(rough, lowest, highest, slow):
    """Where islands are looked for, about the first of wide amplitudes that snaps."""
    top = ABOVE * rough if highest is None else np.fmax(highest, FAR_BESIDE * rough)
    low = np.where(slow, rough / SLOW_BESIDE, BELOW * rough if lowest is None else lowest)
    high = np.where(slow, SLOW_BESIDE * rough, np.where(np.isfinite(rough), top, np.nan))
    return Window(low, high, np.full(rough.size, FINE_STEP))


def _closer_window(ask, whole, rings):
    """Where labels change along N, as the cheapest level sees it, and which rows are ragged.

    A row is ragged where they change more than once; so it is by every level, each in its own way.
    """
    n_rows = whole.low.size
    edges, *_ = scan(ask, whole.N)
    ends = outermost(edges.row, edges.high, n_rows)
    ragged = np.bincount(edges.row, minlength=n_rows) > 1
    clean = around(whole, *ends, BESIDE, np.where(rings, CLOSEST_STEP, FINE_STEP))
    return chosen(ragged, around(whole, *ends, FAR_BESIDE, FINEST_STEP), clean), ragged


def _decide(ask, window, whole, ragged):
    """Edges as the deciding level sees them; whether a row's highest N is quiet; what is ragged.

    Rows in which it sees other than the cheapest level did are ragged too, and scanned on to
    either side.
    """
    edges, begins, ends = scan(ask, window.N)
    surprising = begins | (~ends & (window.high < whole.high))
    surprising |= ~ragged & (np.bincount(edges.row, minlength=ragged.size) != 1)
    low, high = (np.where(surprising, end, np.nan) for end in (window.low, window.high))
    wider = around(whole, low, high, FAR_BESIDE, FINEST_STEP)
    below, begins_below, _ = scan(ask, wider._replace(high=low).N)
    above, _, ends_above = scan(ask, wider._replace(low=high).N)
    begins, ends = np.where(surprising, [begins_below, ends_above], [begins, ends])
    edges = Edges(*(np.concatenate(parts) for parts in zip(below, edges, above, strict=True)))
    edges = Edges(*(column[~begins[edges.row]] for column in edges))
    return edges, ~ends, chosen(surprising, wider, window), ragged | surprising


def _spread(edges, N_first):
    """How far above N_first the last change is that lies close to it."""
    spread = np.zeros(N_first.size)
    above = edges.high - N_first[edges.row]
    close = edges.high <= BESIDE * N_first[edges.row]
    np.fmax.at(spread, edges.row[close], above[close])
    return spread


def _elsewhere(ask, window, ragged):
    """N_first and N_half of ragged rows as another level sees them on the same scan.

    The end of the window beyond which they lie stands for what is not in it.
    """
    N = window._replace(low=np.where(ragged, window.low, np.nan)).N
    edges, begins, _ = scan(ask, N)
    first, _ = outermost(edges.row[edges.rising], edges.high[edges.rising], ragged.size)
    first = np.where(begins, window.low, np.where(np.isnan(first), window.high, first))
    quiet = balance(edges, ragged.size) + np.where(begins, window.low, 0.0)
    ends_quiet = np.bincount(edges.row, 2 * edges.rising - 1.0, ragged.size) + begins < 1
    return first, quiet + np.where(ends_quiet, window.high, 0.0)


def _farthest(N, others):
    """The largest distance of N from what others found."""
    return np.max([abs(N - other) for other in others], axis=0)


def _distance(ask, N_first, tolerance):
    """How far from N_first, at most, another level changes from quiet to snap.

    There and at each of the next LOOKS - 1 doublings it is quiet below and snaps above: where
    labels change back and forth closely, one look is luck.
    """
    distance = np.where(np.isnan(N_first), np.nan, np.inf)
    reach = np.full(N_first.size, tolerance / 4)
    while (left := np.flatnonzero(np.isinf(distance) & (reach < FARTHEST))).size:
        reaches = np.minimum(np.multiply.outer(reach[left], 2.0 ** np.arange(LOOKS)), FARTHEST)
        N = np.full((N_first.size, 2 * LOOKS), np.nan)
        N[left] = N_first[left, np.newaxis] * np.hstack([1 - reaches, 1 + reaches])
        below, above = np.hsplit(np.isfinite(ask(N))[left], 2)
        differ = below | ~above
        passed = np.where(differ.any(axis=1), LOOKS - np.argmax(differ[:, ::-1], axis=1), 0)
        distance[left[passed == 0]] = (reach * N_first)[left[passed == 0]]
        reach[left] *= 2.0**passed
    return distance


def _pulse(ask, decides, f0, N_first, highest, tolerance):
    """N_pulse and t_snap at N_first."""
    t_snap = ask(decides)(N_first[:, np.newaxis])[:, 0]
    N_pulse = N_first.copy()
    late = np.flatnonzero(t_snap * f0 * 1e-6 > 1)
    high = N_first[late] * ABOVE if highest is None else np.fmax(highest, N_first[late])
    in_pulse = ask(decides, late, horizon=0.0)
    N = amplitudes(N_first[late], high, SCAN_STEP)
    N_pulse[late] = refine(in_pulse, *first_snap(N, np.isfinite(in_pulse(N))), tolerance)[1]
    return N_pulse, t_snap

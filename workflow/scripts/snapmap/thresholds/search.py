"""Where labels change along N: scanned, looked for near a guess, and refined, by any model."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import THRESHOLD_TOLERANCE, Settings

SCAN_STEP = 0.03
"""Relative distance of the amplitudes that are tried before any is refined."""
PARTS = 4
"""Of an interval, into which each round of a search cuts it; more cost more runs a digit."""
TOGETHER, AT_ONCE = 8, 256
"""Most places of a row that a walk looks at together, if that are no more than so many in all."""
EXPECTED_WITHIN = 0.004
"""Relative distance within which a threshold is looked for where it is expected."""

Ask = Callable[[np.ndarray], np.ndarray]
"""t_snap of N, (rows, n), us; not finite where a cell does not snap, or N is NaN."""
Label = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""A bool of rows, by number (n,), at places of a grid, (n, m)."""


class Approach(NamedTuple):
    """How near cells come to a snap: t_snap, as `Ask` has it, and the `lowest` w(L/2)."""

    t_snap: np.ndarray
    lowest: np.ndarray


class Edges(NamedTuple):
    """Changes between what snaps and what does not along N; each lies between low and high.

    row: which row; rising: whether it is high that snaps
    """

    row: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rising: np.ndarray

    def take(self, which: np.ndarray) -> "Edges":
        """Take the edges chosen."""
        return Edges(*(column[which] for column in self))


def joined(*edges: Edges) -> Edges:
    """Join edges, one behind the other."""
    return Edges(*map(np.concatenate, zip(*edges, strict=True)))


class Window(NamedTuple):
    """Where each row is scanned, (rows,): from low to high, in multiples of g, in relative steps.

    A row whose ends are NaN is not scanned.
    """

    low: np.ndarray
    high: np.ndarray
    step: np.ndarray

    @property
    def N(self) -> np.ndarray:
        """Amplitudes of the scan, (rows, n); NaN after a row's last."""
        return amplitudes(*self)

    def of(self, rows: np.ndarray) -> "Window":
        """The same of some rows, a mask of them, (rows,)."""
        return self._replace(low=np.where(rows, self.low, np.nan))


class Seen(NamedTuple):
    """What was seen of rows from one N to another: edges, and the labels of the ends, (rows,).

    low, high: these ends, in multiples of g, (rows,); NaN where nothing was looked at
    """

    edges: Edges
    begins: np.ndarray
    ends: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def of(self, rows: np.ndarray) -> "Seen":
        """The same of some rows, a mask of them, (rows,)."""
        low, high = (np.where(rows, end, np.nan) for end in (self.low, self.high))
        edges = self.edges.take(rows[self.edges.row])
        return Seen(edges, rows & self.begins, rows & self.ends, low, high)


def lowest_snap(
    model: Follows,
    rows: Rows,
    bracket: tuple[np.ndarray, np.ndarray],
    settings: Settings,
    tolerance: float = THRESHOLD_TOLERANCE,
    step: float = SCAN_STEP,
) -> np.ndarray:
    """Find the lowest N that snaps, (rows,).

    bracket: multiples of g between which to look, numbers or (rows,)
    step: relative distance of the amplitudes that are tried first
    tolerance: of N, relative; the result is the upper end of an interval that narrow
    NaN where nothing in the bracket snaps, or its lower end does.
    """
    ask = asker(model, rows, settings)
    low, high = (np.broadcast_to(end, rows.f0.shape) for end in bracket)
    N = amplitudes(low, high, step)
    return refine(ask, *first_snap(N, np.isfinite(ask(N))), tolerance)[1]


def asker(model: Follows, rows: Rows, settings: Settings, until: str = "edge") -> Ask:
    """Make a function that tells when the cells of rows snap.

    until: "edge" or "snap", as in `settings.QUESTION`
    It gives -inf where no run of a cell can be believed.
    """
    observe = observer(model, rows, settings, until)
    return lambda N: observe(N).t_snap


def observer(
    model: Follows, rows: Rows, settings: Settings, until: str = "edge"
) -> Callable[[np.ndarray], Approach]:
    """Make a function of N, (rows, n), that tells how near their cells come to a snap."""
    settings = settings._replace(until=until, repeat=False)

    def observe(N):
        known = np.isfinite(N)
        runs = model.follow(rows.cells(model.device, N, settings.horizon).take(known), settings)
        lost = np.isnan(runs.t_snap) & ~(runs.energy_error <= settings.energy_tolerance)
        t_snap, lowest = np.full((2, *N.shape), np.nan)
        t_snap[known], lowest[known] = np.where(lost, -np.inf, runs.t_snap), runs.lowest
        return Approach(t_snap, lowest)

    return observe


def amplitudes(low: np.ndarray, high: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    """Space amplitudes from low to high in relative steps, each (rows,): (rows, n), NaN beyond."""
    factor = np.broadcast_to(1 + np.asarray(step), low.shape)
    count = 2 + int(np.nanmax(np.log(high / low) / np.log(factor), initial=0.0))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.column_stack([low, *[factor] * (count - 1)]), axis=1)
    N = np.minimum(N, high[:, np.newaxis])
    N[:, 1:][N[:, 1:] == N[:, :-1]] = np.nan
    return N


def scan(ask: Ask, N: np.ndarray) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges on ascending N, (rows, n), as `edges_of` does."""
    return edges_of(N, ask(N))


def edges_of(N: np.ndarray, t_snap: np.ndarray) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges on ascending N, (rows, n), and whether the first and the last N of a row snap.

    t_snap: as `Ask` has it. The edges of a row ascend; N may be NaN after its last.
    """
    snapped, known = np.isfinite(t_snap), np.isfinite(N)
    row, k = np.nonzero((snapped[:, 1:] != snapped[:, :-1]) & known[:, 1:])
    last = np.maximum(np.count_nonzero(known, axis=1) - 1, 0)
    edges = Edges(row, N[row, k], N[row, k + 1], snapped[row, k + 1])
    return edges, snapped[:, 0], snapped[np.arange(len(N)), last]


def scan_on(ask: Ask, window: Window, seen: Seen) -> Seen:
    """Scan a window on either side of what was seen of rows, or all of it where nothing was."""
    low, high, step = window
    new = np.isnan(seen.low)
    below = Window(np.where(seen.low <= low, np.nan, low), np.where(new, high, seen.low), step)
    above = Window(np.where(high > seen.high, seen.high, np.nan), high, step)
    lower, begins, ends = scan(ask, below.N)
    upper, _, ends_above = scan(ask, above.N)
    down, up = np.isfinite(below.low), np.isfinite(above.low)
    return Seen(
        edges=joined(lower, seen.edges, upper),
        begins=np.where(down, begins, seen.begins),
        ends=np.where(up, ends_above, np.where(new, ends, seen.ends)),
        low=np.where(down, low, seen.low),
        high=np.where(up | new, high, seen.high),
    )


def around(
    limits: Window, first: np.ndarray, last: np.ndarray, reach: float, step: float
) -> Window:
    """Make a window that reaches so many times beyond two N of each row, within limits."""
    low, high = np.maximum(limits.low, first / reach), np.minimum(limits.high, last * reach)
    return Window(low, high, np.full(low.size, step))


def outermost(row: np.ndarray, N: np.ndarray, n_rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the least and the largest N of each row, (n_rows,); NaN where there is none."""
    least, largest = np.full((2, n_rows), np.nan)
    np.fmin.at(least, row, N)
    np.fmax.at(largest, row, N)
    return least, largest


def stretches(edges: Edges, is_open: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Read N_first and N_always, (rows,), and the islands' ends, (2, rows, most), off the edges.

    is_open: whether a row's highest N does not snap, so that nothing always does; (rows,)
    """
    n_rows = is_open.size
    row, starts = edges.row[edges.rising], edges.high[edges.rising]
    N_first, N_always = outermost(row, starts, n_rows)
    ends_row, ends = edges.row[~edges.rising], edges.low[~edges.rising]
    most = np.bincount(ends_row, minlength=1).max()
    islands = np.full((2, n_rows, most), np.nan)
    for i in np.unique(ends_row):
        to = np.sort(ends[ends_row == i])
        islands[0, i, : to.size] = np.sort(starts[row == i])[: to.size]
        islands[1, i, : to.size] = to
    return N_first, np.where(is_open, np.nan, N_always), islands


def first_snap(N: np.ndarray, snapped: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the interval below the first of ascending N, (rows, n), that snaps; NaN if none."""
    first = np.argmax(snapped, axis=1)
    rows = np.arange(len(N))
    inside = snapped[rows, first] & (first > 0)
    low, high = (np.where(inside, N[rows, end], np.nan) for end in (first - 1, first))
    return low, high


def refine(
    ask: Ask,
    low: np.ndarray,
    high: np.ndarray,
    tolerance: float,
    rising: np.ndarray | bool = True,
) -> tuple[np.ndarray, np.ndarray]:
    """Narrow intervals, (rows,), between what snaps and what does not, to neighbouring places.

    rising: whether it is `high` that snaps, (rows,)
    The places are those of a lattice in relative steps of `tolerance` or less, the same for all
    rows: a change that is alone has the same place wherever it was looked for.
    """
    low, high, size = np.array(low), np.array(high), lattice_size(tolerance)
    rising = np.broadcast_to(rising, low.shape)[:, np.newaxis]
    while True:
        first, last = place_of(low, size, np.floor) + 1, place_of(high, size, np.ceil) - 1
        wide = np.flatnonzero(first <= last)
        if not wide.size:
            return low, high
        cuts = np.multiply.outer(last[wide] - first[wide] + 2, np.arange(1, PARTS)) // PARTS
        places = first[wide, np.newaxis] - 1 + np.maximum(cuts, 1)
        N = np.full((low.size, PARTS - 1), np.nan)
        N[wide] = amplitude_at(places, size)
        as_high = (np.isfinite(ask(N)) == rising)[wide]
        ends = np.zeros((wide.size, 1), bool)
        N = np.column_stack([low[wide], N[wide], high[wide]])
        low[wide], high[wide] = first_snap(N, np.hstack([ends, as_high, ~ends]))


def lattice_size(tolerance: float) -> int:
    """Choose how many places a lattice has from 2^n to 2^(n + 1): relative steps no wider."""
    return 2 ** (1 - math.frexp(tolerance)[1])


def place_of(N: np.ndarray, size: int, rounding: Callable = np.ceil) -> np.ndarray:
    """Find the place of a lattice next to N, upwards or downwards; (n,), far below for NaN."""
    share, exponent = np.frexp(np.where(np.isnan(N), 0.0, N))
    return exponent * np.int64(size) + rounding((2 * share - 1) * size).astype(np.int64)


def amplitude_at(place: np.ndarray, size: int) -> np.ndarray:
    """Give the amplitude at places of a lattice."""
    exponent, steps = np.divmod(place, size)
    return np.ldexp(0.5 + steps / (2 * size), exponent.astype(np.int32))


def near(
    label: Label,
    rows: np.ndarray,
    guess: np.ndarray,
    size: int,
    low: np.ndarray | None = None,
    high: np.ndarray | None = None,
) -> np.ndarray:
    """Find the first place of a grid of `size` at which labels that change once are true, (rows,).

    rows: their numbers, as the label takes them
    guess: a place, at which and below which it is looked first, and then ever farther away, (rows,)
    low, high: places known to be false and true; before the first and beyond the last unless given
    Returns 0 where all are true, and `size` where none is.
    """
    low = np.full(guess.size, -1) if low is None else low.copy()
    high = np.full(guess.size, size) if high is None else high.copy()
    probes, reach = np.clip(np.add.outer(guess, [-1, 0]), 0, size - 1), np.arange(1, PARTS)
    while (left := np.flatnonzero(high - low > 1)).size:
        at = probes[left]
        true = label(rows[left], at)
        high[left] = np.minimum(high[left], np.where(true, at, size).min(axis=1))
        false = ~true & (at < high[left, np.newaxis])
        low[left] = np.maximum(low[left], np.where(false, at, -1).max(axis=1))
        below, above = low[:, np.newaxis], high[:, np.newaxis]
        between = below + np.maximum((above - below) * np.arange(1, PARTS) // PARTS, 1)
        downward = np.where(below < 0, np.maximum(above - reach[::-1], 0), between)
        upward = (above == size) & (below >= 0)
        probes = np.where(upward, np.minimum(below + reach, size - 1), downward)
        reach = PARTS * reach
    return high


def walk(
    label: Label, rows: np.ndarray, start: np.ndarray | int, stop: np.ndarray | int, step: int = 1
) -> np.ndarray:
    """Find the first place, from `start` on in steps, at which a label is true, (rows,).

    rows: as for `near`
    stop: where to end, which stands where no label is; a few places beyond are looked at, too
    """
    place = np.array(np.broadcast_to(start, rows.shape))
    stop = np.broadcast_to(stop, rows.shape)
    left = np.flatnonzero(place < stop)
    most = 1
    while left.size:
        together = np.clip(AT_ONCE // left.size, 1, most)
        places = place[left, np.newaxis] + step * np.arange(together)
        true = label(rows[left], places)
        hit = true.any(axis=1)
        place[left] += step * np.where(hit, np.argmax(true, axis=1), together)
        left = left[~hit & (place[left] < stop[left])]
        most = min(2 * most, TOGETHER)
    return np.minimum(place, stop)


def nearby(
    model: Follows, rows: Rows, settings: Settings, expected: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps where it is expected, (rows,); NaN where labels are others.

    The place below it, which does not, comes first. N stands on the lattice of `refine`.
    """
    size = lattice_size(tolerance)
    known, reach = np.flatnonzero(np.isfinite(expected)), math.ceil(2 * size * EXPECTED_WITHIN)
    first = place_of(expected[known], size) - reach

    def label(which, places):
        N = amplitude_at(first[which, np.newaxis] + places, size)
        return np.isfinite(asker(model, rows.take(known[which]), settings)(N))

    place = near(label, np.arange(known.size), np.full(known.size, reach), 2 * reach)
    inside = (place > 0) & (place < 2 * reach)
    place = (first + place)[inside]
    ends = np.full((2, expected.size), np.nan)
    ends[:, known[inside]] = amplitude_at(place - 1, size), amplitude_at(place, size)
    return ends[0], ends[1]

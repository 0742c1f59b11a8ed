"""Changes of label along N: any model scans for them, seeks them near a guess, or refines them."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import THRESHOLD_TOLERANCE, Run

SCAN_STEP = 0.03
"""Relative step of the amplitudes in a first scan."""
PARTS = 4
"""Number of parts into which each round of a search cuts an interval; more parts cost more runs."""
TOGETHER, AT_ONCE = 8, 256
"""Most places of one row, and of all rows, that `walk` tries at once."""
EXPECTED_WITHIN = 0.004
"""Relative distance from an expected threshold within which it is sought."""

Ask = Callable[[np.ndarray], np.ndarray]
"""A function from N to t_snap, us, both (rows, n); NaN where a cell does not snap or N is NaN, -inf
where no run of a cell can be believed."""
Label = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""A function from numbers of rows, (n,), and places on a grid, (n, m), to bools, (n, m)."""


class Approach(NamedTuple):
    """How near cells come to a snap: t_snap, us, as `Ask` gives it, and the lowest w(L/2), um."""

    t_snap: np.ndarray
    lowest: np.ndarray


class Edges(NamedTuple):
    """Changes of label along N, each between two amplitudes; all (edges,).

    row: number of the row; low, high: multiples of g; rising: whether the cell at high snaps
    """

    row: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rising: np.ndarray

    def take(self, which: np.ndarray) -> "Edges":
        """Take some edges, by a mask or indices."""
        return Edges(*(column[which] for column in self))


def joined(*edges: Edges) -> Edges:
    """Join several groups of edges into one."""
    return Edges(*map(np.concatenate, zip(*edges, strict=True)))


class Window(NamedTuple):
    """Where each row is scanned, (rows,): from low to high, multiples of g, in relative steps.

    A row with an end that is NaN is not scanned.
    """

    low: np.ndarray
    high: np.ndarray
    step: np.ndarray

    @property
    def N(self) -> np.ndarray:
        """Amplitudes of the scan, (rows, n); NaN after a row's last."""
        return amplitudes(*self)

    def of(self, rows: np.ndarray) -> "Window":
        """Leave out all rows but those of a mask, (rows,)."""
        return self._replace(low=np.where(rows, self.low, np.nan))


class Seen(NamedTuple):
    """What is known of rows between two N: the edges, and the labels at both ends.

    begins, ends: whether the row snaps at low, and at high, (rows,)
    low, high: the two N, multiples of g, (rows,); NaN where nothing is known
    """

    edges: Edges
    begins: np.ndarray
    ends: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def of(self, rows: np.ndarray) -> "Seen":
        """Forget all rows but those of a mask, (rows,)."""
        low, high = (np.where(rows, end, np.nan) for end in (self.low, self.high))
        edges = self.edges.take(rows[self.edges.row])
        return Seen(edges, rows & self.begins, rows & self.ends, low, high)


def nothing_seen(n_rows: int) -> Seen:
    """Tell that nothing is known of rows."""
    edges, labels = Edges(*np.zeros((3, 0)), np.zeros(0, bool)), np.zeros(n_rows, bool)
    edges = edges._replace(row=edges.row.astype(int))
    return Seen(edges, labels, labels, *np.full((2, n_rows), np.nan))


def lowest_snap(
    model: Follows,
    rows: Rows,
    bracket: tuple[np.ndarray, np.ndarray],
    settings: Run,
    tolerance: float = THRESHOLD_TOLERANCE,
    step: float = SCAN_STEP,
) -> np.ndarray:
    """Find the lowest N that snaps, multiples of g, (rows,).

    bracket: lowest and highest N to try, numbers or (rows,)
    tolerance: relative width of the interval whose upper end is returned
    step: relative step of the amplitudes that are tried first
    Gives NaN where nothing in the bracket snaps, or its lower end does.
    """
    ask = asker(model, rows, settings)
    low, high = (np.broadcast_to(end, rows.f0.shape) for end in bracket)
    N = amplitudes(low, high, step)
    return refine(ask, *first_snap(N, np.isfinite(ask(N))), tolerance)[1]


def asker(model: Follows, rows: Rows, settings: Run, until: str = "edge") -> Ask:
    """Make the function that tells when cells of rows snap; until: as in `settings.QUESTION`."""
    observe = observer(model, rows, settings, until)
    return lambda N: observe(N).t_snap


def observer(
    model: Follows, rows: Rows, settings: Run, until: str = "edge"
) -> Callable[[np.ndarray], Approach]:
    """Make the function of N, (rows, n), that tells how near cells come to a snap."""
    settings = settings.but(until=until, repeat=False)

    def observe(N):
        known, t_snap, lowest = np.isfinite(N), *np.full((2, *N.shape), np.nan)
        if not known.any():
            return Approach(t_snap, lowest)
        runs = model.follow(rows.cells(model.device, N, settings.horizon).take(known), settings)
        lost = np.isnan(runs.t_snap) & ~(runs.energy_error <= settings.energy_tolerance)
        t_snap[known], lowest[known] = np.where(lost, -np.inf, runs.t_snap), runs.lowest
        return Approach(t_snap, lowest)

    return observe


def amplitudes(low: np.ndarray, high: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    """Space N from low to high in relative steps, each (rows,): (rows, n), NaN at a row's end."""
    factor = np.broadcast_to(1 + np.asarray(step), low.shape)
    count = 2 + int(np.nanmax(np.log(high / low) / np.log(factor), initial=0.0))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.column_stack([low, *[factor] * (count - 1)]), axis=1)
    N = np.minimum(N, high[:, np.newaxis])
    N[:, 1:][N[:, 1:] == N[:, :-1]] = np.nan
    return N


def scan(ask: Ask, N: np.ndarray) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Run ascending N, (rows, n), and find what `edges_of` finds."""
    return edges_of(N, ask(N))


def edges_of(N: np.ndarray, t_snap: np.ndarray) -> tuple[Edges, np.ndarray, np.ndarray]:
    """Find the edges, in ascending order, and whether the first and the last N of each row snap.

    N: ascending, (rows, n), NaN behind the last of a row; t_snap: as `Ask` gives it
    """
    snapped, known = np.isfinite(t_snap), np.isfinite(N)
    row, k = np.nonzero((snapped[:, 1:] != snapped[:, :-1]) & known[:, 1:])
    last = np.maximum(np.count_nonzero(known, axis=1) - 1, 0)
    edges = Edges(row, N[row, k], N[row, k + 1], snapped[row, k + 1])
    return edges, snapped[:, 0], snapped[np.arange(len(N)), last]


def scan_on(ask: Ask, window: Window, seen: Seen) -> Seen:
    """Scan the parts of a window below and above what was seen, or all where nothing was."""
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
    """Make the window from first / reach to last * reach, (rows,), within limits."""
    low, high = np.maximum(limits.low, first / reach), np.minimum(limits.high, last * reach)
    return Window(low, high, np.full(low.size, step))


def outermost(row: np.ndarray, N: np.ndarray, n_rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the least and the largest N of each row, (n_rows,), NaN for rows without; row: of N."""
    least, largest = np.full((2, n_rows), np.nan)
    np.fmin.at(least, row, N)
    np.fmax.at(largest, row, N)
    return least, largest


def stretches(edges: Edges, is_open: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Read N_first and N_always, (rows,), and the ends of islands, (2, rows, most), off the edges.

    is_open: whether the highest N of a row does not snap, so that there is no N_always, (rows,)
    """
    n_rows = is_open.size
    rising, falling = edges.take(edges.rising), edges.take(~edges.rising)
    N_first, N_always = outermost(rising.row, rising.high, n_rows)
    most = np.bincount(falling.row, minlength=1).max()
    islands = np.full((2, n_rows, most), np.nan)
    for i in np.unique(falling.row):
        ends = np.sort(falling.low[falling.row == i])
        islands[0, i, : ends.size] = np.sort(rising.high[rising.row == i])[: ends.size]
        islands[1, i, : ends.size] = ends
    return N_first, np.where(is_open, np.nan, N_always), islands


def first_snap(N: np.ndarray, snapped: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the interval below the first of ascending N, (rows, n), that snaps; NaN for none."""
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
    """Narrow intervals with a change of label, low and high (rows,), to neighbouring places.

    rising: whether `high` snaps, (rows,); else `low` does
    The places are those of a lattice in relative steps of `tolerance` or less, the same for all
    rows: a single change has the same place whatever interval it was sought in.
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
    """Choose the number of lattice places from 2^n to 2^(n + 1), for steps within a tolerance."""
    return 1 << (1 - math.frexp(tolerance)[1])


def place_of(N: np.ndarray, size: int, rounding: Callable = np.ceil) -> np.ndarray:
    """Find the places of a lattice at N or above; with np.floor, at N or below; NaN counts as 0."""
    share, exponent = np.frexp(np.where(np.isnan(N), 0.0, N))
    return exponent * np.int64(size) + rounding((2 * share - 1) * size).astype(np.int64)


def amplitude_at(place: np.ndarray, size: int) -> np.ndarray:
    """Give N at places of a lattice of `size` places an octave."""
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
    """Find the first place at which labels, which change once along a grid, are true, (rows,).

    rows: numbers of rows, as `label` takes them; size: number of places of the grid
    guess: where the search begins, to go ever farther away, (rows,)
    low, high: places known to be false and true, (rows,); by default outside of the grid
    Returns 0 where all labels are true, and `size` where none is.
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
    """Find the first place from `start` on, in steps, at which a label is true, (rows,).

    rows: numbers of rows, as `label` takes them
    stop: the place to end at, returned where no label is true; a few places beyond are tried, too
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
    model: Follows, rows: Rows, settings: Run, expected: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find a threshold close to where it is expected, between two neighbours on `refine`'s lattice.

    expected: multiples of g, (rows,), NaN for rows that are skipped
    Returns low, which does not snap, and high, which does, (rows,); NaN where no change is near.
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

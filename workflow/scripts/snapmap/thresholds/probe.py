"""Rows under a model, asked at any N, and the search for a single change of label along N."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import THRESHOLD_TOLERANCE, Run
from .effort import PARTS, SCAN_STEP, TOGETHER

AT_ONCE = 256
"""Most places of all rows that `walk` tries at once."""
EXPECTED_WITHIN = 0.004
"""Relative distance from an expected threshold within which it is sought."""

Ask = Callable[[np.ndarray], np.ndarray]
"""A function from N to t_snap, us, both (rows, n); NaN where a cell does not snap or N is NaN, -inf
where no run of a cell can be believed. A `Probe` is one."""
Label = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""A function from numbers of rows, (n,), and places on a grid, (n, m), to bools, (n, m)."""


class Approach(NamedTuple):
    """How near cells come to a snap: t_snap, us, as `Ask` gives it, and the lowest w(L/2), um."""

    t_snap: np.ndarray
    lowest: np.ndarray


class Probe(NamedTuple):
    """Rows under a model, asked at any N; a call tells when they snap, as `Ask` does.

    until: as in `settings.QUESTION`, whatever the settings say
    """

    model: Follows
    rows: Rows
    settings: Run
    until: str = "edge"

    def __call__(self, N: np.ndarray) -> np.ndarray:
        """Give t_snap, us, at N, both (rows, n)."""
        return self.observe(N).t_snap

    def snaps(self, N: np.ndarray) -> np.ndarray:
        """Tell whether rows snap at N, both (rows, n)."""
        return np.isfinite(self(N))

    def observe(self, N: np.ndarray) -> Approach:
        """Tell how near cells come to a snap at N, (rows, n)."""
        known, (t_snap, lowest) = np.isfinite(N), np.full((2, *N.shape), np.nan)
        if not known.any():
            return Approach(t_snap, lowest)
        settings = self.settings.but(until=self.until, repeat=False)
        cells = self.rows.cells(self.model.device, N, settings.horizon).take(known)
        runs = self.model.follow(cells, settings)
        lost = np.isnan(runs.t_snap) & ~(runs.energy_error <= settings.energy_tolerance)
        t_snap[known], lowest[known] = np.where(lost, -np.inf, runs.t_snap), runs.lowest
        return Approach(t_snap, lowest)

    def take(self, which: np.ndarray | slice) -> "Probe":
        """Take some rows, by a mask, indices or a slice."""
        return self._replace(rows=self.rows.take(which))


def lowest_snap(
    probe: Probe,
    bracket: tuple[np.ndarray, np.ndarray],
    tolerance: float = THRESHOLD_TOLERANCE,
    step: float = SCAN_STEP,
) -> np.ndarray:
    """Find the lowest N that snaps, multiples of g, (rows,).

    bracket: lowest and highest N to try, numbers or (rows,)
    tolerance: relative width of the interval whose upper end is returned
    step: relative step of the amplitudes that are tried first
    Gives NaN where nothing in the bracket snaps, or its lower end does.
    """
    low, high = (np.broadcast_to(end, probe.rows.f0.shape) for end in bracket)
    N = amplitudes(low, high, step)
    return refine(probe, *first_snap(N, probe.snaps(N)), tolerance)[1]


def amplitudes(low: np.ndarray, high: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    """Space N from low to high in relative steps, each (rows,): (rows, n), NaN at a row's end."""
    factor = np.broadcast_to(1 + np.asarray(step), low.shape)
    count = 2 + int(np.nanmax(np.log(high / low) / np.log(factor), initial=0.0))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.column_stack([low, *[factor] * (count - 1)]), axis=1)
    N = np.minimum(N, high[:, np.newaxis])
    N[:, 1:][N[:, 1:] == N[:, :-1]] = np.nan
    return N


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
    known: tuple[np.ndarray, np.ndarray] | None = None,
) -> np.ndarray:
    """Find the first place at which labels, which change once along a grid, are true, (rows,).

    rows: numbers of rows, as `label` takes them; size: number of places of the grid
    guess: where the search begins, to go ever farther away, (rows,)
    known: places known to be false, and to be true, (rows,); by default outside of the grid
    Returns 0 where all labels are true, and `size` where none is.
    """
    outside = np.full(guess.size, -1), np.full(guess.size, size)
    low, high = (place.copy() for place in known or outside)
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
        upward = above == size
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
    place, stop = (np.array(np.broadcast_to(end, rows.shape)) for end in (start, stop))
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


def nearby(probe: Probe, expected: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find a threshold close to where it is expected, between two neighbours on `refine`'s lattice.

    expected: multiples of g, (rows,), NaN for rows that are skipped
    Returns low, which does not snap, and high, which does, (rows,); NaN where no change is near.
    """
    size = lattice_size(tolerance)
    known, reach = np.flatnonzero(np.isfinite(expected)), math.ceil(2 * size * EXPECTED_WITHIN)
    first = place_of(expected[known], size) - reach

    def label(which, places):
        N = amplitude_at(first[which, np.newaxis] + places, size)
        return probe.take(known[which]).snaps(N)

    place = near(label, np.arange(known.size), np.full(known.size, reach), 2 * reach)
    inside = (place > 0) & (place < 2 * reach)
    place = (first + place)[inside]
    ends = np.full((2, expected.size), np.nan)
    ends[:, known[inside]] = amplitude_at(place - 1, size), amplitude_at(place, size)
    return ends[0], ends[1]

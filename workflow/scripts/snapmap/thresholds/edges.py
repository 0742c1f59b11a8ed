"""Changes of label along N: scans see them, and what is known of rows grows from scan to scan."""

from typing import NamedTuple

import numpy as np

from .probe import Ask, amplitudes


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
    limits: Window, first: np.ndarray, last: np.ndarray, reach: float, step: float | np.ndarray
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

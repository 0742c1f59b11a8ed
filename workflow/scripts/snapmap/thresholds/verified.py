"""Surfaces of thresholds: a few rows are searched; they predict the others, which are verified."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..pulse.pulse import blow_at
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..study.axes import NAMES, Grid
from .probe import Probe, nearby
from .search import Search, is_fast, is_ringing, is_single, look_closely
from .survey import FOUND, survey, with_rows

SURFACE_POINTS = 8
"""Least number of points on an axis along which thresholds are a surface."""
SPACING, MOST_INTERVALS = 5, 8
"""Points from one searched row to the next along an axis, and most such intervals, at first."""
CUBIC_POINTS = 4
"""Number of searched rows along an axis that determine a cubic."""
WITHIN = 1e-3
"""Largest relative distance of a threshold from its prediction, but at least its tolerance."""
QUIET_AT, SNAPS_AT = (0.7, 0.8, 0.87, 0.92, 0.95, 0.965), (1.005, 1.02, 1.05, 1.1, 1.2, 1.4, 1.9)
"""N over the prediction at which a row must not snap, and must snap."""
ROWS = 4096
"""Number of rows that are searched together; each takes some 70 kB."""

Part = tuple[np.ndarray, Sequence[np.ndarray]]
"""Surfaces of rows: their numbers, (surfaces, n_1, ..., n_d), -1 for none, and d ascending axes."""


class Expected(NamedTuple):
    """Facts of rows that were searched, or are predicted between those; all (rows,).

    N: threshold, multiples of g; bar: its relative error; level: index of the models that decide
    clean: whether the row may predict others
    """

    N: np.ndarray
    bar: np.ndarray
    level: np.ndarray
    clean: np.ndarray


def find_thresholds(search: Search, parts: Sequence[Part]) -> dict[str, np.ndarray]:
    """Find the thresholds of all rows; returns variables by name, (rows, ...).

    parts: surfaces, as `surfaces` returns them
    """
    columns, rows = {}, search.rows

    def add(which, new):
        for key, values in new.items():
            columns[key] = with_rows(rows.f0.size, which, values, columns.get(key))

    def search_rows(which):
        # The first search makes the columns, even if it is of no rows.
        for block in _blocks(which) if which.size or not columns else []:
            new = survey(search.take(block))
            add(block, new._asdict() | {"verified": np.zeros(block.size, np.int8)})
        N = columns["N_first"][which]
        clean = (columns["ragged"][which] == 0) & (columns["islands"][which] == 0)
        bar, level = columns["N_error"][which] / N, columns["level"][which]
        return Expected(N=N, bar=bar, level=level, clean=np.isfinite(N) & clean)

    def verify(which, expected):
        holds = np.zeros(which.size, bool)
        for block in _blocks(np.arange(which.size)):
            near = Expected(*(values[block] for values in expected))
            new = _verify(search.take(which[block]), near)
            holds[block] = verified = np.isfinite(new["N_first"])
            add(which[block][verified], {key: values[verified] for key, values in new.items()})
        return holds

    search_rows(np.flatnonzero(off_surfaces(rows.device >= 0, parts)))
    for part in parts:
        fill(*part, search_rows, verify)
    if any(pulse.blows.size for pulse in rows.pulses):
        columns["blow"] = blow_at(rows.pulses, rows.pulse, columns["t_snap"] * rows.f0 * 1e-6)
    most = columns["islands"].max(initial=0)
    return columns | {key: columns[key][:, :most] for key in ("island_from", "island_to")}


def _blocks(rows):
    return np.split(rows, range(ROWS, rows.size, ROWS))


def _verify(search, expected):
    """Verify thresholds where they are expected; returns variables by name, (rows, ...).

    N_first is NaN where no threshold is within WITHIN of the expected one. Variables of ragged rows
    and islands are left out, and so stay 0 or NaN.
    """
    models, rows, tolerance = search.models, search.rows, search.tolerance
    N_first, t_snap = np.full((2, rows.f0.size), np.nan)
    fast, finest = is_fast(models.decides.device, rows), len(models.levels) - 1
    level_of = np.maximum(expected.level, np.minimum(fast, finest))
    for number, level in enumerate(models.levels):
        which = np.flatnonzero(level_of == number)
        part, N = search.take(which), expected.N[which]
        probe = part.probe(level.decides)
        N = np.where(expected_labels(probe, N), N, np.nan)
        seen = look_closely(probe, part.rings, *nearby(probe, N, tolerance))
        single = seen.edges.take(is_single(seen.edges, seen.begins)[seen.edges.row])
        first = np.full(N.size, np.nan)
        first[single.row] = single.high
        holds = abs(first - N) <= max(WITHIN, tolerance) * N
        N_first[which] = N = np.where(holds, first, np.nan)
        t_snap[which] = probe(N[:, np.newaxis])[:, 0]
    top = np.inf if search.highest is None else search.highest
    return {
        "status": np.full(rows.f0.size, FOUND, np.int8),
        "N_bound": least_amplitudes(models.decides, rows, search.settings.start),
        "N_looked": expected.N * SNAPS_AT[-1],
        "N_first": N_first,
        "N_error": (expected.bar + tolerance) * N_first + abs(N_first - expected.N),
        "N_always": np.where(N_first <= top, N_first, np.nan),
        "t_snap": t_snap,
        "level": level_of.astype(np.int8),
        "verified": np.ones(rows.f0.size, np.int8),
    }


def expected_labels(probe: Probe, expected: np.ndarray) -> np.ndarray:
    """Tell whether rows are quiet at all of QUIET_AT and snap at all of SNAPS_AT, (rows,)."""
    N = np.multiply.outer(expected, QUIET_AT + SNAPS_AT)
    quiet, snapping = np.hsplit(probe(N), [len(QUIET_AT)])
    return np.isnan(quiet).all(axis=1) & np.isfinite(snapping).all(axis=1)


def split_rows(grid: Grid, rows: Rows) -> tuple[list[Part], np.ndarray]:
    """Find the surfaces of a grid, and which of its rows are searched at first, (rows,).

    The thresholds of the other rows are expected between those, and verified.
    """
    exists = rows.device >= 0
    rings = exists & is_ringing(grid.device, rows)
    slow = ~rings.reshape(-1, grid.axes["f0"].size).any(axis=0)
    numbers = np.where(exists, np.arange(exists.size), -1)
    parts = surfaces(grid.axes, numbers.reshape(grid.shape), slow)
    searched = off_surfaces(exists, parts)
    searched[initial_rows(parts)] = True
    return parts, searched


def off_surfaces(exists: np.ndarray, parts: Sequence[Part]) -> np.ndarray:
    """Tell which rows exist but lie on no surface, (rows,)."""
    alone = exists.copy()
    for numbers, _ in parts:
        alone[numbers[numbers >= 0]] = False
    return alone


def surfaces(axes: Mapping[str, np.ndarray], rows: np.ndarray, slow: np.ndarray) -> list[Part]:
    """Split a grid into surfaces, by the values of its axes alone.

    axes: values by name; rows: numbers of rows, in the shape of the axes
    slow: for each f0, whether thresholds are smooth along f0 there
    Returns a part for slow pulses and one for others.
    """
    apart = []
    for is_slow in (True, False):
        part, kept = rows, {}
        for place, (key, values) in enumerate(axes.items()):
            if key in NAMES:
                continue
            order = np.argsort(values)
            if key == "f0":
                order = order[slow[order] == is_slow]
            part = part.take(order, place)
            if order.size >= SURFACE_POINTS and (is_slow or key != "f0"):
                kept[place] = values[order]
        if kept and part.size:
            part = np.moveaxis(part, list(kept), range(-len(kept), 0))
            sizes = (values.size for values in kept.values())
            apart.append((part.reshape(-1, *sizes), list(kept.values())))
    return apart


def fill(
    rows: np.ndarray,
    axes: Sequence[np.ndarray],
    search: Callable[[np.ndarray], Expected],
    verify: Callable[[np.ndarray, Expected], np.ndarray],
) -> None:
    """Search some rows of surfaces, verify those between, and search where that fails.

    rows: numbers of rows, (surfaces, n_1, ..., n_d), -1 for none; axes: ascending values, (n_1,)...
    search: searches rows by their numbers, (n,)
    verify: takes numbers of rows and predictions, and returns which of these hold, (n,)
    Intervals between searched rows are halved until all rows are searched or verified. Only rows
    between clean corners are verified.
    """
    surface = Surface(rows, axes)
    while surface.left.any():
        surface.search(search)
        surface.verify(verify)
        surface.halvings += 1


class Surface:
    """Rows on a grid that are searched at corners of intervals, and verified between them.

    rows, axes: as for `fill`; left: whether a row is unknown yet; known: facts of all other rows
    halvings: how often the first intervals between corners have been halved
    cubic: prediction of N by the rows that were searched first
    """

    def __init__(self, rows: np.ndarray, axes: Sequence[np.ndarray]):
        self.rows, self.axes, self.halvings, self.cubic = rows, axes, 0, None
        self.left = rows >= 0
        self.known = Expected(*(np.full(rows.shape, blank) for blank in (np.nan, np.nan, 0, False)))

    def corners(self) -> tuple[list, list]:
        """Find the corners around the rows that are left, and their shares, as `_corners` does."""
        return _corners(np.nonzero(self.left), self.axes, self.places())

    def places(self) -> list[np.ndarray]:
        """Give the places on each axis at which rows are searched by now."""
        return [_places(x, self.halvings) for x in self.axes]

    def search(self, search: Callable[[np.ndarray], Expected]) -> None:
        """Search the corners that are left."""
        needed = np.zeros(self.rows.shape, bool)
        for corner in self.corners()[0]:
            needed[corner] = True
        needed &= self.left
        self._keep(needed, search(self.rows[needed]))
        if self.cubic is None:
            self.cubic = _cubic(self.known.N, self.axes, self.places())

    def verify(self, verify: Callable[[np.ndarray, Expected], np.ndarray]) -> None:
        """Verify rows between clean corners; the corners correct the prediction of the cubic."""
        corners, shares = self.corners()
        clean = np.all([self.known.clean[corner] for corner in corners], axis=0)
        which = tuple(index[clean] for index in np.nonzero(self.left))
        corners = [tuple(index[clean] for index in corner) for corner in corners]
        correction = sum(
            share[clean] * (self.known.N[corner] / self.cubic[corner])
            for share, corner in zip(shares, corners, strict=True)
        )
        expected = Expected(
            N=self.cubic[which] * correction,
            bar=np.max([self.known.bar[corner] for corner in corners], axis=0),
            level=np.max([self.known.level[corner] for corner in corners], axis=0),
            clean=clean[clean],
        )
        holds = verify(self.rows[which], expected)
        which = tuple(index[holds] for index in which)
        self._keep(which, [values[holds] for values in expected])

    def _keep(self, which, values):
        """Keep facts of rows, which then are known."""
        self.left[which] = False
        for column, value in zip(self.known, values, strict=True):
            column[which] = value


def initial_rows(parts: Sequence[Part]) -> np.ndarray:
    """Give the numbers of the rows of surfaces that `fill` searches in any case, (n,)."""
    first = [
        rows[np.ix_(range(len(rows)), *(_places(x, 0) for x in axes))].ravel()
        for rows, axes in parts
    ]
    numbers = np.concatenate([np.empty(0, int), *first])
    return numbers[numbers >= 0]


def _places(x, halvings):
    """Choose the places of an axis at which rows are searched after so many halvings."""
    parts = min(max((x.size - 1) // SPACING, CUBIC_POINTS - 1), MOST_INTERVALS) << halvings
    return np.arange(parts + 1) * (x.size - 1) // parts if parts < x.size else np.arange(x.size)


def _corners(where, axes, places):
    """Find the 2^d corners around rows, with indices `where`, and the linear share of each."""
    corners, shares = [where[:1]], [np.ones(where[0].size)]
    for index, x, at in zip(where[1:], axes, places, strict=True):
        low, high = at[np.searchsorted(at, index, "right") - 1], at[np.searchsorted(at, index)]
        share = (x[index] - x[low]) / np.where(high > low, x[high] - x[low], 1.0)
        sides = (low, 1 - share), (high, share)
        pairs = list(product(zip(corners, shares, strict=True), sides))
        corners = [(*corner, end) for (corner, _), (end, _) in pairs]
        shares = [share * part for (_, share), (_, part) in pairs]
    return corners, shares


def _cubic(N, axes, places):
    """Interpolate N by cubics along each axis; a surface that lacks an N is 1 everywhere."""
    for axis, (x, at) in enumerate(zip(axes, places, strict=True), 1):
        first = np.searchsorted(at, np.arange(x.size), "right") - CUBIC_POINTS // 2
        nodes = at[
            np.clip(first, 0, at.size - CUBIC_POINTS)[:, np.newaxis] + np.arange(CUBIC_POINTS)
        ]
        total = 0.0
        for j in range(CUBIC_POINTS):
            weight = np.ones(x.size)
            for i in (*range(j), *range(j + 1, CUBIC_POINTS)):
                weight *= (x - x[nodes[:, i]]) / (x[nodes[:, j]] - x[nodes[:, i]])
            weight = weight.reshape(-1, *[1] * (N.ndim - 1 - axis))
            total = total + weight * N.take(nodes[:, j], axis)
        N = total
    lacks_N = np.isnan(N).any(axis=tuple(range(1, N.ndim)), keepdims=True)
    return np.where(lacks_N, 1.0, N)

"""Where a likelihood over ranges of unknowns is greatest, and its intervals by profiles."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.stats import t

CONFIDENCE = 0.95
CLOSE = 1e-5
"""Of a place, as a share of the range, and of a likelihood's logarithm."""
ENDS = 1e-4
"""Of the ends of an interval, as a share of the range."""


class Interval(NamedTuple):
    """Of one unknown, as shares of its range: ends, and whether the range ends it there."""

    low: float
    high: float
    open_low: bool
    open_high: bool


class Profile:
    """A likelihood over the unit cube.

    log: of places, (n, unknowns): its logarithm, (n,); nodes: that at the points of an even grid
    """

    def __init__(self, log: Callable, nodes: np.ndarray):
        """Climb to the greatest likelihood from the best point of the grid."""
        self.log, self.nodes = log, nodes
        self.axes = [np.linspace(0.0, 1.0, size) for size in nodes.shape]
        start = np.array([*np.unravel_index(np.argmax(nodes), nodes.shape)]) / (nodes.shape[0] - 1)
        self.best, self.most = self._climb(start, np.ones(nodes.ndim, bool))

    def interval(self, k: int, freedom: int) -> Interval:
        """Where the profile of an unknown, by its number, lies above what 95 % ask for.

        Student's t takes the place of the normal distribution, as the spread is estimated too.
        """
        least = self.most - t.ppf((1 + CONFIDENCE) / 2, max(1, freedom)) ** 2 / 2
        others = tuple(i for i in range(self.nodes.ndim) if i != k)
        inside = self.axes[k][self.nodes.max(axis=others) >= least]
        ends = [self._end(k, least, inside, side) for side in (-1, 1)]
        return Interval(*ends, *(end in (0.0, 1.0) for end in ends))

    def _end(self, k, least, inside, side):
        """The outermost place on one side, -1 or 1, at which the profile is above `least`."""
        known = side * max(side * np.append(inside, self.best[k]))
        beyond = self.axes[k][side * self.axes[k] > side * known][::side]

        def above(value):
            return self._profile(k, value) - least

        for value in beyond:
            if above(value) < 0:
                return brentq(above, known, value, xtol=ENDS)
            known = value
        return known

    def _profile(self, k, value):
        """The greatest likelihood at a value of one unknown."""
        place = np.argmin(abs(self.axes[k] - value))
        best = np.unravel_index(np.argmax(self.nodes.take(place, k)), self._others(k))
        free = np.arange(self.nodes.ndim) != k
        starts = np.tile(self.best, (2, 1))
        starts[0, free] = np.array(best) / (self.nodes.shape[0] - 1)
        starts[:, k] = value
        return self._climb(starts[np.argmax(self.log(starts))], free)[1]

    def _others(self, k):
        return self.nodes.shape[:k] + self.nodes.shape[k + 1 :]

    def _climb(self, start, free):
        """Place and logarithm of the greatest likelihood, some coordinates being free."""
        place = start.copy()
        if not free.any():
            return place, self.log(place[None])[0]

        def less(u):
            place[free] = u
            return -self.log(place[None])[0]

        step = 0.5 / (self.nodes.shape[0] - 1)
        first = start[free]
        away = np.where(first > 0.5, -step, step) * np.eye(first.size)
        simplex = np.vstack([first, first + away])
        options = {"initial_simplex": simplex, "xatol": CLOSE, "fatol": CLOSE}
        bounds = [(0.0, 1.0)] * first.size
        found = minimize(less, first, method="Nelder-Mead", bounds=bounds, options=options)
        place[free] = found.x
        return place, -found.fun

"""How likely shots are: where the likelihood of unknowns is greatest, and what it leaves open."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import t

from ...numerics.portable import geometric
from .shots import Shots
from .surface import Surface

SPREADS = geometric(0.003, 0.5, 16)
"""Relative standard deviations of a threshold, from shot to shot."""
CHUNK = 2_000_000
"""Numbers that are held at a time."""
CONFIDENCE = 0.95
CLOSE = 1e-5
"""Of a place, as a share of the range, and of a likelihood's logarithm."""
ENDS = 1e-4
"""Of the ends of an interval, as a share of the range."""
STEP = 0.02
"""Of a derivative, as a share of the range."""
FLAT = 12.0
"""One over the variance of a place in its range, of which nothing is known but the range."""


class Likelihood:
    """Likelihood of shots: P(trip) = Phi((ln N - ln N_first)/spread).

    # ASSUME: thresholds scatter lognormally, independently, by the same share at every group.
    """

    def __init__(self, shots: Shots, error: np.ndarray):
        """Take shots; error: of thresholds, relative, (groups,)."""
        self.group, self.log_N = shots.group, np.log(shots.N)
        self.sign = np.where(shots.tripped, 1.0, -1.0)
        self.error = error[self.group]

    def of(self, logs: np.ndarray) -> np.ndarray:
        """Logarithm of the likelihood of thresholds ln N, (n, groups): (n, spreads)."""
        scale, likely = np.sqrt(SPREADS[:, None] ** 2 + self.error**2), []
        for part in np.array_split(logs, -(-len(logs) * scale.size // CHUNK)):
            apart = (self.log_N - part[:, self.group])[:, None]
            likely.append(log_ndtr(self.sign * apart / scale).sum(axis=-1))
        return np.concatenate(likely)

    def integrated(self, logs: np.ndarray) -> np.ndarray:
        """The same, (n,), over all spreads, each as likely as another.

        Shots that are parted by a gap have no likeliest spread but 0; the integral has a maximum.
        """
        return logsumexp(self.of(logs) + np.log(SPREADS), axis=1)


def reach(freedom: int) -> float:
    """Standard deviations within which 95 % lie, by Student; freedom: shots beyond the unknowns."""
    return t.ppf((1 + CONFIDENCE) / 2, max(1, freedom))


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

    def interval(self, k: int, freedom: int) -> tuple[float, float]:
        """The interval at 95 % of an unknown, by its number, from the profile of the likelihood.

        Student's t takes the place of the normal distribution, as the spread is estimated too.
        """
        least = self.most - reach(freedom) ** 2 / 2
        others = tuple(i for i in range(self.nodes.ndim) if i != k)
        inside = self.axes[k][self.nodes.max(axis=others) >= least]
        return tuple(self._end(k, least, inside, side) for side in (-1, 1))

    def _end(self, k, least, inside, side):
        """The outermost place on one side, -1 or 1, at which the profile is above `least`."""
        known = side * max(side * np.append(inside, self.best[k]))
        beyond = self.axes[k][side * self.axes[k] > side * known][::side]
        for value in beyond:
            if self._profile(k, value) < least:
                return brentq(lambda x: self._profile(k, x) - least, known, value, xtol=ENDS)
            known = value
        return known

    def _profile(self, k, value):
        """The greatest likelihood at a value of one unknown."""
        nodes = self.nodes.take(np.argmin(abs(self.axes[k] - value)), k)
        best = np.unravel_index(np.argmax(nodes), nodes.shape)
        free = np.arange(self.nodes.ndim) != k
        starts = np.tile(self.best, (2, 1))
        starts[0, free] = np.array(best) / (self.nodes.shape[0] - 1)
        starts[:, k] = value
        return self._climb(starts[np.argmax(self.log(starts))], free)[1]

    def _climb(self, start, free):
        """Place and logarithm of the greatest likelihood, with these coordinates free."""
        place = start.copy()
        if not free.any():
            return place, self.log(place[None])[0]

        def less(u):
            place[free] = u
            return -self.log(place[None])[0]

        step = 0.5 / (self.nodes.shape[0] - 1)
        first = start[free]
        away = np.where(first > 0.5, -step, step) * np.eye(first.size)
        options = {"initial_simplex": np.vstack([first, first + away])}
        options |= {"xatol": CLOSE, "fatol": CLOSE}
        bounds = [(0.0, 1.0)] * first.size
        fit = minimize(less, first, method="Nelder-Mead", bounds=bounds, options=options)
        place[free] = fit.x
        return place, -fit.fun


def information_at(
    place: np.ndarray, surface: Surface, likelihood: Likelihood, spread: float
) -> tuple[np.ndarray, np.ndarray]:
    """Fisher's information of shots at a place, shares of the ranges, at a relative spread.

    Returns the covariance of the unknowns, ranges being known, and the slopes of ln N, (groups,
    unknowns).
    """
    steps = STEP * np.eye(place.size)
    above, below = (np.clip(place + side * steps, 0.0, 1.0) for side in (1, -1))
    apart = (above - below).sum(axis=1)
    slopes = ((surface.at(above) - surface.at(below)) / apart[:, None]).T
    z = (likelihood.log_N - surface.at(place[None])[0, likelihood.group]) / spread
    # phi^2 / (Phi (1 - Phi)), without a loss of digits far out.
    weight = np.exp(-z * z - log_ndtr(z) - log_ndtr(-z)) / (2 * np.pi * spread * spread)
    of_shots = slopes[likelihood.group]
    information = np.einsum("i,ij,ik->jk", weight, of_shots, of_shots) + FLAT * np.eye(place.size)
    return np.linalg.inv(information), slopes

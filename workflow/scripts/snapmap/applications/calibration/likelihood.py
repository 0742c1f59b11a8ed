"""The likelihood of shots: its maximum over the unknowns, and intervals by its profile."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import t

from ...numerics.portable import geometric
from .shots import Shots
from .surface import Surface

SPREADS = geometric(0.002, 0.6, 24)
"""Spreads, relative standard deviations of a threshold from shot to shot, that are tried."""
# ASSUME: before the shots a spread is lognormal about 4 %, and 95 % of spreads are 0.7 to 23 %.
USUAL, WIDTH = 0.04, 0.9
PRIOR = -0.5 * (np.log(SPREADS / USUAL) / WIDTH) ** 2
"""Logarithm of that density over the logarithm of the spread, up to a constant."""
LEAST_LOG = -600.0
"""Logarithm in place of lower ones."""
CHUNK = 2_000_000
"""Numbers held in memory at a time."""
CONFIDENCE = 0.95
CLOSE = 1e-5
"""Tolerance of a maximum, in shares of the ranges and in the logarithm of the likelihood."""
ENDS = 1e-4
"""Tolerance of the ends of an interval, as a share of the range."""
STEP = 0.02
"""Step of a derivative, as a share of the range."""
FLAT = 12.0
"""Information of a uniform distribution over the range, 1/variance in shares of the range."""


def exp(logs: np.ndarray) -> np.ndarray:
    """Return the exponential of logarithms, which does not underflow."""
    return np.exp(np.maximum(logs, LEAST_LOG))


class Likelihood:
    """Likelihood of shots: P(trip) = Phi((ln N - ln N_first)/spread).

    # ASSUME: thresholds scatter lognormally, independently, by the same share at every group.
    """

    def __init__(self, shots: Shots, error: np.ndarray):
        """Take shots; error: relative error of interpolated thresholds, (groups,)."""
        self.group, self.log_N = shots.group, np.log(shots.N)
        self.sign = np.where(shots.tripped, 1.0, -1.0)
        self.error = error[self.group]

    def of(self, logs: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood, (n, spreads); logs: ln N_first, (n, groups)."""
        scale, likely = np.sqrt(SPREADS[:, None] ** 2 + self.error**2), []
        for part in np.array_split(logs, -(-len(logs) * scale.size // CHUNK)):
            apart = (self.log_N - part[:, self.group])[:, None]
            likely.append(log_ndtr(self.sign * apart / scale).sum(axis=-1))
        return np.concatenate(likely)

    def integrated(self, logs: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood, averaged over spreads by PRIOR, (n,).

        If a gap separates both outcomes, the likeliest spread is 0; the mean still has a maximum.
        """
        return logsumexp(self.of(logs) + PRIOR, axis=1)


def reach(freedom: int) -> float:
    """Return how many standard deviations hold 95 % by Student's t; freedom: its degrees."""
    return t.ppf((1 + CONFIDENCE) / 2, max(1, freedom))


class Profile:
    """The profile of a likelihood over the unit cube.

    log: function of places, (n, unknowns), that returns the likelihood's logarithm, (n,)
    nodes: that logarithm at the points of an even grid, with an axis for each unknown
    best, most: place of the maximum, and the logarithm there
    """

    def __init__(self, log: Callable, nodes: np.ndarray):
        """Find the maximum, from the best point of the grid."""
        self.log, self.nodes = log, nodes
        self.axes = [np.linspace(0.0, 1.0, size) for size in nodes.shape]
        start = np.array([*np.unravel_index(np.argmax(nodes), nodes.shape)]) / (nodes.shape[0] - 1)
        self.best, self.most = self._climb(start, np.ones(nodes.ndim, bool))

    def interval(self, k: int, freedom: int) -> tuple[float, float]:
        """Find the interval at 95 % of unknown k, as shares of its range.

        Student's t replaces the normal distribution, as the spread is estimated too.
        """
        least = self.most - reach(freedom) ** 2 / 2
        others = tuple(i for i in range(self.nodes.ndim) if i != k)
        inside = self.axes[k][self.nodes.max(axis=others) >= least]
        return tuple(self._end(k, least, inside, side) for side in (-1, 1))

    def _end(self, k, least, inside, side):
        """The outermost place at which the profile is at least `least`; side: -1 or 1."""
        known = side * max(side * np.append(inside, self.best[k]))
        beyond = self.axes[k][side * self.axes[k] > side * known][::side]
        for value in beyond:
            if self._profile(k, value) < least:
                return brentq(lambda x: self._profile(k, x) - least, known, value, xtol=ENDS)
            known = value
        return known

    def _profile(self, k, value):
        """The maximum of the logarithm with unknown k at a value."""
        nodes = self.nodes.take(np.argmin(abs(self.axes[k] - value)), k)
        best = np.unravel_index(np.argmax(nodes), nodes.shape)
        free = np.arange(self.nodes.ndim) != k
        starts = np.tile(self.best, (2, 1))
        starts[0, free] = np.array(best) / (self.nodes.shape[0] - 1)
        starts[:, k] = value
        return self._climb(starts[np.argmax(self.log(starts))], free)[1]

    def _climb(self, start, free):
        """Place and logarithm of the maximum over the free coordinates, a mask, from a start."""
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
    """Find the covariance of the unknowns, as shares of their ranges, by Fisher's information.

    place: estimates as shares of the ranges; spread: relative
    Returns the covariance, (unknowns, unknowns), with the ranges as prior knowledge, and the
    slopes of ln N_first, (groups, unknowns).
    """
    steps = STEP * np.eye(place.size)
    above, below = (np.clip(place + side * steps, 0.0, 1.0) for side in (1, -1))
    apart = (above - below).sum(axis=1)
    slopes = ((surface.at(above) - surface.at(below)) / apart[:, None]).T
    z = (likelihood.log_N - surface.at(place[None])[0, likelihood.group]) / spread
    # phi^2 / (Phi (1 - Phi)) by logarithms, which keep their digits in the tails.
    weight = exp(-z * z - log_ndtr(z) - log_ndtr(-z)) / (2 * np.pi * spread * spread)
    of_shots = slopes[likelihood.group]
    information = np.einsum("i,ij,ik->jk", weight, of_shots, of_shots) + FLAT * np.eye(place.size)
    return np.linalg.inv(information), slopes

"""How likely shots are: where the likelihood of unknowns is greatest, and what it leaves open."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import t

from ..numerics.portable import geometric
from .shots import Shots
from .surface import Surface

SPREADS = geometric(0.003, 0.5, 16)
"""Relative standard deviations of a threshold, from shot to shot and unit to unit."""
SHARES = np.array([0.0, 0.3, 0.6, 0.8, 0.95])
"""Of the spread's variance that is between units, where some unit is shot more than once."""
DEVIATIONS = np.linspace(-4.0, 4.0, 25)
"""Of a unit from the mean of units."""
ALONE = np.zeros(1)
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
UNRESOLVED = 0.5
"""Of the standard deviation within the range: what is left of it where shots tell little."""


class Likelihood:
    """Likelihood of shots: P(trip) = Phi((ln N - ln N_first - unit)/spread).

    # ASSUME: thresholds scatter lognormally, by the same share at every group of shots.
    """

    def __init__(self, shots: Shots, error: np.ndarray):
        """Sort shots by their units; error: of thresholds, relative, (groups,)."""
        order = np.argsort(shots.unit, kind="stable")
        self.group = shots.group[order]
        self.log_N = np.log(shots.N[order])
        self.sign = np.where(shots.tripped[order], 1.0, -1.0)
        self.error = error[self.group]
        unit = shots.unit[order]
        self.begins = np.flatnonzero(np.r_[True, unit[1:] != unit[:-1]])
        repeats = self.begins.size < unit.size
        self.shares = SHARES if repeats else ALONE
        self.deviations = DEVIATIONS if repeats else ALONE

    def of(self, logs: np.ndarray) -> np.ndarray:
        """Logarithm of the likelihood of thresholds ln N, (n, groups): (n, spreads, shares)."""
        spread, share = SPREADS[:, None, None, None], self.shares[:, None, None]
        unit = spread * np.sqrt(share) * self.deviations[:, None]
        within = np.sqrt(spread**2 * (1 - share) + self.error**2)
        weights, likely = -0.5 * self.deviations[:, None] ** 2, []
        weights -= logsumexp(weights)
        for part in np.array_split(logs, -(-len(logs) * (unit + within).size // CHUNK)):
            apart = (self.log_N - part[:, self.group])[:, None, None, None]
            each = log_ndtr(self.sign * (apart - unit) / within)
            units = np.add.reduceat(each, self.begins, axis=-1) + weights
            likely.append(logsumexp(units, axis=-2).sum(axis=-1))
        return np.concatenate(likely)

    def integrated(self, logs: np.ndarray) -> np.ndarray:
        """The same, (n,), over all spreads, each as likely as another, and over all shares.

        Shots that are parted by a gap have no likeliest spread but 0; the integral has a maximum.
        """
        return logsumexp(self.of(logs) + np.log(SPREADS)[:, None], axis=(1, 2))


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
        """Where the profile of an unknown, by its number, lies above what 95 % ask for.

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
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fisher's information of shots at a place, shares of the ranges, at a relative spread.

    Returns the covariance of the unknowns, ranges being known; the slopes of ln N, (groups,
    unknowns); and the directions, each of length 1, (n, unknowns), of which the shots tell little:
    the ranges say nearly as much.
    """
    steps = STEP * np.eye(place.size)
    above, below = (np.clip(place + side * steps, 0.0, 1.0) for side in (1, -1))
    apart = (above - below).sum(axis=1)
    slopes = ((surface.at(above) - surface.at(below)) / apart[:, None]).T
    z = (likelihood.log_N - surface.at(place[None])[0, likelihood.group]) / spread
    # phi^2 / (Phi (1 - Phi)), without a loss of digits far out.
    weight = np.exp(-z * z - log_ndtr(z) - log_ndtr(-z)) / (2 * np.pi * spread * spread)
    each = slopes[likelihood.group]
    information = np.einsum("i,ij,ik->jk", weight, each, each) + FLAT * np.eye(place.size)
    values, vectors = np.linalg.eigh(information)
    vectors *= np.sign(vectors[np.argmax(abs(vectors), axis=0), np.arange(place.size)])
    little = np.sqrt(FLAT / values[::-1]) > UNRESOLVED
    return (vectors / values) @ vectors.T, slopes, vectors.T[::-1][little]

"""Mean and spread of thresholds from shots that trip or do not: probit, maximum likelihood."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import log_ndtr, ndtri
from scipy.stats import f

NO_FIRE, ALL_FIRE = 0.001, 0.999
"""Shares that trip at the levels of these names."""
REACH = 12.0
"""Of the logarithm of the slope about its best value, where profiles are sought."""


class Interval(NamedTuple):
    """A value with the ends of its interval, which may be infinite."""

    value: float
    low: float
    high: float


class Estimate(NamedTuple):
    """Of thresholds, N: mean and standard deviation, and the levels at which 0.1 and 99.9 % trip.

    ASSUME: the thresholds of shots to come are normally distributed over N.
    """

    mean: Interval
    sigma: Interval
    no_fire: Interval
    all_fire: Interval


def has_estimate(N: np.ndarray, tripped: np.ndarray) -> bool:
    """Whether the likelihood has one maximum at a finite spread above 0 (Silvapulle, 1981).

    N, tripped: of the shots, (shots,)
    """
    if tripped.all() or not tripped.any():
        return False
    went, stayed = N[tripped], N[~tripped]
    return bool(went.min() < stayed.max() and went.mean() > stayed.mean())


def estimate(N: np.ndarray, tripped: np.ndarray, confidence: float) -> Estimate:
    """Fit mean and spread to shots for which `has_estimate`; intervals by the likelihood ratio.

    confidence: of each interval, two-sided
    """
    centre, scale = N.mean(), N.std()
    # ASSUME: F in place of chi-squared, its limit for many shots: with few that covers too little.
    fit = _Fit((N - centre) / scale, tripped, f.ppf(confidence, 1, N.size - 2) / 2)
    levels = (fit.level(share) for share in (0.5, NO_FIRE, ALL_FIRE))
    mean, no_fire, all_fire = (_interval(one, scale, centre) for one in levels)
    return Estimate(mean, _interval(fit.sigma(), scale), no_fire, all_fire)


def _interval(ends, scale, centre=0.0):
    return Interval(*(float(centre + scale * end) for end in ends))


def best(N: np.ndarray, tripped: np.ndarray) -> tuple[float, float]:
    """Fit mean and spread alone, as `estimate` does."""
    centre, scale = N.mean(), N.std()
    fit = _Fit((N - centre) / scale, tripped, 0.0)
    return centre - scale * fit.a / fit.b, scale / fit.b


class _Fit:
    """P = Phi(a + b x): its maximum, and what profiles of the likelihood leave open."""

    def __init__(self, x, tripped, drop):
        """Fit to standardized levels; drop: of the log-likelihood at the ends of an interval."""
        self.x, self.sign = x, np.where(tripped, 1.0, -1.0)
        self.share = tripped.mean()
        start, exact = [ndtri(self.share), 1.0], {"gtol": 1e-9}
        found = minimize(lambda p: self._loss(*p), start, jac=self._slope, options=exact)
        self.a, self.b = found.x
        self.worst = found.fun + drop

    def _loss(self, a, b):
        return -log_ndtr(self.sign * (a + b * self.x)).sum()

    def _slope(self, p):
        seen = self.sign * (p[0] + p[1] * self.x)
        by_each = -self.sign * np.exp(-(seen**2) / 2 - log_ndtr(seen)) / np.sqrt(2 * np.pi)
        return np.array([by_each.sum(), (by_each * self.x).sum()])

    def _constant(self, share):
        """Loss where each shot trips with the same probability: that of an infinite spread."""
        went = self.sign > 0
        return -(went.sum() * np.log(share) + (~went).sum() * np.log1p(-share))

    def level(self, share):
        """The level at which so large a share trips."""
        z, middle = ndtri(share), np.log(self.b)
        value = (z - self.a) / self.b

        def excess(level):
            def loss(t):
                return self._loss(z - np.exp(t) * level, np.exp(t))

            bounds = middle - REACH, middle + REACH
            return minimize_scalar(loss, bounds=bounds, method="bounded").fun - self.worst

        low = self._end(excess, value, -1.0, self._constant(max(self.share, share)))
        high = self._end(excess, value, 1.0, self._constant(min(self.share, share)))
        return value, low, high

    def sigma(self):
        """The standard deviation."""
        value = 1 / self.b

        def excess(log_sigma):
            b = np.exp(-log_sigma)
            return minimize_scalar(lambda a: self._loss(a, b)).fun - self.worst

        low = self._end(excess, np.log(value), -0.5, np.inf)
        high = self._end(excess, np.log(value), 0.5, self._constant(self.share))
        return value, float(np.exp(low)), float(np.exp(high))

    def _end(self, excess: Callable, value: float, step: float, limit: float) -> float:
        """Where the loss is the worst allowed, from a value outward; limit: its loss far away."""
        if limit <= self.worst:
            return float(np.copysign(np.inf, step))
        while excess(value + step) < 0:
            step *= 2
        return float(brentq(excess, value, value + step, xtol=1e-6))


def information(N: np.ndarray, mean: float, sigma: float) -> np.ndarray:
    """Fisher's information of each level on mean and spread, (2, 2, levels), in units of sigma."""
    k = (N - mean) / sigma
    weight = np.exp(-(k**2) - log_ndtr(k) - log_ndtr(-k)) / (2 * np.pi)
    return weight * np.array([[np.ones_like(k), k], [k, k**2]])

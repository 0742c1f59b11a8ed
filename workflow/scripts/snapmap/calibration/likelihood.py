"""How likely shots are, given the thresholds of a device: go or no-go, with a spread."""

import numpy as np
from scipy.special import log_ndtr, logsumexp

from ..numerics.portable import geometric
from .shots import Shots

SPREADS = geometric(0.003, 0.5, 16)
"""Relative standard deviations of a threshold, from shot to shot and unit to unit."""
SHARES = np.array([0.0, 0.3, 0.6, 0.8, 0.95])
"""Of the spread's variance that is between units, where some unit is shot more than once."""
DEVIATIONS = np.linspace(-4.0, 4.0, 25)
"""Of a unit from the mean of units."""
ALONE = np.zeros(1)
CHUNK = 2_000_000
"""Numbers that are held at a time."""


class Likelihood:
    """Likelihood of shots: P(trip) = Phi((ln N - ln N_first - unit)/spread).

    # ASSUME: thresholds scatter lognormally, by the same share at every kind of shock.
    """

    def __init__(self, shots: Shots, error: np.ndarray):
        """Sort shots by their units; error: of thresholds, relative, (kinds,)."""
        order = np.argsort(shots.unit, kind="stable")
        self.kind = shots.kind[order]
        self.log_N = np.log(shots.N[order])
        self.sign = np.where(shots.tripped[order], 1.0, -1.0)
        self.error = error[self.kind]
        unit = shots.unit[order]
        self.begins = np.flatnonzero(np.r_[True, unit[1:] != unit[:-1]])
        repeats = self.begins.size < unit.size
        self.shares = SHARES if repeats else ALONE
        self.deviations = DEVIATIONS if repeats else ALONE
        weights = -0.5 * self.deviations**2
        self._weights = weights - logsumexp(weights)

    def of(self, logs: np.ndarray) -> np.ndarray:
        """Logarithm of the likelihood of thresholds ln N, (n, kinds): (n, spreads, shares)."""
        size = SPREADS.size * self.shares.size * self.deviations.size * self.kind.size
        parts = np.array_split(logs, -(-len(logs) * size // CHUNK))
        return np.concatenate([self._part(part) for part in parts])

    def _part(self, logs):
        apart = (self.log_N - logs[:, self.kind])[:, None, None, None]
        spread = SPREADS[:, None, None, None]
        share = self.shares[:, None, None]
        unit = spread * np.sqrt(share) * self.deviations[:, None]
        within = np.sqrt(spread**2 * (1 - share) + self.error**2)
        each = log_ndtr(self.sign * (apart - unit) / within)
        units = np.add.reduceat(each, self.begins, axis=-1)
        return logsumexp(units + self._weights[:, None], axis=-2).sum(axis=-1)

    def integrated(self, logs: np.ndarray) -> np.ndarray:
        """The same, (n,), over all spreads, each as likely as another, and over all shares.

        Shots that are parted by a gap have no likeliest spread but 0; the integral has a maximum.
        """
        return logsumexp(self.of(logs) + np.log(SPREADS)[:, None], axis=(1, 2))

"""Thresholds of a device over ranges of its unknown values, interpolated on a grid."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq, minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import qmc, t

from ...device.device import batch, is_bistable
from ...numerics.portable import geometric
from ...solver.cells import to_rows
from ...study.axes import point_text
from ...study.study import Study
from ...thresholds.population import Batch, choose_levels
from .shots import Group, Shots

POINTS = {1: 33, 2: 17, 3: 9, 4: 6}
"""Values of each unknown on the grid, by the number of unknowns."""
CHECKED = 64
"""Number of points at which the solver checks the interpolation; a power of two."""
TOLERANCE = 2e-4
"""Relative tolerance of thresholds."""


class Surface:
    """Logarithms of thresholds, ln N_first, over the unknowns as shares of their ranges.

    unknowns: ranges by name, internal units; logs: at the points of the grid, (..., groups)
    at: interpolates `logs` at shares of the ranges, (..., unknowns)
    error: root mean square error of the interpolation, (groups,)
    """

    def __init__(self, unknowns: Mapping, logs: np.ndarray):
        """Take logs of thresholds over an even grid."""
        self.unknowns, self.logs = dict(unknowns), logs
        axes = [np.linspace(0.0, 1.0, size) for size in logs.shape[:-1]]
        self.at, self.error = RegularGridInterpolator(axes, logs), np.zeros(logs.shape[-1])

    def values(self, u: np.ndarray) -> np.ndarray:
        """Return the unknowns, internal units, at shares of their ranges."""
        low, high = np.array(list(self.unknowns.values()), float).T
        return low + np.asarray(u) * (high - low)


def surface_of(
    study: Study, groups: Sequence[Group], unknowns: Mapping, C: float | None
) -> Surface:
    """Find the thresholds of a study's device under all groups of shots, over its unknowns.

    unknowns: ranges by name, internal units; C: uN us/um, or None if it is unknown
    Raises ValueError, one line, if a point has no second stable shape, or no threshold.
    """
    size = POINTS[len(unknowns)]
    check = qmc.Sobol(len(unknowns), scramble=False).random_base2(CHECKED.bit_length() - 1)
    steps = np.meshgrid(*[np.linspace(0.0, 1.0, size)] * len(unknowns), indexing="ij")
    grid = np.stack(steps, axis=-1).reshape(-1, len(unknowns))
    low, high = np.array(list(unknowns.values()), float).T
    # Points all over the ranges come first: they narrow the search for the others.
    points = low + np.concatenate([check, grid]) * (high - low)
    logs = log_thresholds(study, groups, dict(zip(unknowns, points.T, strict=True)), C)
    surface = Surface(unknowns, logs[CHECKED:].reshape(*steps[0].shape, len(groups)))
    apart = surface.at(check) - logs[:CHECKED]
    surface.error = np.sqrt((apart * apart).mean(axis=0)) + TOLERANCE
    return surface


def log_thresholds(
    study: Study, groups: Sequence[Group], values: Mapping[str, np.ndarray], C: float
) -> np.ndarray:
    """Find ln N_first, (points, groups), at values of the unknowns by name, (points,)."""
    of_device = {key: column for key, column in values.items() if key != "C"}
    bistable = is_bistable(study.device, of_device, len(next(iter(values.values()))))
    if not bistable.all():
        place = _place(of_device, np.argmin(bistable))
        raise ValueError(f"unknowns: no second stable shape at {place}; write a narrower range")
    # The middle of the ranges stands for the nominal device.
    middle = {key: np.array([(c.min() + c.max()) / 2]) for key, c in values.items()}
    C = middle.pop("C", C)
    device = batch([study.device]).vary(middle).pick(0)
    f0, pulses = [group.f0 for group in groups], tuple(group.pulse for group in groups)
    rows = to_rows(0, f0, C, np.arange(len(pulses)), pulses)
    settings = study.run
    levels = choose_levels(device, study.model, rows, settings)
    shares = {key: column / C if key == "C" else column for key, column in values.items()}
    scattered = Batch(device, shares, study.model, levels, settings.start)
    N_first, *_ = scattered.thresholds(rows, settings, TOLERANCE)
    if not np.isfinite(N_first).all():
        where, group = np.argwhere(~np.isfinite(N_first))[0]
        raise ValueError(
            f"shots: the model has no threshold for {groups[group]} at "
            f"{_place(study, values, where)}; leave such shots out, or write narrower ranges"
        )
    return np.log(N_first)


def _place(study, values, where):
    point = {key: column[where] for key, column in values.items()}
    return point_text(point, study.unit_of_C)


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

"""Estimates of a device from its shots as an xarray dataset, with intervals and residuals."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import xarray as xr
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq, minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import qmc, t

from ...device.device import batch, is_bistable
from ...files.text import plain
from ...numerics.portable import geometric
from ...solver.cells import to_rows
from ...study.arguments import SingleStudy
from ...study.axes import attributes_of, point_text
from ...study.study import OF_THRESHOLDS, Study
from ...study.variables import dress
from ...thresholds.population import Batch, choose_levels
from ...values.kinds import Fitting, kind_of
from ...values.quantities import Damper, ExistingPath
from ...values.records import ByKeys
from ...values.units import OF_DAMPER
from .shots import Group, Shots, UnknownsSection, check_ranges, shots_from

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
        place = _place(study, of_device, np.argmin(bistable))
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


DIGITS = 6
"""Significant digits of fitted values; SciPy's last digits differ between machines."""
INSIDE = 300
"""Approximate number of places in the intervals at which `_spreads` sums the likelihood."""
TAILS = (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
NEAR = 2.0
"""Shots of which none is within this factor of a threshold do not tell anything of the device."""


def _is_table(value):
    return hasattr(value, "keys") or kind_of(ExistingPath).fits(value)


_TABLE = Fitting("the path of a file that exists, or columns by name", _is_table)
_NEED = 'values of the device, or C, to ranges, such as {"thickness": (1.7, 2.3)}'
_UNKNOWNS = ByKeys(UnknownsSection, f"a mapping of {_NEED}", "cannot be unknown", least=1)
Table = Annotated[str | Path | Mapping[str, Sequence], _TABLE]
Unknowns = Annotated[Mapping[str, Sequence], _UNKNOWNS]


def calibrate(
    study: SingleStudy, shots: Table, unknowns: Unknowns, C: Damper | None = None
) -> xr.Dataset:
    """Estimate values of a device from measured shots, tripped or not, by maximum likelihood.

    A shot trips with probability Phi(ln(N / N_first) / spread).

    Parameters
    ----------
    study
        Device and model, and the shock of shots that name none; or a Device.
    shots
        Path of a CSV file, or columns of one length: `N`, `duration` (us) or `f0` (Hz), `tripped`
        (true or false), and optionally `direction`, `shape`, `file` (a record).
    unknowns
        Range of each unknown, internal units, by the name of a value of the device, or C.
    C
        Damping of the mass, uN us/um; None where C is unknown.

    Returns
    -------
    Dataset
        `estimate`, `low` and `high` (95 % profile interval) over `unknown`, `correlation` over
        `unknown` and `unknown_2`, the relative `spread` over `bound`, and `threshold`,
        `probability` and `residual` over `shot`; `model_error` is the relative error of
        interpolated thresholds.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, for shots that determine nothing.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> shots = {"N": [800, 900, 950, 1000, 1050, 1200], "tripped": [0, 0, 0, 1, 1, 1]}
    >>> shots["duration"] = [1000.0] * 6
    >>> fitted = snapmap.calibrate(device, shots, {"thickness": (1.7, 2.3)}, C=25.0)
    >>> round(fitted.estimate.item(), 1)
    2.0
    """
    check_ranges(unknowns, C, study.device)
    return calibration_of(study, shots_from(shots, study.shocks, study.device), unknowns, C)


def calibration_of(study: Study, shots: Shots, unknowns: Mapping, C: float | None) -> xr.Dataset:
    """Estimate values of a study's device from shots, as `calibrate` returns them."""
    refuse_far(study, shots, unknowns, C)
    surface = surface_of(study, shots.groups, unknowns, C)
    ranges = {key: [float(end) for end in ends] for key, ends in unknowns.items()}
    asked = {"unknowns": ranges} | ({} if C is None else {"C": float(C)})
    document = study.document(OF_THRESHOLDS) | {"calibration": asked}
    return dress("calibration", fit(shots, surface, study.unit_of_C), document)


def refuse_far(study: Study, shots: Shots, unknowns: Mapping, C: float | None) -> None:
    """Raise ValueError, one line, if no shot is near a threshold at the ends of the ranges."""
    ends = dict(zip(unknowns, np.array([*product(*unknowns.values())], float).T, strict=True))
    logs = log_thresholds(study, shots.groups, ends, C)
    low, high = (np.exp(end)[shots.group] for end in (logs.min(axis=0), logs.max(axis=0)))
    if (np.maximum(low / shots.N, shots.N / high) > NEAR).all():
        raise ValueError(
            f"shots: N is {plain(shots.N.min())} to {plain(shots.N.max())}, but the ranges of "
            f"unknowns give {plain(low.min())} to {plain(high.max())}; "
            "is N in multiples of g?"
        )


def fit(shots: Shots, surface: Surface, unit_of_C: str = OF_DAMPER) -> xr.Dataset:
    """Fit unknowns to shots by thresholds over their ranges; returns a dataset without config."""
    likelihood = Likelihood(shots, surface.error)
    nodes = likelihood.integrated(surface.logs.reshape(-1, len(shots.groups)))
    nodes = nodes.reshape(surface.logs.shape[:-1])
    profile = Profile(lambda u: likelihood.integrated(surface.at(u)), nodes)
    names, freedom = list(surface.unknowns), shots.N.size - len(surface.unknowns) - 1
    low, high = np.array([profile.interval(k, freedom) for k in range(len(names))]).T
    units = {key: attributes_of(key, unit_of_C)["units"] for key in names}
    unit = {"comment": ", ".join(f"{key}: {units[key]}" for key in names)}
    data = {
        key: ("unknown", _rounded(surface.values(place)), unit)
        for key, place in {"estimate": profile.best, "low": low, "high": high}.items()
    }
    spreads = _spreads(likelihood, surface, low, high)
    data["spread"] = "bound", _rounded(spreads)
    spread = spreads[0]
    covariance, slopes = information_at(profile.best, surface, likelihood, spread)
    scale = np.sqrt(np.diag(covariance))
    correlation = _rounded(covariance / np.outer(scale, scale))
    data["correlation"] = ("unknown", "unknown_2"), correlation
    logs, group = surface.at(profile.best[None])[0], shots.group
    variance = np.einsum("ij,jk,ik->i", slopes, covariance, slopes)
    half = reach(freedom) * np.sqrt(variance)
    z = (np.log(shots.N) - logs[group]) / np.sqrt(spread**2 + surface.error**2)[group]
    sign = np.where(shots.tripped, 1.0, -1.0)
    columns = {
        "N": shots.N,
        "f0": shots.f0,
        "direction": np.array([shots.groups[i].direction for i in group]),
        "shape": np.array([shots.groups[i].shape for i in group]),
        "tripped": shots.tripped.astype(np.int8),
        "threshold": _rounded(np.exp(logs)[group]),
        "threshold_low": _rounded(np.exp(logs - half)[group]),
        "threshold_high": _rounded(np.exp(logs + half)[group]),
        "probability": _rounded(exp(log_ndtr(z))),
        "residual": _rounded(sign * np.sqrt(-2 * log_ndtr(sign * z))),
    }
    data |= {key: ("shot", values) for key, values in columns.items()}
    named = {"unknown": names, "unknown_2": names, "bound": ["estimate", "low", "high"]}
    return xr.Dataset(data | {"model_error": _rounded(surface.error.max())}, named)


def _spreads(likelihood, surface, low, high):
    """Median of the spread after the shots, and the ends of its interval at 95 %, (3,).

    low, high: intervals of the unknowns as shares of their ranges, (unknowns,)
    """
    half = (high - low) / 2
    low, high = np.clip([low - half, high + half], 0.0, 1.0)
    size = round(INSIDE ** (1 / len(low)))
    mesh = np.meshgrid(*np.linspace(low, high, size).T, indexing="ij")
    logs = likelihood.of(surface.at(np.stack(mesh, axis=-1).reshape(-1, len(low)))) + PRIOR
    weights = exp(logsumexp(logs, axis=0) - logsumexp(logs))
    below = np.cumsum(weights) - weights / 2
    return np.exp(np.interp([0.5, *TAILS], below, np.log(SPREADS)))


def summary(fitted: xr.Dataset) -> str:
    """Write in a line each estimate with its interval, and the spread."""
    words = [f"{fitted.sizes['shot']} shots"]
    for key in fitted.unknown.values:
        unknown = fitted.sel(unknown=key)
        value, low, high = (plain(unknown[name].item()) for name in ("estimate", "low", "high"))
        words.append(f"{key} {value} ({low} to {high})")
    spread, low, high = (plain(value, 2) for value in fitted.spread.values * 100)
    words.append(f"spread {spread} % ({low} to {high} %)")
    return ", ".join(words)


def _rounded(values):
    """Round values to DIGITS; returns an array."""
    values = np.asarray(values, float)
    return np.vectorize(lambda x: float(f"{x:.{DIGITS}g}"))(values) if values.size else values

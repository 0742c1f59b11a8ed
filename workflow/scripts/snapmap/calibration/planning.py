"""Which shot comes next, what shots say of thresholds that scatter, and how many show a demand."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import log_ndtr, ndtri
from scipy.stats import binom, chi2, f

from ..io.tables import shot_columns

STEPS = np.arange(-4000, 4001) / 1000
"""Where a D-optimal level is sought, standard deviations from the mean."""


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


class Plan(NamedTuple):
    """The N of the next shot, what it is for, and the estimate: None while shots leave it open."""

    N: float
    why: str
    estimate: Estimate | None


def plan_shots(
    prior: xr.Dataset | tuple[float, float],
    shots: str | Path | Mapping[str, Sequence] = (),
    method: str = "neyer",
    confidence: float = 0.95,
) -> Plan:
    """Choose the N of the next shot, and estimate from those so far at which N devices trip.

    prior: what `tolerance` returns, of one pulse, C and f0; or mean and standard deviation of the
        thresholds, multiples of g
    shots: a CSV file, or columns by name: N and tripped (yes or no), in their order, all with one
        pulse
    method: neyer (D-optimal) or up-and-down; confidence: of the intervals, two-sided
    The estimate has mean, sigma, and the levels no_fire and all_fire at which 0.1 and 99.9 % trip,
    each with value, low and high. Raises ValueError, one line, for an invalid argument.

    >>> plan = snapmap.plan_shots((1000, 50), {"N": [1000, 1100], "tripped": [False, True]})
    >>> plan.N
    1050.0
    """
    if isinstance(prior, xr.Dataset):
        if "N_mean" not in prior or prior.N_mean.size > 1:
            raise ValueError("prior: has no N_mean of one pulse, C and f0; choose them by .sel")
        prior = prior.N_mean.item(), prior.N_std.item()
    mean, sigma = map(float, prior)
    if not (0 < mean < np.inf and 0 < sigma < np.inf):
        raise ValueError(f"prior: {mean:g}, {sigma:g} are no mean and standard deviation above 0")
    columns = shot_columns(shots)
    for key in ("f0", "duration", "direction", "shape"):
        if len(several := dict.fromkeys(map(str, columns.get(key, ())))) > 1:
            raise ValueError(f"shots: {key}: {', '.join(several)[:60]}; plan each pulse by itself")
    N, tripped = columns.get("N", np.empty(0)), columns.get("tripped", np.empty(0, bool))
    if N.size < tripped.size or np.isnan(N).any():
        raise ValueError("shots: N: missing; write one for each shot")
    level, why = next_level(N, tripped, method, mean - 4 * sigma, mean + 4 * sigma, sigma)
    return Plan(level, why, estimate(N, tripped, confidence) if has_estimate(N, tripped) else None)


def shots_needed(reliability: float, confidence: float = 0.95, failures: int = 0) -> int:
    """Return how many shots show a reliability at a confidence, if so many of them may fail.

    reliability: least share of devices that do as required, from 0 to 1
    failures: 0 is a success run of ln(1 - confidence) / ln(reliability) shots

    >>> snapmap.shots_needed(0.999, 0.95)
    2995
    """
    # By Poisson's law it takes more.
    most = int(chi2.ppf(confidence, 2 * failures + 2) / 2 / (1 - reliability)) + failures + 2
    return bisect_left(
        range(most), confidence, key=lambda shots: binom.sf(failures, shots, 1 - reliability)
    )


def next_level(
    N: np.ndarray, tripped: np.ndarray, method: str, low: float, high: float, sigma: float
) -> tuple[float, str]:
    """The next level, N, and what it is for; N, tripped: of the shots so far, (shots,).

    low, high: between which the mean is guessed; sigma: the guessed standard deviation
    """
    if not N.size:
        return (low + high) / 2, "first, in the middle"
    if method == "up-and-down":
        down = tripped[-1]
        level, why = N[-1] + (-sigma if down else sigma), f"one step {'down' if down else 'up'}"
    else:
        level, why = _neyer(N, tripped, low, high, sigma)
    return (float(level), why) if level > 0 else (float(N.min() / 2), "half of the lowest")


def _neyer(N, tripped, low, high, sigma):
    """Neyer (1994): levels of both kinds, then an overlap of them, then D-optimal ones."""
    if not tripped.any():
        level = max((high + N.max()) / 2, N.max() + 2 * sigma, 2 * N.max() - N.min())
        return level, "find: none has tripped"
    if tripped.all():
        level = min((low + N.min()) / 2, N.min() - 2 * sigma, 2 * N.min() - N.max())
        return level, "find: all have tripped"
    for shots in range(2, N.size):  # each shot that sought an overlap shrinks the guess
        sigma *= 0.8 if 0 <= _gap(N[:shots], tripped[:shots]) <= sigma else 1.0
    gap, middle, width = _gap(N, tripped), (N[tripped].min() + N[~tripped].max()) / 2, np.ptp(N)
    if gap > sigma:
        return middle, "find: halfway between the kinds"
    if gap >= 0:
        return _d_optimal(N, middle, min(sigma, width)), "overlap: about the guessed mean"
    if not has_estimate(N, tripped):
        # ASSUME: where those that tripped are no higher than the others, the spread is all of it.
        return _d_optimal(N, middle, width), "estimate: the kinds lie upside down"
    mean, spread = best(N, tripped)
    clipped = np.clip(mean, N.min(), N.max()), min(spread, width)
    return _d_optimal(N, *clipped), "estimate: D-optimal about the fit"


def _gap(N, tripped):
    """From the highest that stayed to the lowest that tripped; infinite of a single kind."""
    return np.round(N[tripped].min(initial=np.inf) - N[~tripped].max(initial=-np.inf), 12)


def _d_optimal(N, mean, sigma):
    """The level that makes the determinant of Fisher's information of all shots largest."""
    levels = mean + STEPS * sigma
    so_far = _information((N - mean) / sigma).sum(axis=-1, keepdims=True)
    total = so_far + _information((levels - mean) / sigma)
    return levels[np.argmax(total[0, 0] * total[1, 1] - total[0, 1] ** 2)]


def _information(k):
    """On mean and spread, (2, 2, levels), in units of sigma, of levels k sigma from the mean."""
    weight = np.exp(-(k**2) - log_ndtr(k) - log_ndtr(-k)) / (2 * np.pi)
    return weight * np.array([[np.ones_like(k), k], [k, k**2]])


def has_estimate(N: np.ndarray, tripped: np.ndarray) -> bool:
    """Whether the likelihood has one maximum at a finite spread above 0 (Silvapulle, 1981)."""
    if tripped.all() or not tripped.any():
        return False
    went, stayed = N[tripped], N[~tripped]
    return bool(went.min() < stayed.max() and went.mean() > stayed.mean())


def best(N: np.ndarray, tripped: np.ndarray) -> tuple[float, float]:
    """Mean and spread of maximum likelihood, of shots for which `has_estimate`."""
    a, b, _ = _fit((N - N.mean()) / N.std(), np.where(tripped, 1.0, -1.0))
    return N.mean() - N.std() * a / b, N.std() / b


def estimate(N: np.ndarray, tripped: np.ndarray, confidence: float) -> Estimate:
    """Fit as `best`, with intervals by the likelihood ratio; confidence: of each, two-sided."""
    x, sign, share = (N - N.mean()) / N.std(), np.where(tripped, 1.0, -1.0), tripped.mean()
    a, b, least = _fit(x, sign)
    # ASSUME: F in place of chi-squared, its limit for many shots: with few that covers too little.
    worst = least + f.ppf(confidence, 1, N.size - 2) / 2
    bounds = np.log(b) - 12, np.log(b) + 12

    def flat(p):
        """Loss of an infinite spread: each shot trips with the probability p."""
        return -(tripped.sum() * np.log(p) + (~tripped).sum() * np.log1p(-p))

    def end(profile, value, step, far):
        """Where a profile of the loss is the worst, from a value outward; far: at infinity."""
        if far <= worst:
            return np.copysign(np.inf, step)
        while profile(value + step) < worst:
            step *= 2
        return brentq(lambda at: profile(at) - worst, value, value + step, xtol=1e-6)

    def level(p):
        """At which the share p trips."""
        z = ndtri(p)

        def profile(at):
            loss = lambda t: _loss(x, sign, z - np.exp(t) * at, np.exp(t))  # noqa: E731
            return minimize_scalar(loss, bounds=bounds, method="bounded").fun

        value = (z - a) / b
        low = end(profile, value, -1.0, flat(max(share, p)))
        high = end(profile, value, 1.0, flat(min(share, p)))
        return Interval(*(float(N.mean() + N.std() * one) for one in (value, low, high)))

    def spread(log_sigma):
        return minimize_scalar(lambda a: _loss(x, sign, a, np.exp(-log_sigma))).fun

    ends = end(spread, -np.log(b), -0.5, np.inf), end(spread, -np.log(b), 0.5, flat(share))
    sigma = Interval(*(float(N.std() * one) for one in (1 / b, *np.exp(ends))))
    return Estimate(level(0.5), sigma, level(0.001), level(0.999))


def _fit(x, sign):
    """Intercept and slope of P = Phi(a + b x) of maximum likelihood, and the loss there."""

    def slope(p):
        seen = sign * (p[0] + p[1] * x)
        by_each = -sign * np.exp(-(seen**2) / 2 - log_ndtr(seen)) / np.sqrt(2 * np.pi)
        return np.array([by_each.sum(), (by_each * x).sum()])

    start = [ndtri((sign > 0).mean()), 1.0]
    fit = minimize(lambda p: _loss(x, sign, *p), start, jac=slope, options={"gtol": 1e-9})
    return *fit.x, fit.fun


def _loss(x, sign, a, b):
    return -log_ndtr(sign * (a + b * x)).sum()

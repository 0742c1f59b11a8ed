"""The next shot of a campaign in a laboratory, from the model's thresholds and the shots so far."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..checks import show
from ..io.shots import answers, read_shots
from .levels import dixon_mood, next_level
from .probit import Estimate, estimate, has_estimate

RANGE = 4.0
"""Standard deviations about the model's mean between which the mean is guessed."""
SHOCK = ("f0", "duration", "direction", "shape")
"""Columns of a table of shots that must say the same of all."""


class Plan(NamedTuple):
    """The next shot, and what those so far say.

    N: multiples of g; why: what it is for; estimate: None while shots leave it open
    dixon_mood: mean and standard deviation by the sums of the method up-and-down, or None
    """

    N: float
    why: str
    estimate: Estimate | None
    dixon_mood: tuple[float, float] | None


def plan_shots(
    prior: xr.Dataset | tuple[float, float],
    shots: str | Path | Mapping[str, Sequence] = (),
    method: str = "neyer",
    confidence: float = 0.95,
) -> Plan:
    """Choose the N of the next shot, and estimate from those so far at which N devices trip.

    prior: what `tolerance` returns, of one pulse, C and f0; or mean and standard deviation of the
        thresholds, multiples of g
    shots: a CSV file, or columns by name: N and tripped (yes or no); in the order of the shots, all
        with the same pulse
    method: neyer (D-optimal), langlie or up-and-down; confidence: of the intervals, two-sided
    The estimate has mean, sigma, and the levels no_fire and all_fire at which 0.1 and 99.9 % trip,
    each with value, low and high. Raises ValueError, one line, for a value that cannot be.

    >>> plan = snapmap.plan_shots((1000, 50), {"N": [1000, 1100], "tripped": [False, True]})
    >>> plan.N
    1050.0
    """
    mean, sigma = _of_model(prior)
    N, tripped = _columns(shots)
    ends = mean - RANGE * sigma, mean + RANGE * sigma
    level, why = next_level(N, tripped, method, *ends, sigma)
    known = estimate(N, tripped, confidence) if has_estimate(N, tripped) else None
    sums = dixon_mood(N, tripped) if known and method == "up-and-down" else None
    return Plan(level, why, known, sums)


def _of_model(prior):
    """Mean and standard deviation of the thresholds."""
    if isinstance(prior, xr.Dataset):
        if "N_mean" not in prior:
            raise ValueError("prior: has no N_mean; give what tolerance returns")
        if prior.N_mean.size > 1:
            several = ", ".join(key for key in prior.N_mean.dims if prior.sizes[key] > 1)
            raise ValueError(f"prior: has several values of {several}; choose one by .sel")
        prior = prior.N_mean.item(), prior.N_std.item()
    mean, sigma = (float(one) for one in prior)
    if not (0 < mean < np.inf and 0 < sigma < np.inf):
        raise ValueError(f"prior: {mean:g}, {sigma:g} are no mean and standard deviation above 0")
    return mean, sigma


def _columns(shots):
    """N and whether it tripped, (shots,) each; ValueError, one line, for what cannot be."""
    table = read_shots(shots) if isinstance(shots, str | Path) else dict(shots)
    if not any(len(column) for column in table.values()):
        return np.empty(0), np.empty(0, bool)
    for key in ("N", "tripped"):
        if key not in table:
            raise ValueError(f"shots: column {key} is missing")
    for key in SHOCK:
        if len(found := {str(value): None for value in table.get(key, ())}) > 1:
            raise ValueError(f"shots: {key}: {', '.join(found)[:60]}; plan each pulse by itself")
    for place, value in enumerate(table["N"], start=1):
        if not (isinstance(value, int | float | np.number) and 0 < value < np.inf):
            raise ValueError(f"shots, row {place}: N: {show(value)} is no number above 0")
    return np.array(table["N"], float), answers(table["tripped"])

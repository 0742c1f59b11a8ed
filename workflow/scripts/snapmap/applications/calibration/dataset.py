"""Estimates of a device from its shots as an xarray dataset, with intervals and residuals."""

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import xarray as xr
from scipy.special import log_ndtr, logsumexp

from ...files.text import plain
from ...study.arguments import SingleStudy
from ...study.axes import attributes_of
from ...study.study import OF_THRESHOLDS, Study
from ...study.variables import dress
from ...values.kinds import Fitting, kind_of
from ...values.quantities import Damper, ExistingPath
from ...values.records import ByKeys
from ...values.units import OF_DAMPER
from .shots import Shots, UnknownsSection, check_ranges, shots_from
from .surface import (
    CONFIDENCE,
    PRIOR,
    SPREADS,
    Likelihood,
    Profile,
    Surface,
    exp,
    information_at,
    log_thresholds,
    reach,
    surface_of,
)

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

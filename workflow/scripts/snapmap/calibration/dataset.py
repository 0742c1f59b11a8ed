"""A device read off its shots, as an xarray dataset: estimates, intervals, residuals."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator
from scipy.special import log_ndtr
from scipy.stats import t

from ..axes import COORDINATES
from ..device import Device
from ..io.counting import counting
from ..io.variables import headed, variables
from ..study import THRESHOLD_SETTINGS, Study, study_of
from .information import information_at, untold
from .likelihood import SPREADS, Likelihood
from .profile import CONFIDENCE, Profile
from .ranges import check_ranges
from .shots import Shots, shots_from
from .surface import Surface, surface_of

DIGITS = 6
"""Of what is fitted; the library's own last digits are not those of every machine."""
INSIDE = 300
"""Places within the intervals over which the likelihood of spreads is summed, about."""
FINE, LEAST_LOG = 2001, -100.0
"""Places between values of a likelihood, and its least logarithm, as 0 has none."""
VARIABLES = variables("calibration") | {"f0": COORDINATES["f0"]}
NEAR = 2.0
"""Times a threshold: campaigns with no shot as near tell nothing of a device."""
OPEN = "open_low", "open_high"


class Fit(NamedTuple):
    """What was fitted: the likelihood over the ranges, and the thresholds under it."""

    shots: Shots
    surface: Surface
    likelihood: Likelihood
    profile: Profile
    freedom: int


def calibrate(
    device: Device,
    shots: str | Path | Mapping[str, Sequence],
    unknowns: Mapping[str, tuple[float, float]],
    C: float | None = None,
    model: str | Mapping = "auto",
    **options,
) -> xr.Dataset:
    """Find the values of a device that its shots, tripped or not, are likeliest with.

    shots: a CSV file, or columns of one length, such as a pandas table: `N` (multiples of g),
        `duration` (us) or `f0` (Hz), `tripped` (true or false) and, if wanted, `direction` (+z,
        -z), `shape` (its name), `file` (path of a recorded shock, in place of shape; N is its peak,
        and scales it) and `unit` (a name: specimens that differ are a spread of their own)
    unknowns: by name the range, internal units, in which a value of the device is looked for, or C
    C: uN us/um, unless it is unknown
    model: name, or as a mapping the whole of the config's model section
    options: as in `study.study_of`: horizon (us), energy_tolerance, threads, pulse and direction of
        shots that name none, and options of the model
    A shot trips with probability Phi(ln(N / N_first) / spread). Over `unknown`: estimate, the
    likeliest value; low and high, its interval at 95 % by the profile of the likelihood, which is
    integrated over the spread; open_low and open_high, where the range ends it; correlation over
    `unknown` and `unknown_2`; over `bound`: spread, relative, and unit_share, how much of its
    variance is between units; over `shot`: threshold, probability, deviance residual. Attributes:
    untold, what cannot be told apart; model_error, relative, of thresholds between those found.
    Thresholds have the same bits on every machine; what is fitted is rounded to six digits.
    Raises ValueError, one line, for shots or ranges that cannot be.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> shots = {"N": [800, 900, 950, 1000, 1050, 1200], "tripped": [0, 0, 0, 1, 1, 1]}
    >>> shots["duration"] = [1000.0] * 6
    >>> found = snapmap.calibrate(device, shots, {"thickness": (1.7, 2.3)}, C=25.0)
    >>> round(found.estimate.item(), 1)
    2.0
    """
    study, _ = study_of(device, model, options)
    with counting("calibrate"):
        return calibration_of(study, shots, unknowns, C)


def calibration_of(
    study: Study,
    table: str | Path | Mapping,
    unknowns: Mapping,
    C: float | None,
    files: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Find the values of a study's device from a table of shots, as `calibrate` returns them.

    files: as in `shots_from`
    """
    _check(study, unknowns, C)
    shots = shots_from(table, study.shocks, study.device, files)
    surface = surface_of(study, shots.kinds, unknowns, C)
    _check_reach(shots, surface)
    return fit(shots, surface).assign_attrs(
        **headed("calibration", _document(study, unknowns, C)),
    )


def fit(shots: Shots, surface: Surface) -> xr.Dataset:
    """Fit shots to thresholds over the ranges of unknowns."""
    likelihood = Likelihood(shots, surface.error)
    nodes = likelihood.integrated(surface.logs.reshape(-1, len(shots.kinds)))
    profile = Profile(
        lambda u: likelihood.integrated(surface.at(u)), nodes.reshape(surface.logs.shape[:-1])
    )
    freedom = shots.N.size - len(surface.unknowns) - 1
    done = Fit(shots, surface, likelihood, profile, freedom)
    names = list(surface.unknowns)
    intervals = [profile.interval(k, freedom) for k in range(len(names))]
    data, units = _unknowns(done, intervals), {"unknown": names, "unknown_2": names}
    spreads = _spreads(done, intervals)
    data |= {key: ("bound", _rounded(values), VARIABLES[key]) for key, values in spreads.items()}
    told = information_at(profile.best, surface, likelihood, spreads["spread"][0])
    scale = np.sqrt(np.diag(told.covariance))
    data["correlation"] = (
        ("unknown", "unknown_2"),
        _rounded(told.covariance / np.outer(scale, scale)),
        {"long_name": "correlation of estimates, their ranges being known", "units": "1"},
    )
    data |= _of_shots(done, told, spreads["spread"][0])
    bounds = {"bound": ["estimate", "low", "high"]}
    return xr.Dataset(data, units | bounds).assign_attrs(
        untold=_untold_text(told, names), model_error=float(_rounded(surface.error.max()))
    )


def _check_reach(shots, surface):
    """Raise ValueError if no shot is near any threshold within the ranges."""
    axes = tuple(range(surface.logs.ndim - 1))
    low, high = surface.logs.min(axis=axes)[shots.kind], surface.logs.max(axis=axes)[shots.kind]
    log_N = np.log(shots.N)
    if (np.maximum(low - log_N, log_N - high) > np.log(NEAR)).all():
        raise ValueError(
            f"shots: N from {shots.N.min():.4g} to {shots.N.max():.4g}, where the ranges lead to "
            f"thresholds from {np.exp(low.min()):.4g} to {np.exp(high.max()):.4g}; is N in "
            "multiples of g?"
        )


def _unknowns(done, intervals):
    """Estimates and intervals in the unknowns' own units."""
    u = [[one.low for one in intervals], [one.high for one in intervals]]
    ends = [done.surface.values(np.array(end)) for end in u]
    data = {"estimate": done.surface.values(done.profile.best), "low": ends[0], "high": ends[1]}
    data = {key: _rounded(values) for key, values in data.items()}
    data |= {key: np.array([getattr(i, key) for i in intervals], np.int8) for key in OPEN}
    unit = ", ".join(f"{key}: {COORDINATES[key]['units']}" for key in done.surface.unknowns)
    return {
        key: ("unknown", values, VARIABLES[key] | ({} if key in OPEN else {"comment": unit}))
        for key, values in data.items()
    }


def _spreads(done, intervals):
    """Mean, low and high of the spread and, where units come again, of their share."""
    ends = np.array([[one.low, one.high] for one in intervals])
    half = (ends[:, 1] - ends[:, 0]) / 2
    low, high = np.clip([ends[:, 0] - half, ends[:, 1] + half], 0.0, 1.0)
    size = round(INSIDE ** (1 / len(ends)))
    mesh = np.meshgrid(*np.linspace(low, high, size).T, indexing="ij")
    places = np.stack(mesh, axis=-1).reshape(-1, len(ends))
    logs = done.likelihood.of(done.surface.at(places))
    whole = np.exp(logs - logs.max()).sum(axis=0)
    weighed = whole * SPREADS[:, np.newaxis]
    mean = np.average(SPREADS, weights=weighed.sum(axis=1))
    ends = np.exp(_ends(np.log(SPREADS), whole.sum(axis=1), done.freedom))
    found = {"spread": np.array([mean, *ends])}
    shares, likely = done.likelihood.shares, weighed.sum(axis=0)
    if shares.size > 1:
        mean = np.average(shares, weights=likely)
        found["unit_share"] = np.array([mean, *_ends(shares, likely, done.freedom)])
    return found


def _ends(x, likelihood, freedom):
    """The ends of what 95 % ask for, between values of a likelihood."""
    fine = np.linspace(x[0], x[-1], FINE)
    with np.errstate(divide="ignore"):
        logs = np.maximum(np.log(likelihood / likelihood.max()), LEAST_LOG)
    log = PchipInterpolator(x, logs)(fine)
    return fine[log >= log.max() - _reach(freedom) ** 2 / 2][[0, -1]]


def _reach(freedom):
    """Standard deviations within which 95 % lie, by Student."""
    return t.ppf((1 + CONFIDENCE) / 2, max(1, freedom))


def _of_shots(done, told, spread):
    """The columns of the table, and what is fitted to each shot."""
    shots, kind = done.shots, done.shots.kind
    logs = done.surface.at(done.profile.best[None])[0]
    variance = np.einsum("ij,jk,ik->i", told.slopes, told.covariance, told.slopes)
    half = _reach(done.freedom) * np.sqrt(variance)
    error = np.sqrt(spread**2 + done.surface.error**2)[kind]
    z = (np.log(shots.N) - logs[kind]) / error
    sign = np.where(shots.tripped, 1.0, -1.0)
    data = {
        "N": shots.N,
        "f0": shots.f0,
        "direction": np.array([shots.kinds[i].direction for i in kind]),
        "shape": np.array([shots.kinds[i].shape for i in kind]),
        "unit": shots.unit,
        "tripped": shots.tripped.astype(np.int8),
        "threshold": _rounded(np.exp(logs)[kind]),
        "threshold_low": _rounded(np.exp(logs - half)[kind]),
        "threshold_high": _rounded(np.exp(logs + half)[kind]),
        "probability": _rounded(np.exp(log_ndtr(z))),
        "residual": _rounded(sign * np.sqrt(-2 * log_ndtr(sign * z))),
    }
    return {key: ("shot", values, VARIABLES[key]) for key, values in data.items()}


def _untold_text(told, names):
    """What the shots tell little of, in words; nothing if they tell of all."""
    lines = []
    for direction in told.directions[untold(told)]:
        parts = [f"{x:+.2f} {name}" for x, name in zip(direction, names, strict=True)]
        parts = [part for part in parts if not part.startswith(("+0.0", "-0.0"))]
        lines.append(" ".join(parts))
    if not lines:
        return ""
    return f"beyond the ranges the shots say little of {'; of '.join(lines)} (in ranges)"


def summary(found: xr.Dataset) -> str:
    """One line: each value with its interval, the spread, what is not told apart."""
    told = [f"{found.sizes['shot']} shots"]
    for key in found.unknown.values:
        one = found.sel(unknown=key)
        ends = [
            f"{one[end].item():.4g}{' (its range ends)' * one[f'open_{end}'].item()}"
            for end in ("low", "high")
        ]
        told.append(f"{key} {one.estimate.item():.4g} ({' to '.join(ends)})")
    spread = found.spread.values * 100
    told.append(f"spread {spread[0]:.2g} % ({spread[1]:.2g} to {spread[2]:.2g} %)")
    return ", ".join([*told, *[found.untold] * bool(found.untold)])


def _rounded(values):
    """To so many digits."""
    values = np.asarray(values, float)
    return np.vectorize(lambda x: float(f"{x:.{DIGITS}g}"))(values) if values.size else values


def _document(study, unknowns, C):
    ranges = {key: [float(end) for end in ends] for key, ends in unknowns.items()}
    given = {} if C is None else {"C": float(C)}
    return study.document(THRESHOLD_SETTINGS) | {"calibration": {"unknowns": ranges} | given}


def _check(study, unknowns, C):
    if len(study.settings.pulses) > 1:
        raise ValueError("pulse: several; name the shape and direction of each shot in its row")
    check_ranges(unknowns, C)

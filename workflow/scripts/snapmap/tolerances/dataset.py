"""Thresholds of devices as made, as an xarray dataset: probability, sensitivity and yield."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr

from ..axes import COORDINATES, NAMES
from ..beam.stress import break_probability
from ..device import Device
from ..io.counting import counting
from ..io.variables import dress
from ..numerics.portable import geometric
from ..solver.cells import to_rows
from ..study import THRESHOLD_SETTINGS, Study, frequencies, study_of, with_shocks
from .batch import Batch, choose_builder
from .samples import INDEX_SAMPLES, SHOCK_FACTORS, Plan, Tolerances
from .sensitivity import crossed, indices
from .statistics import count_below, left_out, moments, percents, quantile_bounds, quantiles, wilson

QUANTILES = (0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999)
AMPLITUDES = 101
"""Values of N, by default from the lowest to the highest threshold."""
FOLLOWED_CELLS, FEWEST_FOLLOWED = 1_000_000, 64
"""So many cells are followed to their end, or at least those of so many samples."""

BOUND = ("low", "high")


def tolerance(
    device: Device | Mapping[str, Device],
    scatters: Mapping[str, float | str | Mapping],
    f0: Sequence[float] | None,
    C: Sequence[float],
    N: Sequence[float] | None = None,
    model: str | Mapping = "auto",
    tolerance: float = 1e-3,
    **options,
) -> xr.Dataset:
    """Find the thresholds, over C (uN us/um) and f0 (Hz), of devices whose values scatter.

    device: the nominal one, or several by name, which then are an axis
    scatters: of each value the standard deviation, a number in internal units or a share such as
        "5 %", or {kind: width}; kind is uniform (half width), lognormal, or truncated (at two
        standard deviations). N, duration and C scatter from shock to shock, in shares
    f0: None for a recorded shock's own; N: multiples of g at which the probability is given;
        by default from the lowest to the highest threshold
    model: name, or as a mapping the whole of the config's model section; `auto` takes the cheapest
        level that keeps its tolerance for the nominal device
    tolerance: of the refinement of each threshold, relative; those of `auto` are off by that of its
        level, too, up to 0.1 % unless the model's section says another tolerance
    options: samples, index_samples, seed and together, as in `Tolerances`; requirements: name,
        shocks (of one shape and direction), N, f0 (Hz) and snaps of each, and survives, whether
        its beam must not break, by default; and as in
        `study.study_of`: horizon (us), energy_tolerance, threads, pulse, direction, and options of
        the model
    Raises ValueError, one line, for a value that cannot be.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> made = snapmap.tolerance(device, {"thickness": "5 %"}, [1500], [25], samples=64)
    >>> round((made.N_std / made.N_mean).item(), 2)
    0.1
    """
    given = {key: options.pop(key) for key in Tolerances._fields if key in options}
    requirements = [with_shocks(one) for one in options.pop("requirements", ())]
    study, _ = study_of(device, model, options)
    axes = {"C": C, "f0": frequencies(f0, study.shocks)}
    axes |= {} if N is None else {"N": N}
    with counting("tolerance"):
        return tolerances_of(study, axes, Tolerances(scatters, **given), requirements, tolerance)


def tolerances_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    asked: Tolerances,
    requirements: Sequence[Mapping] = (),
    tolerance: float = 1e-3,
) -> xr.Dataset:
    """Find the thresholds of a study's devices as made, as `tolerance` returns them.

    axes: C, f0 and, unless it is to be chosen, N
    """
    settings, samples = study.settings, asked.samples
    if (asked.index_samples or 0) > samples:
        raise ValueError(f"index_samples: {asked.index_samples} is more than samples, {samples}")
    N = axes.get("N")
    axes = {key: np.atleast_1d(np.asarray(axes[key], float)) for key in ("C", "f0")}
    pulses = np.arange(len(settings.pulses))[:, np.newaxis, np.newaxis]
    rows = to_rows(0, axes["f0"], axes["C"][:, np.newaxis], pulses)
    paired = min(samples, asked.index_samples or INDEX_SAMPLES)
    power = 1 << (paired.bit_length() - 1)
    found = []
    for one in study.devices().values():
        plan = Plan(one, asked.scatters, asked.together)
        points = plan.points(samples, asked.seed)
        paired = points[:, :power]
        every = np.concatenate([points[0], paired[1], *crossed(paired)])
        build = choose_builder(one, study.model, rows, settings)
        some, whole = (Batch(one, plan, part, build) for part in (points[0], every))
        data, N_first = _thresholds(whole, samples, study.shocks, axes, settings, tolerance)
        data = data.merge(_made(some))
        data = data.merge(_indices(N_first, samples, power, plan, asked.seed, data))
        data = data.merge(_probability(data, N))
        if one.beam.damping > 0:
            data = data.merge(_latched(some, data, settings))
        if requirements:
            own = replace(study, device=one)
            data = data.merge(_requirements(some, own, requirements, data, tolerance))
        found.append(data)
    data = found[0]
    if isinstance(study.device, Mapping):
        names = xr.Variable("device", list(study.device), COORDINATES["device"])
        data = xr.concat(found, names, join="outer")
    made_by = study.document(THRESHOLD_SETTINGS)
    own = {"samples": samples, "seed": asked.seed, "together": asked.together}
    made_by["tolerances"] = {**asked.scatters, **own}
    return dress("tolerance", data, made_by, threshold_tolerance=tolerance)


def summary(found: xr.Dataset) -> str:
    """One line: how many samples there are, how far thresholds scatter, what owes it, the yield."""
    size, missing = found.bistable.size, int((found.bistable == 0).sum())
    spread = (found.N_std / found.N_mean).values
    spread = spread[np.isfinite(spread)]
    told = [f"{size} samples", f"{missing} without a second stable shape"]
    if spread.size:
        told.append(f"thresholds scatter by {spread.min():.2g} to {spread.max():.2g}, relative")
    told += _most_owed(found.sensitivity.sel(order="total"))
    for key, word in (("yield", "yield"), ("share_breaking", "break")):
        if key in found:
            told.append(f"{word} {percents(*found[key].values.ravel())}{left_out(found[key])}")
    return ", ".join(told)


def _most_owed(sensitivity):
    """What thresholds owe most of their variance to; where that differs, of each named pulse."""
    named = [dim for dim in NAMES if dim in sensitivity.dims]
    owed = sensitivity.mean([dim for dim in sensitivity.dims if dim not in ("value", *named)])
    most = {}
    for place in product(*(range(owed.sizes[dim]) for dim in named)):
        one = owed.isel(dict(zip(named, place, strict=True)))
        if one.notnull().any():
            names = " ".join(str(one[dim].item()) for dim in named)
            most.setdefault(one.idxmax().item(), []).append(names)
    if len(most) < 2:
        return [f"most by {value}" for value in most]
    return [f"most by {value} ({', '.join(names)})" for value, names in most.items()]


def _made(some):
    """The values of the samples."""
    values = {key: ("sample", column) for key, column in some.values.items()}
    for key in SHOCK_FACTORS:
        if key in values:
            name = {"long_name": f"{key} over its nominal value", "units": "1"}
            values[f"{key}_factor"] = *values.pop(key), name
    return xr.Dataset(values | {"bistable": ("sample", some.bistable.astype(np.int8))})


def _thresholds(whole, samples, shocks, axes, settings, tolerance):
    """N_first of the samples proper with its moments; and of all, (all, ...)."""
    groups = shocks.axes | axes
    shape = [values.size for values in groups.values()]
    N_first, nominal, ragged = whole.thresholds(*axes.values(), settings, tolerance)
    N_first = N_first.reshape(-1, *shape)
    own = N_first[:samples]
    mean, std = moments(own)
    data = {
        "N_first": (("sample", *groups), own),
        "N_nominal": (tuple(groups), nominal.reshape(shape)),
        "N_mean": (tuple(groups), mean),
        "N_std": (tuple(groups), std),
        "N_quantile": (("quantile", *groups), quantiles(own, QUANTILES)),
        "N_quantile_bound": (("bound", "quantile", *groups), quantile_bounds(own, QUANTILES)),
        "ragged": (tuple(groups), ragged.reshape(shape).astype(np.int8)),
    }
    named = {"quantile": list(QUANTILES), "bound": list(BOUND)}
    return xr.Dataset(data, groups | named), N_first


def _indices(N_first, samples, power, plan, seed, data):
    """Sobol indices of N_first: samples proper, their partners, and both crossed."""
    groups = data.N_nominal.dims
    names = plan.names
    flat = N_first.reshape(len(N_first), -1)
    second, mixed = flat[samples : samples + power], flat[samples + power :]
    mixed = mixed.reshape(len(names), power, -1)
    told = indices(flat[:power], second, mixed, seed)
    told = told.reshape(*told.shape[:3], *data.N_nominal.shape)
    dims = "order", "value", *groups
    return xr.Dataset(
        {
            "sensitivity": (dims, told[:, 0]),
            "sensitivity_bound": (("bound", *dims), np.moveaxis(told[:, 1:], 1, 0)),
        },
        {"order": ["first", "total"], "value": names, "bound": list(BOUND)},
    )


def _probability(data, N):
    """Share of the samples that snap at each N."""
    own = data.N_first.values
    if N is None:
        known = own[np.isfinite(own)]
        ends = (known.min(), known.max()) if known.size else (1.0, 2.0)
        N = np.append(geometric(*ends, AMPLITUDES)[:-1], ends[1])  # to its last digit
    N = np.sort(np.atleast_1d(np.asarray(N, float)))
    return _share("probability", count_below(own, N), len(own), (*data.N_nominal.dims, "N"), N=N)


def _share(name, count, size, dims, **coords):
    """A share of samples with its bounds."""
    values = {
        name: (dims, count / size),
        f"{name}_bound": (("bound", *dims), np.stack(wilson(count, size))),
    }
    return xr.Dataset(values, coords | {"bound": list(BOUND)})


def _latched(some, data, settings):
    """Share of the samples that stay latched, of as many as are affordable."""
    groups, N = data.N_nominal, data.N.values
    size = FOLLOWED_CELLS // (groups.size * N.size)
    size = min(len(some.bistable), max(FEWEST_FOLLOWED, size))
    count = some.latched(size, N, data.C.values, data.f0.values, settings)
    dims = (*groups.dims, "N")
    return _share("latched", count.reshape(*groups.shape, N.size), size, dims, N=N)


def _requirements(some, study, requirements, data, tolerance):
    """Thresholds of the required pulses, and the shares that meet each requirement, and all."""
    C, size = data.C.values, len(some.bistable)
    first, meets = [], []
    for asked in requirements:
        own = study.settings._replace(pulses=asked["shocks"].pulses)
        f0 = np.array([asked["f0"]])
        first.append(some.thresholds(C, f0, own, tolerance)[0][:, 0, :, 0])
        snapped = some.snapped(asked["N"], C, asked["f0"], own)
        meets.append((snapped == asked["snaps"]) & some.bistable[:, np.newaxis])
    meets = np.array(meets)
    names = {"requirement": [asked["name"] for asked in requirements]}
    columns = {
        "N_first_required": (("requirement", "sample", "C"), np.array(first)),
        "N_required": ("requirement", [float(asked["N"]) for asked in requirements]),
        "f0_required": ("requirement", [float(asked["f0"]) for asked in requirements]),
        "must_snap": ("requirement", np.array([a["snaps"] for a in requirements], np.int8)),
    }
    shares = [_share("share_meeting", meets.sum(axis=1), size, ("requirement", "C"))]
    good = meets.all(axis=0).astype(float)
    if study.device.strength < np.inf and some.size:
        stress = some.stresses(study, requirements, C)
        followed = np.flatnonzero(some.bistable)[: stress.shape[1]]
        columns["stress_max"] = ("requirement", "sample", "C"), np.full(meets.shape, np.nan)
        columns["stress_max"][1][:, followed] = stress
        broken = break_probability(study.device, stress).sum(axis=1)
        shares.append(_share("share_breaking", broken, followed.size, ("requirement", "C")))
        must = [bool(asked.get("survives", True)) for asked in requirements]
        largest = stress[must].max(axis=0, initial=0.0)
        good[followed] *= 1 - break_probability(study.device, largest)
        good = good[: followed[-1] + 1]
    shares.append(_share("yield", good.sum(axis=0), len(good), ("C",)))
    return xr.merge([xr.Dataset(columns, names), *shares])

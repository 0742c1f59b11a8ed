"""Thresholds of devices as made, as an xarray dataset: probability, sensitivity and yield."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np
import xarray as xr

from ...beam.stress import break_probability
from ...device.samples import (
    SAMPLES,
    SEED,
    SHOCK_FACTORS,
    Groups,
    Plan,
    Samples,
    Scatters,
    Tolerances,
)
from ...files.text import plain
from ...numerics.portable import geometric
from ...numerics.statistics import CONFIDENCE, DECIMALS, percents, scope, share_bounds
from ...solver.cells import to_rows
from ...study.arguments import AnyStudy, Requirements
from ...study.axes import attributes_of, frequencies
from ...study.shock import Shock
from ...study.study import ANY, ARRIVES, OF_THRESHOLDS, SNAPS, Study
from ...study.variables import dress
from ...thresholds.population import Batch, choose_levels
from ...values.quantities import Amplitudes, Dampers, Frequencies, PulseTimes, Refinement, Seed

RESAMPLES = 100
"""Number of bootstrap resamples for the confidence intervals."""
ENDS = (0.025, 0.975)
"""Quantiles of the resamples at the ends of an interval at 95 %."""
FEWEST = 16
"""Least number of samples for indices."""
PLACES = 6


def crossed(points: np.ndarray) -> np.ndarray:
    """Return copies of the first set of points, each with another draw from the second set.

    points: (2, samples, draws); returns (draws, samples, draws)
    """
    first, second = points
    return np.where(np.eye(first.shape[1], dtype=bool)[:, np.newaxis], second, first)


def indices(first: np.ndarray, second: np.ndarray, crossed: np.ndarray, seed: int) -> np.ndarray:
    """Estimate first-order and total indices by Saltelli et al. (2010), (2, 3, draws, outputs).

    first, second: values at two sets of points, (samples, outputs)
    crossed: values at the points of `crossed`, (draws, samples, outputs)
    The second axis holds an index and the ends of its interval. Samples with a NaN are left out.
    The indices are NaN with fewer than FEWEST samples, or if nothing scatters.
    """
    draws, _, outputs = crossed.shape
    result = np.full((2, 3, draws, outputs), np.nan)
    known = np.isfinite(first) & np.isfinite(second) & np.isfinite(crossed).all(axis=0)
    for i in range(outputs):
        places = np.flatnonzero(known[:, i])
        if places.size < FEWEST or np.ptp(first[places, i]) == 0:
            continue
        if draws == 1:
            result[..., i] = 1.0
            continue
        weights = _weights(places.size, seed)
        sets = _both_orders(first[places, i], second[places, i], crossed[:, places, i], weights)
        result[:, 0, :, i] = sets[..., 0]
        result[:, 1:, :, i] = np.moveaxis(np.quantile(sets[..., 1:], ENDS, axis=-1), 0, 1)
    return np.round(result, PLACES)


@lru_cache(maxsize=1)
def _weights(size, seed):
    """Weights of samples, (size, 1 + RESAMPLES): equal ones, then those of each resample."""
    even = np.full(size, 1 / size)
    drawn = np.random.default_rng(seed).multinomial(size, even, RESAMPLES)
    return np.column_stack([even, *drawn / size])


def _both_orders(first, second, crossed, weights):
    """First-order and total indices, (2, draws, sets), for weights of n samples, (n, sets)."""
    mean = first.mean()
    first, second, crossed = first - mean, second - mean, crossed - mean
    apart, middle = crossed - first, (first + second) @ weights / 2
    variance = (first * first + second * second) @ weights / 2 - middle * middle
    alone = (second * apart) @ weights - middle * (apart @ weights)
    return np.array([alone, (apart * apart) @ weights / 2]) / variance


def count_below(N_first: np.ndarray, N: np.ndarray) -> np.ndarray:
    """Count the samples, (samples, ...), that are not above each N, (..., N); NaN is above all."""
    ordered = np.moveaxis(np.sort(N_first, axis=0), 0, -1)
    counts = [np.searchsorted(row, N, side="right") for row in ordered.reshape(-1, len(N_first))]
    return np.reshape(counts, (*N_first.shape[1:], len(N)))


def quantiles(N_first: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Find the N at which each share of the samples snaps, (shares, ...); NaN if fewer do."""
    ordered = np.sort(N_first, axis=0)
    places = np.ceil(np.asarray(shares) * len(N_first) - 1e-9).astype(int) - 1
    return ordered[np.maximum(places, 0)]


def quantile_bounds(
    N_first: np.ndarray, shares: np.ndarray, confidence: float = CONFIDENCE
) -> np.ndarray:
    """Bound `quantiles` from below and above, (2, shares, ...), each alone at a confidence.

    Order statistics give bounds for any distribution; NaN if there are too few samples.
    """
    from scipy.stats import binom  # half a second, for which no config that is read has to wait

    size, shares = len(N_first), np.asarray(shares)
    least, most = binom.ppf([[1 - confidence], [confidence]], size, shares).astype(int)
    ordered = np.sort(N_first, axis=0)
    ordered = np.concatenate([np.full_like(ordered[:1], np.nan), ordered, ordered[:1] * np.nan])
    return ordered[[least, most + 1]]


def moments(N_first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard deviation of the samples that are not NaN, (...)."""
    mean, std = np.full((2, *N_first.shape[1:]), np.nan)
    for place in np.ndindex(mean.shape):
        values = N_first[(slice(None), *place)]
        values = values[np.isfinite(values)]
        if values.size:
            mean[place] = math.fsum(values) / values.size
        if values.size > 1:
            squares = math.fsum((values - mean[place]) ** 2)
            std[place] = math.sqrt(squares / (values.size - 1))
    return mean, std


QUANTILES = (0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999)
ALL = 0.999
"""Share that snaps at the all-fire level, if no requirement asks for another."""
AMPLITUDES = 101
"""Default number of values of N, from the lowest to the highest threshold."""


def tolerance(
    study: AnyStudy,
    scatters: Scatters,
    f0: Frequencies | None,
    C: Dampers,
    N: Amplitudes | None = None,
    *,
    duration: PulseTimes | None = None,
    threshold_tolerance: Refinement = 1e-3,
    samples: Samples = SAMPLES,
    index_samples: Samples | None = None,
    seed: Seed = SEED,
    together: Groups = (),
    requirements: Requirements = (),
) -> xr.Dataset:
    """Find the thresholds of devices whose values scatter.

    Parameters
    ----------
    study
        Devices, model, shocks, and how each cell is followed; or a Device.
    scatters
        Standard deviation of each value, in internal units or as a share such as "5 %", or
        {kind: width} of normal, uniform (half width), lognormal or truncated (at two standard
        deviations); N, duration and C scatter from shock to shock, in shares.
    f0
        Frequencies of the pulse, Hz, each once; None for a recorded shock.
    C
        Dampings of the mass, uN us/um, each once.
    N
        Amplitudes to give probabilities at, multiples of g; by default the range of thresholds.
    duration
        Durations of the pulse, us, in place of f0.
    threshold_tolerance
        Relative step of N at which each search ends.
    samples
        Number of devices.
    index_samples
        Number of devices for Sobol indices; by default as many as are affordable.
    seed
        Seed of the random devices.
    together
        Groups of names, as [["span", "rise"]]; a single draw moves each group.
    requirements
        Mappings of name, N, f0 (Hz) or duration (us), snaps and optionally pulse, direction, start,
        survives (how surely it must not break), share and confidence (what share of devices
        must meet it).

    Returns
    -------
    Dataset
        Statistics of the thresholds over (..., C, f0), probabilities of a snap over N, Sobol
        indices of each value that scatters, and the yield under the requirements.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, for a sample that cannot exist.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> made = snapmap.tolerance(device, {"thickness": "5 %"}, 1500, 25, samples=64)
    >>> round((made.N_std / made.N_mean).item(), 2)
    0.1
    """
    shocks = [required.under(study.shocks) for required in requirements]
    tolerances = Tolerances(scatters, together, samples, index_samples, seed)
    axes = {"C": C, "f0": frequencies(f0, duration), "N": N}
    return tolerances_of(study, axes, tolerances, shocks, threshold_tolerance)


def tolerances_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    tolerances: Tolerances,
    requirements: Sequence[Shock] = (),
    tolerance: float = 1e-3,
) -> xr.Dataset:
    """Find the thresholds of a study's devices as made, as `tolerance` returns them.

    axes: C, f0 and optionally N, else chosen, and temperature, degC, at each point of which a
        device must meet the requirements; by default that of the device
    """
    samples, most = tolerances.samples, tolerances.index_samples
    if (most or 0) > samples:
        line = f"index_samples: {most} is more than samples, {samples}; write that or less"
        raise ValueError(line)
    parts = [
        _of_device(replace(study, device=device), axes, tolerances, requirements, tolerance)
        for device in study.devices().values()
    ]
    data = parts[0]
    if isinstance(study.device, Mapping):
        names = xr.Variable("device", list(study.device), attributes_of("device"))
        data = xr.concat(parts, names, join="outer")
    document = study.document(OF_THRESHOLDS)
    document["tolerances"] = tolerances.section
    dataset = dress("tolerance", data, document, threshold_tolerance=tolerance)
    if requirements:
        nominal = [device.temperature for device in study.devices().values()]
        degrees = axes.get("temperature", nominal)
        ends = dict.fromkeys([plain(min(degrees)), plain(max(degrees))])
        dataset["yield"].attrs["temperatures"] = f"{' to '.join(ends)} degC"
    return dataset


def _of_device(study, axes, tolerances, requirements, tolerance):
    """The dataset of one device, without attributes."""
    settings, samples, device = study.run, tolerances.samples, study.device
    C, f0 = (np.atleast_1d(np.asarray(axes[key], float)) for key in ("C", "f0"))
    groups = study.shocks.axes | {"C": C, "f0": f0}
    shape = [values.size for values in groups.values()]
    pulses = study.shocks.pulses
    pulse = np.arange(len(pulses))[:, np.newaxis, np.newaxis]
    rows = to_rows(0, f0, C[:, np.newaxis], pulse, pulses)
    power = tolerances.power
    plan = Plan(device, tolerances.scatters, tolerances.together)
    points = plan.points(samples, tolerances.seed)
    partners = points[:, :power]
    every = np.concatenate([points[0], partners[1], *crossed(partners)])
    choices = choose_levels(device, study.model, rows, settings)
    batch, of_indices = (
        Batch(device, plan.values(part), study.model, choices, settings.start)
        for part in (points[0], every)
    )
    N_first, nominal, ragged = of_indices.thresholds(rows, settings, tolerance, chosen=True)
    first, second, mixed = np.split(N_first, [samples, samples + power])
    mixed = mixed.reshape(len(plan.names), power, -1)
    sobol = indices(first[:power], second, mixed, tolerances.seed)
    sobol = sobol.reshape(2, 3, -1, *shape)
    first = first.reshape(-1, *shape)
    mean, std = moments(first)
    names = {f"{key}_factor" if key in SHOCK_FACTORS else key: key for key in plan.nominal}
    data = {name: ("sample", batch.values[key]) for name, key in names.items()} | {
        "bistable": ("sample", batch.bistable.astype(np.int8)),
        "N_first": (("sample", *groups), first),
        "N_nominal": (tuple(groups), nominal.reshape(shape)),
        "N_mean": (tuple(groups), mean),
        "N_std": (tuple(groups), std),
        "N_quantile": (("quantile", *groups), quantiles(first, QUANTILES)),
        "N_quantile_bound": (("bound", "quantile", *groups), quantile_bounds(first, QUANTILES)),
        **_fire(first, tuple(groups), requirements, tolerance),
        "ragged": (tuple(groups), ragged.reshape(shape).astype(np.int8)),
        "sensitivity": (("order", "value", *groups), sobol[:, 0]),
        "sensitivity_bound": (
            ("bound", "order", "value", *groups),
            np.moveaxis(sobol[:, 1:], 1, 0),
        ),
    }
    named = {"quantile": list(QUANTILES), "bound": ["low", "high"]}
    named |= {"order": ["first", "total"], "value": plan.names}
    named["temperature"] = device.temperature
    N, along = _amplitudes(axes.get("N"), first), (*groups, "N")
    data |= _share("probability", count_below(first, N), samples, along)
    if device.beam.damping > 0:
        size = tolerances.followed(nominal.size * N.size)
        count = batch.latched(N_first[:size], N, rows, settings).reshape(*shape, N.size)
        data |= _share("latched", count, size, along)
    if requirements:
        named["requirement"] = [required.name for required in requirements]
        batches = [batch]
        if "temperature" in axes:
            tempered = [
                (device.at(degrees), batch.values | {"temperature": np.full(samples, degrees)})
                for degrees in axes["temperature"]
            ]
            batches = [Batch(*pair, study.model, choices, settings.start) for pair in tempered]
        data |= _requirements(batches, study, requirements, C, tolerance)
    return xr.Dataset(data, groups | {"N": N} | named)


def _amplitudes(N, first):
    """The values of N, ascending; without any, the range of the thresholds of samples."""
    if N is not None:
        return np.unique(np.asarray(N, float))
    known = first[np.isfinite(first)]
    low, high = (known.min(), known.max()) if known.size else (1.0, 2.0)
    below = geometric(low, high, AMPLITUDES)[:-1] if low < high else []
    return np.append(below, high)  # `geometric` may round the last digit of the end


def _fire(first, dims, requirements, tolerance):
    """The levels of no-fire and all-fire, of the largest share that a requirement asks for."""
    asked = [(required.share, required.confidence) for required in requirements if required.share]
    share, confidence = max(asked, default=(ALL, CONFIDENCE))
    low, high = quantile_bounds(first, [round(1 - share, DECIMALS), share], confidence)
    attrs = {"share": share, "confidence": confidence}
    # A threshold is the upper end of a step.
    return {
        "N_no_fire": (dims, low[0] / (1 + tolerance), attrs),
        "N_all_fire": (dims, high[1], attrs),
    }


def _share(name, count, size, dims, unsure=0.0, confidence=CONFIDENCE):
    """A share of samples with its bounds; unsure: how many may count or not, beside the count."""
    low, high = (share_bounds(each, size, confidence) for each in (count, count + unsure))
    return {
        name: (dims, (count + unsure / 2) / size),
        f"{name}_bound": (("bound", *dims), np.stack([low[0], high[1]])),
    }


def _requirements(batches, study, requirements, C, tolerance):
    """Thresholds of the required pulses, and the shares that meet each requirement, and all.

    batches: the same samples at each temperature
    A sample must meet a requirement at all temperatures and under all its shocks; the threshold is
    the worst of them. One within the tolerance of N possibly meets it.
    """
    first, meets = [], []
    for required in requirements:
        settings, levels, met = required.shaken(study).run, [], []
        for batch, shocks in product(batches, required.shocks.each()):
            rows = to_rows(0, required.f0, C, 0, shocks.pulses)
            levels.append(batch.thresholds(rows, settings, tolerance)[0])
            surely, possibly = batch.meets(required, rows, settings)
            is_close = abs(levels[-1] / required.N - 1) <= tolerance * (required.snaps != ANY)
            met.append([surely & ~is_close, possibly | is_close])
        # NaN, where nothing snaps, is above every N.
        worst = np.maximum if required.snaps in (True, ARRIVES) else np.fmin
        first.append(worst.reduce(levels))
        meets.append(np.all(met, axis=0))
    data = {
        "N_first_required": (("requirement", "sample", "C"), np.array(first)),
        "N_required": ("requirement", np.array([required.N for required in requirements], float)),
        "f0_required": ("requirement", np.array([required.f0 for required in requirements], float)),
        "must_snap": (
            "requirement",
            np.array([SNAPS[each.snaps] for each in requirements], np.int8),
        ),
    }
    # Probabilities that a sample surely and possibly meets each, and all.
    each, along = np.moveaxis(np.array(meets, float), 1, 0), ("requirement", "C")
    every = each.prod(axis=1)
    if study.device.strength < np.inf and all(batch.size for batch in batches):
        stress = np.maximum.reduce([_stresses(batch, study, requirements, C) for batch in batches])
        data["stress_max"] = ("requirement", "sample", "C"), stress
        broken = np.nan_to_num(break_probability(study.device, stress))
        count = np.isfinite(stress[0, :, 0]).sum()
        data |= _share("share_breaking", broken.sum(axis=1), count, along)
        broken[[not required.survives for required in requirements]] = 0.0
        each, every = each * (1 - broken), every * (1 - broken.max(axis=0))
    (least, most), size = each.sum(axis=2), each.shape[2]
    confidence = np.array([[required.confidence] for required in requirements])
    data |= _share("share_meeting", least, size, along, most - least, confidence)
    least, most = every.sum(axis=1)
    return data | _share("yield", least, size, ("C",), most - least)


def _stresses(batch, study, requirements, C):
    """The largest stress under each requirement, MPa, (requirements, samples, C).

    It is NaN for samples without a second shape.
    """
    largest = np.full((len(requirements), batch.bistable.size, len(C)), np.nan)
    for row, required in zip(largest, requirements, strict=True):
        row[batch.bistable] = batch.stresses(study, required, C)
    return largest


def summary(tolerance: xr.Dataset) -> str:
    """Write in a line the number of samples, the scatter of thresholds and its cause, the yield."""
    size, missing = tolerance.bistable.size, int((tolerance.bistable == 0).sum())
    spread = (tolerance.N_std / tolerance.N_mean).values
    words = [f"{size} samples", f"{missing} without a second stable shape"]
    if np.isfinite(spread).any():
        words.append(f"thresholds scatter by {percents(*spread.ravel())}")
    total = tolerance.sensitivity.sel(order="total")
    total = total.mean([dim for dim in total.dims if dim != "value"])
    if total.notnull().any():
        words.append(f"most by {total.idxmax().item()}")
    for key, word in (("yield", "yield"), ("share_breaking", "break")):
        if key in tolerance:
            shares = tolerance[key]
            words.append(f"{word} {percents(*shares.values.ravel())}{scope(shares)}")
    return ", ".join(words)

"""The window of a value in which a device meets all requirements, and the best place in it."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..axes import COORDINATES
from ..device import batch
from ..quantities import QUANTITIES
from ..study import Study
from ..tolerances.dataset import tolerances_of
from ..tolerances.samples import Tolerances
from .search import thresholds_at

POINTS, SECTIONS, ROUNDS = 33, 8, 3
"""Values that are tried first; into so many parts each interval is cut, so often."""
PLACES, SAMPLES = 9, 256
"""Values in a window, and devices as made at each, of which the yield is found."""


class Edge(NamedTuple):
    """Where a requirement begins or ends to be met, with what its threshold leaves open."""

    value: float
    error: float
    name: str


def cost_of(requirements: Sequence[Mapping], tolerances: Tolerances | None) -> str:
    """How many thresholds are to be found, in words."""
    told = f"{POINTS * len(requirements)} thresholds, {ROUNDS * (SECTIONS + 1)} for each end"
    if tolerances:
        told += f", {PLACES * min(tolerances.samples, SAMPLES) * (len(requirements) + 1)} devices"
    return told


def window_of(
    study: Study,
    value: str,
    C: float,
    between: tuple[float, float],
    requirements: Sequence[Mapping],
    tolerances: Tolerances | None = None,
) -> xr.Dataset:
    """Find the windows of a value in which a study's device meets all requirements.

    C: uN us/um; between: where to look, internal units
    requirements: name, shocks (of one shape and direction), N, f0 (Hz) and snaps of each
    tolerances: what scatters; then the yield is found within the windows, too
    Variables over `window`: low and high, with low_error and high_error, and low_from, high_from,
    the requirement that ends it there, "between" for an end of the range; over `place`, with
    tolerances: the value and its `yield`, with bounds at 95 %, the attribute best being the value
    of the largest; over `requirement` and the values `tried`: whether it is `met`, up to the first
    that leaves none.
    Warns where no window is, by which requirements; the attribute comment says the same.
    """
    grid = np.linspace(*between, POINTS)
    met, scans, edges = np.ones(POINTS, bool), {}, []
    for asked in requirements:
        scans[asked["name"]], N_first, _ = _teller(study, value, C, asked)(grid)
        met &= scans[asked["name"]]
        if not met.any():
            break
    for asked in requirements if met.any() else ():
        own = scans[asked["name"]]
        ends = [k for k in _changes(met) if own[k] != own[k + 1]]
        meets = _teller(study, value, C, asked)
        edges += [_edge(meets, grid[k : k + 2], asked["name"]) for k in ends]
    windows = _windows(sorted(edges), between, grid[met])
    names = "low", "high"
    ends = {key: [one[i] for one in windows] for i, key in enumerate(names)}
    data = {
        key: ("window", [edge.value for edge in ends[key]], COORDINATES[value]) for key in names
    }
    for key in names:
        data[f"{key}_error"] = ("window", [edge.error for edge in ends[key]], COORDINATES[value])
        data[f"{key}_from"] = ("window", [edge.name for edge in ends[key]])
    data["met"] = (("requirement", "tried"), list(scans.values()))
    tried = ("tried", grid, COORDINATES[value])
    found = xr.Dataset(data, {"requirement": list(scans), "tried": tried})
    if not windows:
        found.attrs["comment"] = _why_none(value, grid, scans, asked, N_first)
        warnings.warn(found.attrs["comment"], stacklevel=3)
    if tolerances and windows:
        found = found.merge(_yields(study, value, C, windows, requirements, tolerances))
        found.attrs["best"] = float(found[value][_middle_of_best(found["yield"].values)])
    return found


def _why_none(value, grid, scans, last, N_first):
    """Which requirements leave no value: the last of those scanned, alone or with those before."""
    unit = QUANTITIES[value].unit
    told = f"{value}: none from {grid[0]:g} to {grid[-1]:g} {unit} meets all requirements"
    if not scans[last["name"]].any():
        seen = N_first[np.isfinite(N_first)]
        runs = f"run from {seen.min():.4g} to {seen.max():.4g}" if seen.size else "are none"
        must = "trip" if last["snaps"] else "not trip"
        asked = f"it must {must} at {last['N']:g}"
        return f"{told}; {last['name']} fails at each: {asked}, thresholds {runs}"
    each = [
        f"{name} is met from {grid[own].min():.4g} to {grid[own].max():.4g}"
        for name, own in scans.items()
    ]
    return f"{told}, as these contradict: {', '.join(each)}"


def _teller(study: Study, value: str, C: float, asked: Mapping) -> Callable:
    """A function of values, (n,): whether the requirement is met, the threshold, and its error."""
    one = replace(study, shocks=asked["shocks"])

    def meets(tried):
        N_first, error, there = thresholds_at(one, {value: tried}, asked["f0"], C)
        return ((N_first <= asked["N"]) == asked["snaps"]) & there, N_first, error

    return meets


def _changes(met):
    return np.flatnonzero(met[1:] != met[:-1])


def _edge(meets: Callable, ends: np.ndarray, name: str) -> Edge:
    """Where a requirement that is met at one of two values begins or ends to be."""
    for _ in range(ROUNDS):
        tried = np.linspace(*ends, SECTIONS + 1)
        met, N_first, error = meets(tried)
        k = _changes(met)[0]
        ends = tried[k : k + 2]
    width = ends[1] - ends[0]
    rise = abs(N_first[k + 1] - N_first[k])
    # At an edge beyond which nothing snaps the bar of a threshold says nothing.
    left_open = np.nanmax(error[k : k + 2]) / rise * width if rise > 0 else 0.0
    return Edge(float(ends.mean()), float(width / 2 + left_open), name)


def _windows(edges, between, met):
    """Pairs of edges between which all is met, as seen at some value there."""
    low, high = (Edge(float(end), 0.0, "between") for end in between)
    places = [low, *edges, high]
    pairs = pairwise(places)
    return [(a, b) for a, b in pairs if ((met >= a.value) & (met <= b.value)).any()]


def _yields(study, value, C, windows, requirements, tolerances):
    """Share of devices as made that meet all, at places within the windows."""
    samples = min(tolerances.samples, SAMPLES)
    asked = tolerances._replace(samples=samples, index_samples=2)
    f0 = [requirements[0]["f0"]]
    places = np.concatenate(
        [np.linspace(low.value, high.value, PLACES + 2)[1:-1] for low, high in windows]
    )
    found = []
    for place in places:
        device = batch([study.device]).vary({value: np.array([place])}).pick(0)
        made = tolerances_of(
            replace(study, device=device), {"C": [C], "f0": f0}, asked, requirements
        )
        found.append(made[["yield", "yield_bound"]].squeeze("C", drop=True))
    return xr.concat(found, "place").assign({value: ("place", places, COORDINATES[value])})


def _middle_of_best(share):
    """Place of the largest, the middle one of several."""
    best = np.flatnonzero(share == share.max())
    return best[best.size // 2]

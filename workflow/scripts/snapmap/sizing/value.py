"""Which value of a device puts its threshold where it is wanted."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..axes import COORDINATES, coordinates, points_of
from ..device import SIGNED, VALUES, Device
from ..io.counting import counting
from ..quantities import QUANTITIES
from ..solver.cells import check_cells
from ..study import study_of
from ..tolerances.samples import Tolerances
from .search import thresholds_at
from .window import window_of, with_shocks

POINTS, SECTIONS, ROUNDS = 17, 8, 3
"""Values that are tried first; into so many parts each interval is cut, so often."""


class Design(NamedTuple):
    """A value for which the threshold is the one asked for.

    value, error: internal units; error: what the error bar of the threshold leaves open
    """

    value: float
    error: float


def design(
    device: Device,
    value: str,
    N: float | None = None,
    f0: float | None = None,
    C: float | None = None,
    between: tuple[float, float] | None = None,
    model: str | Mapping = "auto",
    **options,
) -> Design | xr.Dataset:
    """Find the value of a device, by its name, for which N (multiples of g) is its threshold.

    Or, with requirements in place of N and f0, the window of the value in which all are met, and
    with scatters the yield in it, as `sizing.window.window_of` returns them.
    f0: Hz; C: uN us/um; between: where to look, internal units
    requirements: mappings of name, N, f0 (Hz) and snaps, with pulse and direction, or shocks
    scatters: of the value and others, as `tolerance` takes them, with samples, seed and together
    model: name, or as a mapping the whole of the config's model section
    options: as in `study.study_of`: horizon (us), energy_tolerance, threads, pulse, direction,
        options of the model; and one further value of the device with its values, along which the
        answer is a line: a dataset of value and error, NaN where there is none
    Warns where several values are right, and returns the lowest. Raises ValueError, one line, where
    none is, or for a value that cannot be.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> asked = {"N": 1100, "f0": 1500, "C": 25, "model": "cosines", "horizon": 0}
    >>> found = snapmap.design(device, "thickness", between=(2.0, 2.2), **asked)
    >>> round(found.value, 1)
    2.1
    """
    options = dict(options)
    required = [with_shocks(one) for one in options.pop("requirements", ())]
    given = {key: options.pop(key) for key in Tolerances._fields if key in options}
    study, along = study_of(device, model, options)
    if required:
        _check_window(study, value, C, between, required, along)
        asked = Tolerances(**given) if given else None
        with counting("design"):
            return window_of(study, value, C, between, required, asked)
    _check(study, value, N, f0, C, between, along)
    key, values = next(iter(along.items()), (value, 0.0))
    values = points_of(key, values)

    def above(tried, place):
        """How far above N thresholds are, with their errors, of values at places on the line."""
        asked = {key: values[place], value: tried}
        N_first, error, _ = thresholds_at(study, asked, f0, C)
        return N_first - N, error

    with counting("design"):
        found = _solve(above, between, values.size)
    return _line(value, key, values, N, found) if along else _single(value, N, between, found)


class _Solutions(NamedTuple):
    """Values found, (solutions,), each at a place on the line; and the thresholds seen, less N."""

    place: np.ndarray
    value: np.ndarray
    error: np.ndarray
    seen: np.ndarray


def _solve(above, between, places):
    """Find where thresholds cross zero: on a coarse scan, then in ever finer sections."""
    grid = np.linspace(*between, POINTS)
    seen, _ = above(np.tile(grid, places), np.repeat(np.arange(places), POINTS))
    seen = seen.reshape(places, POINTS)
    known = np.isfinite(seen[:, 1:]) & np.isfinite(seen[:, :-1])
    place, k = np.nonzero(((seen[:, 1:] < 0) != (seen[:, :-1] < 0)) & known)
    low, high = grid[k], grid[k + 1]
    slope = (seen[place, k + 1] - seen[place, k]) / (high - low)
    row = np.arange(place.size)
    for _ in range(ROUNDS if place.size else 0):
        tried = np.linspace(low, high, SECTIONS + 1, axis=1)
        ends, error = above(tried.ravel(), np.repeat(place, SECTIONS + 1))
        ends, error = ends.reshape(tried.shape), error.reshape(tried.shape)
        k = np.argmax((ends[:, 1:] < 0) != (ends[:, :1] < 0), axis=1)
        low, high = tried[row, k], tried[row, k + 1]
    if not place.size:
        return _Solutions(place, low, low, seen)
    below, beyond = ends[row, k], ends[row, k + 1]
    value = low - below * (high - low) / (beyond - below)
    open_by = np.maximum(error[row, k], error[row, k + 1]) + abs(beyond - below) / 2
    return _Solutions(place, value, open_by / abs(slope), seen)


def _single(value, N, between, found):
    unit = QUANTITIES[value].unit
    ends = f"from {between[0]:g} to {between[1]:g} {unit}"
    if not found.value.size:
        known = found.seen[np.isfinite(found.seen)] + N
        least = (
            f"it runs from {known.min():.5g} to {known.max():.5g}" if known.size else "none has one"
        )
        raise ValueError(f"{value}: no value {ends} has its threshold at N = {N:g}; {least}")
    first, *others = found.value.tolist()
    if others:
        several = ", ".join(f"{one:.5g}" for one in (first, *others))
        warnings.warn(
            f"{value}: thresholds {ends} are not monotone; at {several} {unit} they are {N:g}",
            stacklevel=3,
        )
    return Design(first, float(found.error[0]))


def _line(value, key, values, N, found):
    """The lowest value at each place, with the number of all."""
    lowest, error = np.full((2, values.size), np.nan)
    for i in range(values.size):
        mine = np.flatnonzero(found.place == i)
        if mine.size:
            lowest[i], error[i] = found.value[mine[0]], found.error[mine[0]]
    count = np.bincount(found.place, minlength=values.size)
    if (count > 1).any():
        where = ", ".join(f"{one:.5g}" for one in values[count > 1])
        place = f"{key} = {where} {QUANTITIES[key].unit}"
        warnings.warn(f"{value}: not the only one at {place}; the lowest is told", stacklevel=3)
    name = COORDINATES[value]["long_name"]
    data = {
        value: (key, lowest, COORDINATES[value] | {"comment": f"where the threshold is {N:g} g"}),
        "error": (key, error, COORDINATES[value] | {"long_name": f"error of the {name}"}),
        "solutions": (key, count, {"long_name": "number of values found", "units": "1"}),
    }
    return xr.Dataset(data, coordinates({key: values}))


def _check_window(study, value, C, between, required, along):
    if along:
        raise ValueError(f"{next(iter(along))}: is no option beside requirements; vary the device")
    for one in required:
        missing = [key for key in ("name", "N", "f0", "snaps") if key not in one]
        if missing:
            raise ValueError(f"requirements: {missing[0]} is missing in {one.get('name', 'one')}")
        _check(replace(study, shocks=one["shocks"]), value, one["N"], one["f0"], C, between, along)


def _check(study, value, N, f0, C, between, along):
    if not isinstance(study.device, Device):
        raise ValueError(f"device: {study.device!r} is no device; `snapmap.load_device` reads one")
    if value not in VALUES:
        raise ValueError(f"{value}: no value of a device; these are {', '.join(VALUES)}")
    check_cells(N=N, f0=f0, C=C)
    if len(study.settings.pulses) > 1:
        raise ValueError("pulse: several; give one shape and one direction")
    if not N > 0:
        raise ValueError(f"N: {N:g} is not above 0")
    if between is None:
        raise ValueError("between: missing; write the two values between which to look")
    low, high = between
    least = -np.inf if value in SIGNED else 0.0
    if not least <= low < high < np.inf:
        raise ValueError(f"between: {low:g}, {high:g} are not two ascending values from {least:g}")
    if value in along or len(along) > 1:
        raise ValueError(f"{', '.join(along)}: give one value of the device along which to look")

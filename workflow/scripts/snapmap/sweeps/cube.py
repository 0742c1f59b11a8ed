"""The cube as an xarray dataset: what it looks like, built here."""

import json
import math
from collections import Counter
from collections.abc import Mapping
from typing import Unpack

import numpy as np
import xarray as xr

from ..device.argument import Flag
from ..solver.adaptive import TOLERANCE, choose_model
from ..solver.options import AutoOptions
from ..solver.outcome import ABSENT, OUTCOMES, count, ended_elsewhere, shares
from ..study import arguments
from ..study.axes import NAMES
from ..study.study import study_of
from ..study.variables import dress, flags, variables
from .grid import follow_grid

LABEL_DISTANCE = 0.01
"""Relative, from a well-posed threshold: so far a label of three cosines, the handout's elements
or finer may be wrong, in the steps that labels take: docs/accuracy.md."""
OVER_TOLERANCE = 2.0
"""The same of `auto`, over its tolerance, if that is not below the default."""
ELSEWHERE, NEAR_CHANGE = "cells_ended_elsewhere", "labels_near_change"

SHOWN_CELLS = 40_000
"""A larger cube is thinned for the page, and for the largest stress."""
MOST_CELLS = 10**8
"""Of one call; those of a config go to files, slab by slab."""


class SweepOptions(arguments.ThresholdOptions, AutoOptions, arguments.AxisOptions, total=False):
    """Options of `sweep`."""

    until: arguments.Until
    repeat: Flag


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth value of the longest axes, so that no more than SHOWN_CELLS cells are left."""
    strides = dict.fromkeys(reversed(cube.outcome.dims), 1)

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while math.prod(map(left, strides)) > SHOWN_CELLS:
        # Where C is short, as it is, only f0 and N are thinned.
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def sweep(
    device: arguments.Devices,
    N: arguments.Amplitudes,
    f0: arguments.Frequencies | None,
    C: arguments.Dampers,
    model: arguments.Model = "auto",
    **options: Unpack[SweepOptions],
) -> xr.Dataset:
    """Simulate every cell of a grid and return the cube.

    options: horizon, energy_tolerance, threads, start, until, repeat, pulse, direction, skip,
        device axes, model options

    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = {"model": "cosines", "until": "snap", "thickness": [1.9, 2.0]}
    >>> cube = snapmap.sweep(device, [800, 1100], [1500], [25], **study)
    >>> cube.t_snap.notnull().squeeze().values.tolist()
    [[False, True], [False, True]]
    """
    observers = options.pop("observers", ())
    study, axes = study_of(device, model, options, C=C, f0=f0, N=N)
    cells = math.prod(map(np.size, axes.values()))
    if cells > MOST_CELLS:
        raise ValueError(
            f"N: {cells:.3g} cells with f0, C and all axes, more than {MOST_CELLS:.0e}; write "
            "fewer, or a config"
        )
    grid = study.set_out(axes)
    built = choose_model(grid.device, study.model, study.settings.start)
    values = follow_grid(built, grid, study.settings, observers)
    return with_summary(as_cube(grid.axes, values, study.document()))


def as_cube(axes: Mapping[str, np.ndarray], values: Mapping, document: Mapping) -> xr.Dataset:
    """Make a cube of axes and the values of each variable, in their shape."""
    data = {key: (tuple(axes), values[key]) for key in variables("cube") if key in values}
    data["t_snap"] = *data["t_snap"], {"label_distance": label_distance(document.get("model", {}))}
    return dress("cube", xr.Dataset(data, axes), document)


def require_cube(cube: xr.Dataset, name: str = "cube") -> xr.DataArray:
    """Return the codes of the outcomes of a cube; ValueError, one line, for what is none any more.

    name: by which the line names it
    """
    codes = cube.get("outcome_code", cube.get("outcome"))
    if codes is None or codes.dtype.kind not in "iuf":
        raise ValueError(f"{name}: is not a cube, as it has no codes of outcomes")
    if missing := {"long_name", "flag_meanings"} - codes.attrs.keys():
        raise ValueError(f"{name}: {codes.name} has lost its attribute {min(missing)}; keep them")
    for key in (key for key in codes.dims if key not in NAMES):
        if cube[key].dtype.kind not in "iuf" or cube[key].isnull().any():
            raise ValueError(f"{name}: {key} is an axis of numbers, but has other values")
    try:
        is_config = isinstance(json.loads(cube.attrs.get("config", "{}")), dict)
    except (TypeError, ValueError):
        is_config = False
    if not is_config:
        raise ValueError(f"{name}: its attribute config is not JSON; keep it as it was, or drop it")
    return codes


def outcome_names(codes: np.ndarray, name: str = "cube") -> np.ndarray:
    """Put a name for each code of an outcome; ValueError, one line, for a code of none."""
    if wrong := sorted({*np.unique(codes).tolist()} - {*range(len(OUTCOMES))}):
        last = len(OUTCOMES) - 1
        raise ValueError(f"{name}: {wrong[0]} is not a code of an outcome; codes are 0 to {last}")
    return np.array(OUTCOMES)[codes.astype(int)]


def label_distance(model: Mapping) -> float:
    """Tell how far from a well-posed threshold a label of a model can be wrong, relative."""
    if model.get("name") != "auto":
        return LABEL_DISTANCE
    return OVER_TOLERANCE * max(model.get("tolerance", TOLERANCE), TOLERANCE)


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add numbers of cells as attributes, and the shares of `outcome.shares`.

    Cells are counted of each outcome, where another step ended elsewhere, and with labels near a
    change.
    """
    numbers = sum((Counter(count(block)) for block in _blocks(cube.outcome)), Counter())
    counts = {name: numbers[name] for name in OUTCOMES if numbers[name]}
    if counts.keys() & OUTCOMES[ABSENT:]:
        cube.outcome.attrs.update(flags(OUTCOMES))
    named = {f"cells_{name}": number for name, number in counts.items()}
    if "well_reproduced" in cube:
        apart = ended_elsewhere(cube.well_reproduced, cube.well_share)
        named[ELSEWHERE] = sum(int(block.sum()) for block in _blocks(apart))
    named[NEAR_CHANGE] = round(sum(map(_near_change(cube), _blocks(cube.t_snap))))
    return cube.assign_attrs(named | shares(counts))


def _near_change(cube):
    """Make a function of a block of t_snap: how many cells to expect within the label distance.

    The change of label is taken to lie anywhere between two N.
    """
    order, distance = np.argsort(cube.N.values), cube.t_snap.attrs["label_distance"]
    N = cube.N.values[order]

    def expected(t_snap):
        snapped = np.isfinite(t_snap[..., order])
        *_, k = np.nonzero(snapped[..., 1:] != snapped[..., :-1])
        return float(np.sum(2 * distance * N[k] / (N[k + 1] - N[k])))

    return expected


def _blocks(variable):
    """Take the values of a variable by blocks, as a lazy cube may be larger than memory."""
    if variable.chunks is None:
        return [variable.values]
    return (block.compute(scheduler="synchronous") for block in variable.data.blocks.ravel())


def summary(cube: xr.Dataset) -> str:
    """Write in one line what `with_summary` added: how many cells, how sure, of which outcomes."""
    counts = {name: cube.attrs.get(f"cells_{name}", 0) for name in OUTCOMES}
    # Never more than it is: all but one of a thousand are 99.9 %.
    facts = [f"{math.floor(1000 * cube.attrs['share_proven']) / 10:g} % proven"]
    if ELSEWHERE in cube.attrs:
        facts.append(f"{cube.attrs[ELSEWHERE]} ended elsewhere with another step")
    if near := cube.attrs[NEAR_CHANGE]:
        distance = 100 * cube.t_snap.attrs["label_distance"]
        facts.append(f"about {near} labels may be wrong, within {distance:g} % of a threshold")
    facts += [f"{number} {name}" for name, number in counts.items() if number or name == "failed"]
    return f"{sum(counts.values())} cells: {', '.join(facts)}"

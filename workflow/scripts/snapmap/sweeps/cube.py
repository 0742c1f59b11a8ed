"""The cube as an xarray dataset: what it looks like, built here."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..axes import coordinates
from ..device import Device
from ..io.counting import counting
from ..io.variables import flags, headed, variables
from ..solver.adaptive import choose_model
from ..solver.outcome import ABSENT, OUTCOMES, count, ended_elsewhere, shares
from ..study import FOLLOWED, study_of
from .grid import follow_grid

LABEL_DISTANCE = 0.01
"""Relative, from a well-posed threshold: so far a label of three cosines, the handout's elements
or finer may be wrong, in the steps that labels take: docs/accuracy.md."""
VARIABLES = variables("cube")
VARIABLES["outcome"] |= flags(OUTCOMES[:ABSENT])
VARIABLES["t_snap"]["label_distance"] = LABEL_DISTANCE

ELSEWHERE = "cells_ended_elsewhere"


def sweep(
    device: Device | Mapping[str, Device],
    N: Sequence[float],
    f0: Sequence[float] | None,
    C: Sequence[float],
    model: str | Mapping = "auto",
    **options,
) -> xr.Dataset:
    """Simulate every cell of a grid and return it as in cube.nc.

    device: one, or several by name, which then are an axis
    N: multiples of g; f0: Hz, above 0, or None for a recorded shock's own; C: uN us/um, from 0
    model: name, or as a mapping the whole of the config's model section
    options: as in `study.study_of`: horizon (us), until, repeat, energy_tolerance, threads, as in
        `Settings`; pulse; direction; skip: whether a device without a second stable shape is marked
        `absent`, not refused; options of the model; and values of the device by their names, in
        internal units, as axes in front of C, f0 and N
    By default only settled cells are repeated.
    Raises ValueError, one line, for a value that cannot be.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> asked = {"model": "cosines", "until": "snap", "thickness": [1.9, 2.0]}
    >>> cube = snapmap.sweep(device, [800, 1100], [1500], [25], **asked)
    >>> cube.t_snap.notnull().squeeze().values.tolist()
    [[False, True], [False, True]]
    """
    repeat = options.pop("repeat", None)
    options["repeat"] = options.get("until", "settled") == "settled" if repeat is None else repeat
    study, varied = study_of(device, model, options, (*FOLLOWED, "until", "repeat"))
    f0 = [study.shocks.own_frequency()] if f0 is None else f0
    grid = study.set_out({**varied, "C": C, "f0": f0, "N": N})
    with counting("sweep"):
        variables = follow_grid(choose_model(grid.device, study.model), grid, study.settings)
    return with_summary(dress(grid.axes, variables, study.document()))


def dress(axes: Mapping[str, np.ndarray], variables: Mapping, document: Mapping) -> xr.Dataset:
    """Give axes and variables, in their shape, CF attributes, and the whole its provenance."""
    return xr.Dataset(
        {
            key: (tuple(axes), variables[key], attributes)
            for key, attributes in VARIABLES.items()
            if key in variables
        },
        coordinates(axes),
    ).assign_attrs(
        **headed("cube", document),
    )


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add numbers of cells as attributes, and the shares of `outcome.shares`.

    Of each outcome, and of those that ended elsewhere with another step.
    """
    found = [count(block) for block in _blocks(cube.outcome)]
    counts = {name: sum(block.get(name, 0) for block in found) for name in OUTCOMES}
    counts = {name: number for name, number in counts.items() if number}
    if "absent" in counts:
        cube.outcome.attrs.update(flags(OUTCOMES))
    named = {f"cells_{name}": number for name, number in counts.items()}
    if "well_reproduced" in cube:
        apart = ended_elsewhere(cube.well_reproduced, cube.well_share)
        named[ELSEWHERE] = sum(int(block.sum()) for block in _blocks(apart))
    return cube.assign_attrs(named | shares(counts))


def _blocks(variable):
    """The values of a variable, a block at a time, as a lazy cube may be larger than memory."""
    if variable.chunks is None:
        yield variable.values
        return
    for block in variable.data.blocks.ravel():
        yield block.compute(scheduler="synchronous")


def summary(cube: xr.Dataset) -> str:
    """One line of what `with_summary` added: how many cells, how sure, of which kinds."""
    counts = {name: cube.attrs.get(f"cells_{name}", 0) for name in OUTCOMES}
    told = [f"{_percent(cube.attrs['share_proven'])} proven"]
    if ELSEWHERE in cube.attrs:
        told.append(f"{cube.attrs[ELSEWHERE]} ended elsewhere with another step")
    told += [f"{number} {name}" for name, number in counts.items() if number or name == "failed"]
    return f"{sum(counts.values())} cells: {', '.join(told)}"


def _percent(share):
    """A share in text, never more than it is: all but one of a thousand are 99.9 %."""
    return f"{math.floor(1000 * share) / 10:g} %"

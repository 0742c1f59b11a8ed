"""The cube as an xarray dataset: what it looks like, built here."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..axes import coordinates
from ..device import Device
from ..io.counting import counting
from ..io.provenance import provenance
from ..solver.adaptive import choose_model
from ..solver.outcome import ABSENT, OUTCOMES, count, ended_elsewhere, shares
from ..study import FOLLOWED, frequencies, study_of
from .grid import follow_grid

LABEL_DISTANCE = 0.01
"""Relative, from a well-posed threshold: so far a label of three cosines, the handout's elements
or finer may be wrong, in the steps that labels take: docs/accuracy.md."""
VARIABLES = {
    "outcome": {
        "long_name": "outcome of the cell",
        "flag_values": np.arange(ABSENT, dtype=np.int8),
        "flag_meanings": " ".join(OUTCOMES[:ABSENT]),
    },
    "t_snap": {
        "long_name": "first arrival of the midpoint at the second equilibrium",
        "units": "us",
        "comment": "counted from the start of the pulse; NaN: not within the horizon",
        "label_distance": LABEL_DISTANCE,
    },
    "blow": {
        "long_name": "blow of the train at which it snaps, the first is 1",
        "units": "1",
        "comment": "0: not within the horizon",
    },
    "t_settled": {
        "long_name": "time at which the beam was proven to stay in its well for ever",
        "units": "us",
        "comment": "counted from the start of the pulse; NaN: not proven within the horizon",
    },
    "well": {
        "long_name": "side of the saddle on which the beam is at the end of its run",
        "flag_values": np.arange(3, dtype=np.int8),
        "flag_meanings": "unknown first second",
    },
    "well_share": {
        "long_name": "share of the mass's last swing during which the beam was on that side",
        "units": "1",
        "comment": "1 where that side is proven; NaN where it is unknown",
    },
    "energy_error": {
        "long_name": "residual of the energy ledger over the gross work of the pulse",
        "units": "1",
        "comment": "of the energy that the scheme conserves",
    },
    "pulse_work": {
        "long_name": "work of the pulse on mass and beam",
        "units": "pJ",
        "comment": "of the whole pulse; NaN where the run ended before it or failed",
    },
    "halvings": {
        "long_name": "how often the time step was halved until the energy ledger closed",
        "units": "1",
    },
    "level": {
        "long_name": "level of the model that decided the cell",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "base top",
    },
    "agreed": {
        "long_name": "whether no two levels that decided the cell disagree on whether it snaps",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "disputed agreed",
    },
    "reproduced": {
        "long_name": "whether a run with another time step had the same outcome",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "not_reproduced reproduced",
    },
    "well_reproduced": {
        "long_name": "whether a run with another time step ended on the same side of the saddle",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "not_reproduced reproduced",
    },
    "work_error": {
        "long_name": "indicator of the error of pulse_work: difference with another time step",
        "units": "1",
        "comment": "over the larger of both works; no bound: the truth was farther off in 13 of 23 "
        "cells, more than ten times as far in one; NaN where one of them is not known",
    },
    "t_snap_error": {
        "long_name": "indicator of the error of t_snap: difference with another time step",
        "units": "us",
        "comment": "no bound, as that of work_error; NaN where one of both runs did not snap",
    },
}

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
    f0 = frequencies(f0, study.shocks)
    grid = study.set_out({**varied, "C": C, "f0": f0, "N": N})
    with counting("sweep"):
        variables = follow_grid(choose_model(grid.device, study.model), grid, study.settings)
    return with_summary(dress(grid.axes, variables, study.document()))


def dress(axes: Mapping[str, np.ndarray], variables: Mapping, document: Mapping) -> xr.Dataset:
    """Give axes and variables, in their shape, CF attributes, and the whole its provenance."""
    return xr.Dataset(
        {key: (tuple(axes), variables[key], VARIABLES[key]) for key in variables},
        coordinates(axes),
    ).assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title="Snap-through of a bistable beam under shock",
        summary="Outcome of each cell of a grid over damping, frequency and amplitude of the shock",
        **provenance(document),
    )


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add numbers of cells as attributes, and the shares of `outcome.shares`.

    Of each outcome, and of those that ended elsewhere with another step.
    """
    found = [count(block) for block in _blocks(cube.outcome)]
    counts = {name: sum(block.get(name, 0) for block in found) for name in OUTCOMES}
    counts = {name: number for name, number in counts.items() if number}
    if "absent" in counts:
        flags = {"flag_values": np.arange(len(OUTCOMES), dtype=np.int8)}
        cube.outcome.attrs.update(flags, flag_meanings=" ".join(OUTCOMES))
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

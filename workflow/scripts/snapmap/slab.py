"""A slab of the grid: the work of one job. Cut, named by what it holds, written and checked."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import netCDF4
import numpy as np

from .device import Device
from .grid import follow_grid
from .ladder import RUNGS, choose_model
from .models import Model, build_model, check_options
from .outcome import count
from .protocol import Protocol

if TYPE_CHECKING:  # a job has no use for the config and what it imports
    from .config import Study

JOB_SECONDS = 20
"""Aim for the run time of one slab; short enough to show progress, long against a job's start."""


class Slab(NamedTuple):
    """Values on the axes of one slab: C in uN us/um, f0 in Hz, N in multiples of g."""

    C: tuple[float, ...]
    f0: tuple[float, ...]
    N: tuple[float, ...]


def cut(study: "Study") -> list[list[Slab]]:
    """Cut the grid into one row of slabs for each C, along f0, each row in ascending order."""
    model = _cheapest(study)
    cost = _seconds(model, 1e6 / study.f0 + study.protocol.horizon) * study.N.size
    pieces = int(np.ceil(cost.sum() / JOB_SECONDS))
    ends = np.searchsorted(np.cumsum(cost), cost.sum() * np.arange(1, pieces) / pieces) + 1
    chunks = [chunk for chunk in np.split(study.f0, np.unique(ends)) if chunk.size]
    N = tuple(study.N.tolist())
    return [[Slab((float(C),), tuple(f0.tolist()), N) for f0 in chunks] for C in study.C]


def _cheapest(study):
    """The model that follows every cell; building it also checks the model's options."""
    if study.model["name"] != "auto":
        return build_model(study.device, **study.model)
    options = {key: value for key, value in study.model.items() if key != "name"}
    check_options(study.device, "auto", options)
    return build_model(study.device, "cosines", modes=RUNGS[0])


def _seconds(model: Model, duration):
    """Expected time of one cell followed for `duration` us; only for sharing out work."""
    modes = model.modal.load.size
    nanoseconds = 80 if model.name == "reference" else 1 + modes**2 / 20
    return duration / model.dt * nanoseconds * 1e-9


def slab_name(study: "Study", slab: Slab) -> str:
    """Name a slab by a hash of all that its numbers depend on but the code."""
    return _name(study.device, study.model, slab, study.protocol)


def _name(device, model, slab, protocol):
    what = [asdict(device), model, slab._asdict(), protocol._asdict()]
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:16]


def write_slab(
    device: Device, model: Mapping, slab: Slab, protocol: Protocol, path: str | Path, threads: int
) -> dict[str, int]:
    """Follow the cells of one slab and write it to `path`; returns how many had which outcome.

    model: name and options
    """
    variables = follow_grid(device, choose_model(device, **model), slab, protocol, threads)
    temporary = f"{path}.part"
    with netCDF4.Dataset(temporary, "w") as file:
        file.slab = _name(device, model, slab, protocol)
        for axis, values in slab._asdict().items():
            file.createDimension(axis, len(values))
            file.createVariable(axis, "f8", (axis,))[:] = values
        for key, values in variables.items():
            file.createVariable(key, values.dtype, slab._fields, compression="zlib")[:] = values
    os.replace(temporary, path)
    return count(variables["outcome"])

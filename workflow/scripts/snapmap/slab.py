"""A slab of the grid: the work of one job, named by what it holds."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import netCDF4
import numpy as np

from .atomic import replacing
from .device import Device
from .grid import follow_grid
from .ladder import choose_model
from .outcome import count
from .protocol import Protocol
from .recall import recall

if TYPE_CHECKING:  # a job has no use for the config and what it imports
    from .config import Study


class Slab(NamedTuple):
    """Values on the axes of one slab: C in uN us/um, f0 in Hz, N in multiples of g."""

    C: tuple[float, ...]
    f0: tuple[float, ...]
    N: tuple[float, ...]


def slab_name(study: "Study", slab: Slab) -> str:
    """Name a slab by two hashes: what its cells have in common but the code, and its f0 and N."""
    return _name(study.device, study.model, slab, study.protocol)


def _name(device, model, slab, protocol):
    common = [asdict(device), model, protocol._asdict(), slab.C]
    return f"{_hash(common)}_{_hash([slab.f0, slab.N])}"


def _hash(what):
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:12]


def write_slab(
    device: Device,
    model: Mapping,
    slab: Slab,
    protocol: Protocol,
    path: str | Path,
    threads: int,
    code: str = "",
) -> dict[str, int]:
    """Follow the cells of one slab and write it to `path`; returns how many had which outcome.

    Cells that other slabs in the same folder hold are taken from there.
    model: name and options
    code: hash of the code on which the numbers depend; slabs made by another are not used
    """
    same_N = model["name"] == "auto"
    variables, known = recall(path, slab.f0, slab.N, code, same_N)
    _follow_unknown(device, model, slab, protocol, threads, variables, known)
    with replacing(path) as temporary, netCDF4.Dataset(temporary, "w") as file:
        file.slab, file.code = _name(device, model, slab, protocol), code
        for axis, values in slab._asdict().items():
            file.createDimension(axis, len(values))
            file.createVariable(axis, "f8", (axis,), fletcher32=True)[:] = values
        for key, values in variables.items():
            kind = {"compression": "zlib", "fletcher32": True}
            file.createVariable(key, values.dtype, slab._fields, **kind)[:] = values
    return count(variables["outcome"])


def _follow_unknown(device, model, slab, protocol, threads, variables, known):
    """Follow what is not known, (f0, N), and set it in the variables: rows alike at a time."""
    f0, N = np.array(slab.f0), np.array(slab.N)
    patterns, pattern_of = np.unique(~known, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        rows, columns = np.flatnonzero(pattern_of == number), np.flatnonzero(pattern)
        if columns.size:
            axes, built = (slab.C, f0[rows], N[columns]), choose_model(device, **model)
            for key, values in follow_grid(device, built, axes, protocol, threads).items():
                whole = variables.setdefault(key, np.empty((1, *known.shape), values.dtype))
                whole[0][np.ix_(rows, columns)] = values[0]

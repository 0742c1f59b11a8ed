"""A slab as a file: its cells followed, or taken from earlier slabs."""

from collections.abc import Mapping
from pathlib import Path

import netCDF4
import numpy as np

from .atomic import replacing
from .device import Device
from .grid import follow_grid
from .ladder import choose_model
from .outcome import count
from .partition import Slab, name_of
from .protocol import Protocol
from .recall import recall


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
        file.slab, file.code = name_of(device, model, slab, protocol), code
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
            for key, values in follow_grid(built, axes, protocol, threads).items():
                whole = variables.setdefault(key, np.empty((1, *known.shape), values.dtype))
                whole[0][np.ix_(rows, columns)] = values[0]

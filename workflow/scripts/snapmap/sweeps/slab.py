"""A slab as a file: its cells followed, or taken from earlier slabs."""

from pathlib import Path

import netCDF4
import numpy as np

from ..axes import NAMES
from ..io.atomic import replacing
from ..solver.adaptive import choose_model
from ..solver.outcome import count
from ..study import Study
from .grid import follow_rows, rows_of
from .partition import Slab, slab_grid, slab_name
from .reuse import recall


def write_slab(study: Study, slab: Slab, path: str | Path, code: str = "") -> dict[str, int]:
    """Follow the cells of one slab and write it to `path`; returns how many had which outcome.

    Cells that other slabs in the same folder hold are taken from there.
    code: hash of the code on which the numbers depend; slabs made by another are not used
    """
    variables, known = recall(path, slab, code, same_N=study.model["name"] == "auto")
    grid = slab_grid(study, slab)
    settings = study.settings._replace(pulses=grid.pulses)
    _follow_unknown(grid, study.model, settings, variables, known)
    with replacing(path) as temporary, netCDF4.Dataset(temporary, "w") as file:
        file.slab, file.code = slab_name(study, slab), code
        for axis, values in slab.items():
            file.createDimension(axis, len(values))
            kind = {"datatype": str} if axis in NAMES else {"datatype": "f8", "fletcher32": True}
            file.createVariable(axis, dimensions=(axis,), **kind)[:] = np.array(values)
        for key, values in variables.items():
            kind = {"compression": "zlib", "fletcher32": True}
            file.createVariable(key, values.dtype, tuple(slab), **kind)[:] = values
    return count(variables["outcome"])


def _follow_unknown(grid, model, settings, variables, known):
    """Follow what is not known, rows with the same gaps at once, and set it in the variables."""
    if known.all():
        return
    built, rows = choose_model(grid.device, model), rows_of(grid)
    patterns, pattern_of = np.unique(
        ~known.reshape(-1, known.shape[-1]), axis=0, return_inverse=True
    )
    for number, pattern in enumerate(patterns):
        some, columns = np.flatnonzero(pattern_of.ravel() == number), np.flatnonzero(pattern)
        if columns.size:
            found = follow_rows(built, rows.some(some), grid.axes["N"][columns], settings)
            for key, values in found.items():
                whole = variables.setdefault(key, np.empty(known.shape, values.dtype))
                whole.reshape(-1, known.shape[-1])[np.ix_(some, columns)] = values

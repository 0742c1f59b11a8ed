"""Cells that earlier slabs hold: a grid that grows follows only what is new."""

from pathlib import Path

import netCDF4
import numpy as np

from ..axes import shared_points
from .partition import Slab


def recall(
    path: str | Path, slab: Slab, code: str, same_N: bool
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Read from other slabs beside the file `path` what they hold of the cells of a slab.

    slab: its values on each axis, ascending
    code: hash of the code; slabs made by another are left alone
    same_N: whether a cell depends on its neighbours along N, so that only slabs with the same N do
    Returns each variable, in the shape of the slab, and which of its cells are known.
    """
    path, axes = Path(path), {key: np.asarray(values) for key, values in slab.items()}
    known, variables = np.zeros([values.size for values in axes.values()], bool), {}
    for other in sorted(path.parent.glob(f"{path.stem.split('_')[0]}_*.nc")):
        try:
            found, place = _read_common(other, axes, code, same_N)
        except (OSError, RuntimeError, IndexError, AttributeError):
            continue  # a broken file: its cells are followed again, and rule collect names it
        for key, values in found.items():
            variables.setdefault(key, np.empty(known.shape, values.dtype))[place] = values
        known[place] |= bool(found)
    return variables, known


def _read_common(other, axes, code, same_N):
    """The variables of another slab where both have cells, and their place in ours."""
    with netCDF4.Dataset(other) as file:
        file.set_auto_maskandscale(False)
        theirs = {key: np.asarray(file[key][:], values.dtype) for key, values in axes.items()}
        place, there = (np.ix_(*side) for side in shared_points(axes, theirs))
        alike = file.slab == other.stem and file.code == code
        alike &= all(index.size for index in place)
        if not alike or (same_N and not np.array_equal(axes["N"], theirs["N"])):
            return {}, place
        keys = set(file.variables) - set(file.dimensions)
        return {key: file[key][:][there] for key in keys}, place

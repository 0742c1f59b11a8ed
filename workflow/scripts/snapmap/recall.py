"""Cells that earlier slabs hold: a grid that grows follows only what is new."""

from collections.abc import Sequence
from pathlib import Path

import netCDF4
import numpy as np


def recall(
    path: str | Path, f0: Sequence[float], N: Sequence[float], code: str, same_N: bool
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Read from the other slabs of one C what they hold of the cells of the slab `path`.

    f0, N: of the slab, ascending; Hz and multiples of g
    code: hash of the code; slabs made by another are left alone
    same_N: whether a cell depends on its neighbours along N, so that only slabs with the same N do
    Returns each variable, (1, f0, N), and which cells of it are known, (f0, N).
    """
    path = Path(path)
    known, variables = np.zeros((len(f0), len(N)), bool), {}
    for other in sorted(path.parent.glob(f"{path.stem.split('_')[0]}_*.nc")):
        try:
            found, place = _read_common(other, f0, N, code, same_N)
        except (OSError, RuntimeError, IndexError, AttributeError):
            continue  # a broken file: its cells are followed again, and rule collect names it
        for key, values in found.items():
            whole = variables.setdefault(key, np.empty((1, *known.shape), values.dtype))
            whole[0][place] = values
        known[place] |= bool(found)
    return variables, known


def _read_common(other, f0, N, code, same_N):
    """The variables of another slab, (f0, N), where both have cells, and their place in ours."""
    with netCDF4.Dataset(other) as file:
        file.set_auto_maskandscale(False)
        rows, columns = _common(f0, file["f0"][:]), _common(N, file["N"][:])
        place, theirs = np.ix_(rows[0], columns[0]), np.ix_(rows[1], columns[1])
        alike = file.slab == other.stem and file.code == code and place[0].size and place[1].size
        if not alike or (same_N and not np.array_equal(N, file["N"][:])):
            return {}, place
        keys = set(file.variables) - set(file.dimensions)
        return {key: file[key][0][theirs] for key in keys}, place


def _common(ours, theirs):
    """Where equal values stand in two arrays."""
    return np.intersect1d(ours, theirs, assume_unique=True, return_indices=True)[1:]

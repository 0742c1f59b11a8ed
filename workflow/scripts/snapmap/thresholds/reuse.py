"""Rows that an earlier search found: a grid that grows has only the new ones to find."""

import numpy as np

from ..io.netcdf import blank


def joined(
    n_rows: int, new: np.ndarray, found: np.ndarray | None, known: np.ndarray | None
) -> np.ndarray:
    """New rows of a variable and known ones; either may be missing, or have fewer islands.

    new: indices of those found, (new,), which take the place of the known, of (n_rows, ...)
    """
    parts = [part for part in (found, known) if part is not None]
    widest = max((part.shape[1:] for part in parts), key=np.prod)
    whole = blank((n_rows, *widest), parts[0].dtype)
    for where, part in ((slice(None), known), (new, found)):
        if part is not None:
            whole[where] = blank(whole[where].shape, whole.dtype)
            whole[(where, *map(slice, part.shape[1:]))] = part
    return whole

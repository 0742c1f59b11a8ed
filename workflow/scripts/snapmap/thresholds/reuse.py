"""Rows that an earlier search found: a grid that grows has only the new ones to find."""

import numpy as np
import xarray as xr

from ..axes import Grid, shared_points


def recall(
    earlier: xr.Dataset | None, grid: Grid, recipe: str
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Take from earlier thresholds what they hold of the rows of a grid.

    earlier: as from `threshold`; nothing is taken of another recipe
    Returns their variables, (rows,) or (rows, islands), with NaN or 0 where a row is not known,
    and which are, (rows,).
    """
    known, dims = np.zeros(grid.shape, bool), tuple(grid.axes)
    if earlier is None or earlier.attrs.get("recipe") != recipe:
        return {}, known.ravel()
    place, there = shared_points(grid.axes, earlier)
    known[np.ix_(*place)] = True
    some, variables = earlier.isel(dict(zip(dims, there, strict=True))), {}
    for key in (key for key in some.data_vars if some[key].dims[: len(dims)] == dims):
        held = some[key].values
        whole = blank(grid.shape + held.shape[len(dims) :], held.dtype)
        whole[np.ix_(*place)] = held
        variables[key] = whole.reshape(known.size, *held.shape[len(dims) :])
    return variables, known.ravel()


def blank(shape: tuple[int, ...], kind: np.dtype) -> np.ndarray:
    """An array in which nothing is known: NaN, or 0 where a kind has none."""
    return np.full(shape, np.nan if kind.kind == "f" else 0, kind)


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

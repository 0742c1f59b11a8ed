"""Slabs joined into one cube: every file checked, every cell accounted for, block by block."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import dask.array
import netCDF4
import numpy as np
import xarray as xr

from ..axes import point_text
from .cube import VARIABLES, dress, with_summary

BLOCK_CELLS = 10**6
"""Cells held in memory at a time, and compressed together in the cube."""
REMEDY = "remove it, and the next run makes it again"


class Place(NamedTuple):
    """A slab's file, and where its values stand on the axes of the grid: index arrays by axis."""

    path: str
    index: dict[str, np.ndarray]


def collect_slabs(
    paths: Sequence[str | Path], axes: Mapping[str, Sequence], document: Mapping
) -> xr.Dataset:
    """Join slabs lazily into one cube, which is read in blocks of at most BLOCK_CELLS.

    paths: files named by the slab they hold
    axes: values on every axis of the whole grid, in order, ascending
    document: what was asked for, kept in the attributes
    Raises ValueError, a line for each fault: files that are missing, broken or another slab's, and
    cells that are in no file; broken data may show only when the cube is computed.
    """
    axes = {key: np.asarray(values) for key, values in axes.items()}
    faults, places = [], []
    for path in paths:
        try:
            places.append(_find_place(path, axes))
        except ValueError as error:
            faults.append(str(error))
    faults += _holes(places, axes)
    if faults:
        raise ValueError("\n".join(faults))
    return with_summary(dress(axes, _variables(places, axes), document))


def _find_place(path, axes):
    with _open_slab(path) as slab:
        index = {key: _index(slab[key][:], whole) for key, whole in axes.items()}
    if any(places is None for places in index.values()):
        raise ValueError(f"{path}: holds cells of another grid; {REMEDY}")
    return Place(str(path), index)


def _index(values, whole):
    """Where values stand on an axis; None if one of them does not."""
    order = np.argsort(whole, kind="stable")
    values = np.asarray(values, whole.dtype)
    places = order[np.minimum(np.searchsorted(whole[order], values), whole.size - 1)]
    return places if (whole[places] == values).all() else None


def _holes(places, axes):
    """A line for each stretch of f0 in which cells are in no slab, or in several."""
    *outer, f0, N = axes
    held = np.zeros([axes[key].size for key in (*outer, f0)], int)
    for place in places:
        held[np.ix_(*(place.index[key] for key in (*outer, f0)))] += place.index[N].size
    for at in np.ndindex(*held.shape[:-1]):
        row = held[at]
        wrong = np.flatnonzero(row != axes[N].size)
        for run in np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1):
            if run.size:
                place = {key: axes[key][i] for key, i in zip(outer, at, strict=True)}
                ends = f"f0 = {axes[f0][run[0]]:.6g} to {axes[f0][run[-1]]:.6g} Hz"
                cells = f"{row[run].sum()} of {run.size * axes[N].size} cells"
                yield f"hole in the grid: {point_text(place)}, {ends}: {cells} are there"


def _variables(places, axes):
    """Every variable of the slabs as a lazy array over the whole grid."""
    with _open_slab(places[0].path) as slab:
        kinds = {key: slab[key].dtype for key in VARIABLES if key in slab.variables}
    sizes, room = [], BLOCK_CELLS
    for values in reversed(axes.values()):
        sizes.insert(0, max(1, min(values.size, room)))
        room //= sizes[0]
    chunks = dask.array.core.normalize_chunks(sizes, [values.size for values in axes.values()])
    # Least and greatest place of each slab on each axis, (slabs, axes).
    ends = np.array([[(i.min(), i.max()) for i in place.index.values()] for place in places])

    def read(key, block_info):
        return _read_block(places, ends, key, kinds[key], block_info[None]["array-location"])

    return {
        key: dask.array.map_blocks(read, key, chunks=chunks, dtype=kind)
        for key, kind in kinds.items()
    }


def _read_block(places, ends, key, kind, location):
    """Read one variable within [first, end) on each axis."""
    first, end = np.array(location).T
    block = np.empty(end - first, kind)
    for number in np.flatnonzero(((ends[..., 0] < end) & (ends[..., 1] >= first)).all(axis=1)):
        index = list(places[number].index.values())
        held = [(i >= a) & (i < b) for i, a, b in zip(index, first, end, strict=True)]
        if not all(one.any() for one in held):
            continue
        target = np.ix_(*(i[one] - a for i, one, a in zip(index, held, first, strict=True)))
        with _open_slab(places[number].path) as slab:
            block[target] = slab[key][tuple(slice(*_ends(one)) for one in held)]
    return block


def _ends(held):
    """First and one past the last of what is held; along an axis both are ascending."""
    places = np.flatnonzero(held)
    return places[0], places[-1] + 1


@contextmanager
def _open_slab(path) -> Iterator[netCDF4.Dataset]:
    """Open a slab; any fault of the file becomes a ValueError of one line that names it."""
    try:
        with netCDF4.Dataset(path) as slab:
            slab.set_auto_maskandscale(False)
            name = getattr(slab, "slab", None)
            if name != Path(path).stem:
                raise ValueError(f"{path}: holds slab {name}, not its own; {REMEDY}")
            yield slab
    except FileNotFoundError:
        raise ValueError(f"{path}: missing; the next run makes it") from None
    except (OSError, RuntimeError, IndexError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"{path}: not a whole slab ({reason}); {REMEDY}") from None

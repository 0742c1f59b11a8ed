"""Slabs joined into one cube: every file checked, every cell accounted for, block by block."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import dask.array
import netCDF4
import numpy as np
import xarray as xr

from .cube import VARIABLES, dress, with_summary
from .grid import AXES

BLOCK_CELLS = 10**6
"""Cells held in memory at a time, and compressed together in the cube."""
REMEDY = "remove it, and the next run makes it again"


class Place(NamedTuple):
    """A slab's file, and where its values stand on the axes of the grid; index arrays."""

    path: str
    C: np.ndarray
    f0: np.ndarray
    N: np.ndarray


def collect_slabs(
    paths: Sequence[str | Path], axes: Sequence[Sequence[float]], document: Mapping
) -> xr.Dataset:
    """Join slabs lazily into one cube, which is read in blocks of one C and BLOCK_CELLS.

    paths: files named by the slab they hold
    axes: ascending values of C (uN us/um), f0 (Hz) and N (multiples of g) of the whole grid
    document: the config, kept in the attributes
    Raises ValueError, a line for each fault: files that are missing, broken or another slab's, and
    cells that are in no file; broken data may show only when the cube is computed.
    """
    axes = [np.asarray(values, float) for values in axes]
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
        index = [_index(slab[axis][:], whole) for axis, whole in zip(AXES, axes, strict=True)]
    if any(places is None for places in index):
        raise ValueError(f"{path}: holds cells of another grid; {REMEDY}")
    return Place(str(path), *index)


def _index(values, whole):
    """Where values stand on an ascending axis; None if one of them does not."""
    places = np.minimum(np.searchsorted(whole, values), whole.size - 1)
    return places if (whole[places] == values).all() else None


def _holes(places, axes):
    """A line for each stretch of f0 of one C in which cells are in no slab, or in several."""
    held = np.zeros([values.size for values in axes[:2]], int)
    for place in places:
        held[np.ix_(place.C, place.f0)] += place.N.size
    for C, row in zip(axes[0], held, strict=True):
        wrong = np.flatnonzero(row != axes[2].size)
        for run in np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1):
            if run.size:
                ends = f"{axes[1][run[0]]:.6g} to {axes[1][run[-1]]:.6g} Hz"
                cells = f"{row[run].sum()} of {run.size * axes[2].size} cells"
                yield f"hole in the grid: C = {C:.6g} uN us/um, f0 = {ends}: {cells} are there"


def _variables(places, axes):
    """Every variable of the slabs as a lazy array over the whole grid."""
    with _open_slab(places[0].path) as slab:
        kinds = {key: slab[key].dtype for key in VARIABLES if key in slab.variables}
    of_C = defaultdict(list)
    for place in places:
        for C in place.C:
            of_C[C].append(place)
    columns = min(axes[2].size, BLOCK_CELLS)
    sizes = (1, min(axes[1].size, BLOCK_CELLS // columns), columns)
    chunks = dask.array.core.normalize_chunks(sizes, [values.size for values in axes])

    def read(key, block_info):
        return _read_block(of_C, key, kinds[key], block_info[None]["array-location"])

    return {
        key: dask.array.map_blocks(read, key, chunks=chunks, dtype=kind)
        for key, kind in kinds.items()
    }


def _read_block(of_C, key, kind, location):
    """Read one variable within [first, end) on each axis; one C."""
    (C, _), rows, columns = location
    block = np.empty((1, rows[1] - rows[0], columns[1] - columns[0]), kind)
    for place in of_C[C]:
        f0, N = slice(*np.searchsorted(place.f0, rows)), slice(*np.searchsorted(place.N, columns))
        if f0.start < f0.stop and N.start < N.stop:
            target = np.ix_(place.f0[f0] - rows[0], place.N[N] - columns[0])
            with _open_slab(place.path) as slab:
                block[0][target] = slab[key][np.searchsorted(place.C, C), f0, N]
    return block


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

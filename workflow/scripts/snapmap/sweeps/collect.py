"""Slabs are checked and joined to a cube, block by block; every cell is accounted for."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from ..files.atomic import is_whole
from ..study.axes import NAMES
from ..values.quantities import ExistingPath
from .cube import as_cube, require_codes, require_cube, with_summary
from .slabs import REMEDY, open_slab

BLOCK_CELLS = 10**6
"""Most cells that are held in memory at a time, and compressed together."""
SLAB_CACHE = 2**20
"""Bytes of each variable that netCDF keeps in memory of an open slab."""


def collect_slabs(
    paths: Sequence[str | Path],
    axes: Mapping[str, Sequence],
    document: Mapping,
    code: str | None = None,
) -> xr.Dataset:
    """Join slabs lazily to one cube, in blocks of at most BLOCK_CELLS.

    paths: of the slabs, whose names are the slabs' own
    axes: values of each axis of the whole grid, in order, ascending
    document: config, which the attributes of the cube repeat
    code: hash of the code that all slabs must be of; by default that of the first
    Raises ValueError, a line for each fault: a file is missing, broken, another slab or of other
    code; a value of an axis is in no slab; or cells are in several.
    """
    slabs = open_slabs(paths, code)
    axes = {key: np.asarray(values) for key, values in axes.items()}
    faults = [
        f"grid: {key} = {value} is in no slab; run again"
        for key, values in axes.items()
        for value in values[~np.isin(values, slabs[key].values)]
    ]
    if not faults and [*slabs.outcome.shape] != [values.size for values in axes.values()]:
        faults = [f"{Path(paths[0]).parent}: has cells of another grid; remove it and run again"]
    if faults:
        raise ValueError("\n".join(faults))
    sizes, room = {}, BLOCK_CELLS
    for key, values in reversed(axes.items()):
        sizes[key] = max(1, min(values.size, room))
        room //= sizes[key]
    # Axes of names keep their order.
    slabs = slabs.sel({key: axes[key] for key in axes if key in NAMES})
    if slabs.chunks:
        slabs = slabs.chunk(sizes)
    variables = {key: slabs[key].data for key in slabs.data_vars}
    return with_summary(as_cube(axes, variables, document))


def open_slabs(paths: Sequence[str | Path], code: str | None = None) -> xr.Dataset:
    """Open slabs as a lazy cube, a block for each; raises ValueError, a line for each fault.

    code: as in `collect_slabs`
    A single small slab is opened without dask, whose start takes longer than the rest.
    """
    faults, cells = [], 0
    for path in paths:
        try:
            with open_slab(path) as slab:
                cells += slab["outcome"].size
                code = slab.code if code is None else code
                if slab.code != code:
                    faults.append(f"{path}: has cells of other code; {REMEDY}")
        except ValueError as error:
            faults.append(str(error))
    if faults:
        raise ValueError("\n".join(faults))
    netCDF4.set_chunk_cache(SLAB_CACHE)
    if len(paths) == 1 and cells <= BLOCK_CELLS:
        return xr.open_dataset(paths[0], engine="netcdf4", decode_cf=False)
    how = {"data_vars": "all", "coords": "minimal", "compat": "override", "join": "exact"}
    how |= {"combine": "by_coords", "combine_attrs": "drop", "decode_cf": False}
    try:
        cube = xr.open_mfdataset(paths, engine="netcdf4", **how)
    except ValueError as error:
        raise ValueError(f"hole in the grid of slabs: {' '.join(str(error).split())}") from None
    if cells != cube.outcome.size:
        raise ValueError(
            f"grid: {cells} cells are in its slabs, not {cube.outcome.size}; remove them"
        )
    return cube


def open_cube(path: ExistingPath) -> xr.Dataset:
    """Open a cube of a study.

    Parameters
    ----------
    path
        A file, or a folder of slabs, which dask reads lazily, a block for each slab.

    Returns
    -------
    Dataset
        The cube, as `sweep` returns it; `words` gives the words of `outcome`.

    Raises
    ------
    ValueError
        One line with the path, for a file that is damaged or no cube.

    Examples
    --------
    >>> snapmap.open_cube("config/config.yaml")
    Traceback (most recent call last):
    ValueError: config/config.yaml: is not a cube; open one such as results/cube.nc
    """
    try:
        if Path(path).is_dir():
            slabs = open_slabs(sorted(Path(path).glob("*.nc")))
            axes = {key: slabs[key].values for key in slabs.outcome.dims}
            cube = as_cube(axes, {key: slabs[key].data for key in slabs.data_vars}, {})
        elif is_whole(path) is False:
            raise ValueError(f"{path}: is damaged; take another copy, or remove it and run again")
        else:
            cube = xr.open_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, AttributeError):
        with suppress(OSError):
            if is_whole(path):
                remedy = "set HDF5_USE_FILE_LOCKING=FALSE, or import snapmap before netCDF4"
                raise ValueError(f"{path}: cannot be locked; {remedy}") from None
        raise ValueError(f"{path}: is not a cube; open one such as results/cube.nc") from None
    codes = require_cube(cube, str(path))
    if codes.chunks is None:
        require_codes(codes.values, str(path))
    return cube

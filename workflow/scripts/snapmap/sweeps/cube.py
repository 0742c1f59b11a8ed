"""The cube: a dataset with the outcome of each cell, also joined from slabs, block by block."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from ..files.atomic import is_whole
from ..solver.adaptive import choose_model
from ..solver.options import TOLERANCE
from ..solver.outcome import ABSENT, OUTCOMES, count, ended_elsewhere
from ..study.arguments import AnyStudy, Axes
from ..study.axes import NAMES, frequencies, rows_of
from ..study.variables import dress, flags, variables
from ..values.quantities import Amplitudes, Dampers, ExistingPath, Frequencies, PulseTimes
from .slabs import REMEDY, Observers, follow_rows, open_slab

LABEL_DISTANCE = 0.01
"""Relative distance from a well-posed threshold within which labels may be wrong, with three
cosines or more, or the handout's elements or finer: docs/accuracy.md."""
OVER_TOLERANCE = 2.0
"""The same distance with `auto`, over its tolerance, or over the default one if that is larger."""
ELSEWHERE, NEAR_CHANGE = "cells_ended_elsewhere", "labels_near_change"

SHOWN_CELLS = 40_000
"""Most cells on the page, and for the largest stress; a larger cube is thinned."""
MOST_CELLS = 10**8
"""Most cells of one call of `sweep`; those of a config go to files, slab by slab."""


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth value of the longest axes, so that at most SHOWN_CELLS cells are left."""
    strides = dict.fromkeys(reversed(cube.outcome.dims), 1)

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while math.prod(map(left, strides)) > SHOWN_CELLS:
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def sweep(
    study: AnyStudy,
    N: Amplitudes,
    f0: Frequencies | None,
    C: Dampers,
    *,
    duration: PulseTimes | None = None,
    axes: Axes | None = None,
    observers: Observers = (),
) -> xr.Dataset:
    """Simulate every cell of a grid.

    Parameters
    ----------
    study
        Devices, model, shocks, and how each cell is followed; or a Device.
    N
        Amplitudes of the shock, multiples of g, each once.
    f0
        Frequencies of the pulse, Hz, each once; None for a recorded shock.
    C
        Dampings of the mass, uN us/um, each once.
    duration
        Durations of the pulse, us, in place of f0.
    axes
        Values of the device, internal units, by name.

    Returns
    -------
    Dataset
        The cube: `outcome`, `t_snap` and further variables over (..., C, f0, N), as the page of the
        functions lists them.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, for a device without a second stable shape.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", until="snap")
    >>> cube = snapmap.sweep(study, [800, 1100], 1500, 25, axes={"thickness": [1.9, 2.0]})
    >>> cube.t_snap.notnull().squeeze().values.tolist()
    [[False, True], [False, True]]
    """
    axes = {**(axes or {}), "C": C, "f0": frequencies(f0, duration), "N": N}
    cells = math.prod(np.size(values) for values in axes.values() if values is not None)
    if cells > MOST_CELLS:
        raise ValueError(
            f"N: {cells:.3g} cells with f0, C and all axes, more than {MOST_CELLS:.0e}; write "
            "fewer, or a config"
        )
    grid = study.set_out(axes)
    built = choose_model(grid.device, study.model, study.start)
    values = follow_rows(built, rows_of(grid), grid.axes["N"], study.run, observers)
    values = {key: column.reshape(grid.shape) for key, column in values.items()}
    return with_summary(as_cube(grid.axes, values, study.document()))


def as_cube(axes: Mapping[str, np.ndarray], values: Mapping, document: Mapping) -> xr.Dataset:
    """Make a cube of axes and the values of each variable, in their shape."""
    data = {key: (tuple(axes), values[key]) for key in variables("cube") if key in values}
    if distance := label_distance(document.get("model", {})):
        data["t_snap"] = *data["t_snap"], {"label_distance": distance}
    return dress("cube", xr.Dataset(data, axes), document)


def require_cube(cube: xr.Dataset, name: str = "cube") -> xr.DataArray:
    """Give the codes of a cube's outcomes; ValueError, one line with `name`, if it is no cube."""
    codes = cube.get("outcome")
    if codes is None or codes.dtype.kind not in "iuf":
        raise ValueError(f"{name}: is not a cube, as it has no codes of outcomes")
    if missing := {"long_name", "flag_meanings"} - codes.attrs.keys():
        raise ValueError(f"{name}: {codes.name} has lost its attribute {min(missing)}; keep them")
    for key in (key for key in codes.dims if key not in NAMES):
        if cube[key].dtype.kind not in "iuf" or cube[key].isnull().any():
            raise ValueError(f"{name}: {key} is an axis of numbers, but has other values")
    return codes


def require_codes(codes: np.ndarray, name: str = "cube") -> None:
    """Raise ValueError, one line with `name`, if a code is that of no outcome."""
    if wrong := sorted({*np.unique(codes).tolist()} - {*range(len(OUTCOMES))}):
        last = len(OUTCOMES) - 1
        raise ValueError(f"{name}: {wrong[0]} is not a code of an outcome; codes are 0 to {last}")


def label_distance(model: Mapping) -> float | None:
    """Give the relative distance from a threshold within which labels may be wrong, or None."""
    if "laws" in model:
        return None
    if model.get("name") != "auto":
        return LABEL_DISTANCE
    return OVER_TOLERANCE * max(model.get("tolerance", TOLERANCE), TOLERANCE)


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add attributes: the numbers of cells.

    Counted are the cells of each outcome, those that end elsewhere with another time step, and
    those whose labels may be wrong.
    """
    numbers = sum((Counter(count(block)) for block in _blocks(cube.outcome)), Counter())
    counts = {name: numbers[name] for name in OUTCOMES if numbers[name]}
    if counts.keys() & OUTCOMES[ABSENT:]:
        cube.outcome.attrs.update(flags(OUTCOMES))
    named = {f"cells_{name}": number for name, number in counts.items()}
    if "well_reproduced" in cube:
        apart = ended_elsewhere(cube.well_reproduced, cube.well_share)
        named[ELSEWHERE] = sum(int(block.sum()) for block in _blocks(apart))
    if "label_distance" in cube.t_snap.attrs:
        named[NEAR_CHANGE] = round(sum(map(_near_change(cube), _blocks(cube.t_snap))))
    return cube.assign_attrs(named)


def _near_change(cube):
    """Make a function of a block of t_snap: the expected number of cells within label_distance.

    A change of label may lie anywhere between two N.
    """
    order, distance = np.argsort(cube.N.values), cube.t_snap.attrs["label_distance"]
    N = cube.N.values[order]

    def expected(t_snap):
        snapped = np.isfinite(t_snap[..., order])
        *_, k = np.nonzero(snapped[..., 1:] != snapped[..., :-1])
        return float(np.sum(2 * distance * N[k] / (N[k + 1] - N[k])))

    return expected


def _blocks(variable):
    """Give the values of a variable by blocks, as a lazy cube may be larger than memory."""
    if variable.chunks is None:
        return [variable.values]
    return (block.compute(scheduler="synchronous") for block in variable.data.blocks.ravel())


def summary(cube: xr.Dataset) -> str:
    """Sum up a cube in one line, by the attributes that `with_summary` added."""
    counts = {name: cube.attrs.get(f"cells_{name}", 0) for name in OUTCOMES}
    left = sum(counts[name] for name in ("unsnapped", "snapped", "failed"))
    settled = sum(counts.values()) - left - counts["absent"]
    # The share is rounded down: all but one of ten thousand are 99.9 %.
    share = f"{math.floor(1000 * settled / max(1, settled + left)) / 10:g} %"
    facts = [f"{sum(counts.values())} cells, {'all' if settled and not left else share} settled"]
    if number := cube.attrs.get(ELSEWHERE):
        facts.append(f"{number} on another side with a smaller time step")
    if near := cube.attrs.get(NEAR_CHANGE):
        distance = 100 * cube.t_snap.attrs["label_distance"]
        facts.append(f"about {near} within {distance:g} % of a threshold, of uncertain label")
    named = [f"{number} {name}" for name, number in counts.items() if number or name == "failed"]
    return "; ".join([*facts, ", ".join(named)])


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

"""A slab of the grid, the work of one job: its name, its file, and how it is followed."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import netCDF4
import numpy as np

from ..files.atomic import is_whole, replacing, seal
from ..solver.adaptive import choose_model
from ..solver.options import section_of
from ..solver.outcome import count
from ..study.axes import DEVICE, NAMES, SHAPE, rows_of, shared_points
from ..study.provenance import versions
from ..study.study import Study
from .grid import Observers, follow_rows

REMEDY = "remove it, and the next run makes it again"
Slab = Mapping[str, tuple]
"""Values on each axis, in order and ascending: internal units, f0 in Hz; names on axes of NAMES."""


def cells_in(slab: Slab) -> int:
    """Count the cells of a slab."""
    return math.prod(len(values) for values in slab.values())


def slab_name(study: Study, slab: Slab) -> str:
    """Name a slab by two hashes: of what slabs with shared cells agree in, and of its axes."""
    names = study.devices(), study.shocks.shapes, study.shocks.directions
    named = zip(NAMES, names, strict=True)
    fixed = [_meaning(study, key, name) for key, all in named if key not in slab for name in all]
    common = [fixed, section_of(study.model), study.section(), [*slab]]
    plain = json.dumps(common, sort_keys=True, default=np.ndarray.tolist)
    values = ", ".join(map(_text, _identified(study, slab).values()))
    return "_".join(_digest(text.encode()) for text in (plain, f"[{values}]"))


def _identified(study, slab):
    """Give the axes of a slab, each name with the hash of what it means."""
    return {
        key: tuple(f"{name} {_meaning(study, key, name)}" for name in values)
        if key in NAMES
        else values
        for key, values in slab.items()
    }


def _meaning(study, key, name):
    """Hash what a name on an axis means in a study; a direction means itself."""
    if key == DEVICE:
        values = asdict(study.devices()[name])
        return _digest(json.dumps(values, sort_keys=True, default=np.ndarray.tolist).encode())
    return _digest(study.shocks.shapes[name].pieces.tobytes()) if key == SHAPE else name


def _digest(content):
    return hashlib.sha256(content).hexdigest()[:12]


@lru_cache  # many slabs share their N
def _text(values):
    return json.dumps(values)


def write_slab(
    study: Study, slab: Slab, path: str | Path, code: str = "", observers: Observers = ()
) -> dict[str, int]:
    """Follow the cells of a slab and write it to `path`; returns the number of each outcome.

    Cells that other slabs in the same folder hold are copied from there.
    code: hash of the code on which numbers depend; only slabs of the same code are used
    """
    axes = _identified(study, slab)
    variables, known = recall(path, axes, code, same_N=study.model.name == "auto")
    grid = study.part(slab).set_out({key: slab[key] for key in slab if key not in NAMES})
    _follow_unknown(grid, study, observers, variables, known)
    with replacing(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            file.setncatts({"slab": slab_name(study, slab), "code": code, **versions()})
            file.names = json.dumps({axis: axes[axis] for axis in slab if axis in NAMES})
            for axis, values in slab.items():
                file.createDimension(axis, len(values))
                dtype = str if axis in NAMES else "f8"
                file.createVariable(axis, dtype, (axis,))[:] = np.array(values)
            for key, values in variables.items():
                file.createVariable(key, values.dtype, tuple(slab), compression="zlib")
                file[key][:] = values
        seal(temporary)
    return count(variables["outcome"])


@contextmanager
def open_slab(path: str | Path) -> Iterator[netCDF4.Dataset]:
    """Open a slab; raises ValueError, one line, for a file that is not the slab of its name."""
    if not Path(path).exists():
        raise ValueError(f"{path}: missing; run again to make it")
    if not is_whole(path):
        raise ValueError(f"{path}: is damaged; {REMEDY}")
    with netCDF4.Dataset(path) as slab:
        slab.set_auto_maskandscale(False)
        name = getattr(slab, "slab", None)
        if name != Path(path).stem:
            raise ValueError(f"{path}: has the content of slab {name}; {REMEDY}")
        yield slab


def recall(
    path: str | Path, slab: Slab, code: str, same_N: bool
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Read cells of a slab from other slabs in the folder of `path`.

    slab: values on each axis, as `_identified` gives them
    code: hash of the code that made the other slabs
    same_N: whether only slabs with the same N count, as a cell depends on its neighbours along N
    Returns the variables by name, in the shape of the slab, and which of its cells are known.
    """
    path, axes = Path(path), {key: np.asarray(values) for key, values in slab.items()}
    known, variables = np.zeros([values.size for values in axes.values()], bool), {}
    for other in sorted(path.parent.glob(f"{path.stem.split('_')[0]}_*.nc")):
        try:
            if not (shared := _shared(other, axes, code, same_N)):
                continue
            place, place_in_file = shared
            with open_slab(other) as file:
                for key in set(file.variables) - set(file.dimensions):
                    empty = np.empty(known.shape, file[key].dtype)
                    variables.setdefault(key, empty)[place] = file[key][:][place_in_file]
            known[place] = True
        except (AttributeError, IndexError, OSError, RuntimeError, ValueError):
            continue  # a broken file: its cells are followed again, and rule collect names it
    return variables, known


def _shared(path, axes, code, same_N):
    """Find the places of shared cells, in a slab with these axes and in a file; () for none.

    The name of the file says nothing: each slab of a large study would have to hash all others.
    """
    with netCDF4.Dataset(path) as file:
        names = json.loads(file.names)
        in_file = {key: np.asarray(names[key] if key in NAMES else file[key][:]) for key in axes}
        if file.code != code or (same_N and not np.array_equal(axes["N"], in_file["N"])):
            return ()
    here, there = shared_points(axes, in_file)
    return (np.ix_(*here), np.ix_(*there)) if all(index.size for index in here) else ()


def _follow_unknown(grid, study, observers, variables, known):
    """Follow unknown cells, rows with the same gaps at once, and put them into the variables."""
    if known.all():
        return
    built = choose_model(grid.device, study.model, study.start)
    rows, N = rows_of(grid), grid.axes["N"]
    unknown = ~known.reshape(-1, N.size)
    patterns, pattern_of = np.unique(unknown, axis=0, return_inverse=True)
    for number in np.flatnonzero(patterns.any(axis=1)):
        alike, pattern = np.flatnonzero(pattern_of.ravel() == number), patterns[number]
        followed = follow_rows(built, rows.take(alike), N[pattern], study.run, observers)
        for key, values in followed.items():
            all_rows = variables.setdefault(key, np.empty(known.shape, values.dtype))
            all_rows.reshape(-1, N.size)[np.ix_(alike, pattern)] = values

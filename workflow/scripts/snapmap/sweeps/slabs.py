"""A slab of the grid, the work of one job: its name, its file, and how its rows are followed."""

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import netCDF4
import numpy as np

from ..files.atomic import is_whole, replacing, seal
from ..pulse.pulse import blow_at
from ..solver.adaptive import choose_model
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.options import section_of
from ..solver.outcome import ABSENT, FAILED, REPEATED_STEP, count, label, t_snap_error, work_error
from ..solver.settings import FIRST, Run
from ..study.axes import DEVICE, NAMES, SHAPE, rows_of, shared_points
from ..study.provenance import versions
from ..study.study import Study

Observers = Sequence[Callable]
"""Functions of model, cells, observations and settings that give further variables by name."""
ABSENCE = {
    "outcome": ABSENT,
    **dict.fromkeys(("well", "halvings", "level", "blow"), 0),
    **dict.fromkeys(("agreed", "reproduced", "well_reproduced"), 1),
}
"""Values of variables where there is no device; NaN for all others."""


def follow_rows(
    model: Follows, rows: Rows, N: Sequence[float], settings: Run, observers: Observers = ()
) -> dict[str, np.ndarray]:
    """Follow rows of cells through all N; returns the variables of a cube by name, (rows, N)."""
    exists, N = rows.device >= 0, np.asarray(N)
    order = np.argsort(N, kind="stable")
    cells = rows.take(exists).cells(model.device, N[order], settings.horizon)
    first = model.follow(cells, settings)
    variables = _variables(first, settings)
    if settings.repeats:
        again = model.with_step(REPEATED_STEP).follow(cells, settings)
        variables |= _repeated(variables, _variables(again, settings))
        for compare in (work_error, t_snap_error):
            variables[compare.__name__] = compare(first, again).astype(np.float32)
    for observe in observers:
        variables |= observe(model, cells, first, settings)
    if any(pulse.blows.size for pulse in rows.pulses):
        variables["blow"] = blow_at(rows.pulses, cells.pulse, first.t_snap * cells.f0)
    for key, values in variables.items():
        variables[key] = np.full((exists.size, N.size), ABSENCE.get(key, np.nan), values.dtype)
        variables[key][np.ix_(exists, order)] = values
    return variables


def _variables(runs, settings):
    """Give the variables of cells, by name, that one run of each determines."""
    names = "t_snap", "t_settled", "energy_error", "pulse_work", "halvings", "level", "agreed"
    variables = {"outcome": label(runs, settings.energy_tolerance)}
    variables |= {name: getattr(runs, name) for name in names}
    variables["pulse_work"] = runs.pulse_work.astype(np.float32)
    if settings.until == "settled":
        failed = variables["outcome"] == FAILED
        well = runs.well if settings.start == FIRST else np.where(runs.well, 3 - runs.well, 0)
        variables["well"] = np.where(failed, 0, well).astype(np.int8)
        variables["well_share"] = np.where(failed, np.nan, runs.well_share).astype(np.float32)
    return {key: values for key, values in variables.items() if values is not None}


def _repeated(first, again):
    """Compare two runs of cells; returns variables that tell where they agree."""
    same = again["outcome"] == first["outcome"]
    variables = {"reproduced": same.astype(np.int8)}
    if "well" in first:
        snapped = [np.isfinite(run["t_snap"]) for run in (first, again)]
        # Where a run tells no well, its label is compared.
        same = (again["well"] == first["well"]) & ((first["well"] != 0) | np.equal(*snapped))
        variables["well_reproduced"] = same.astype(np.int8)
    return variables


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

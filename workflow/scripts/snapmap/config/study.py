"""The door: a config document to a `Study` in internal units, or one line for every fault."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..axes import DEVICE, DURATION, NAMES, PULSE_AXES, SHOCK, Grid, axis_behind, make_grid
from ..beam.barrier import find_barrier
from ..beam.cosines import buckling_shapes
from ..device import VALUES, Beam, Device, batch
from ..io.points import read_points
from ..io.provenance import asked_for
from ..io.recorded import shocks_of
from ..numerics.portable import geometric, linear
from ..pulse import HANDOUT_SHOCK, Shocks
from ..solver.settings import THRESHOLD_TOLERANCE, Settings
from .schema import name_of, order_of, schema_faults, validator
from .tolerances import Tolerances, read_tolerances
from .units import KINDS, read, show
from .views import (
    View,
    choose_boundary,
    choose_curves,
    choose_maps,
    nearest_cell,
    value_name,
)
from .yaml_file import ConfigError, read_document


class History(NamedTuple):
    """A cell whose time history is drawn.

    name: of its files
    device: the study's, with what the cell changes; N: multiples of g; f0: Hz; C: uN us/um
    changes: the values of the device that are not the nominal ones, and its name if it has one
    """

    name: str
    device: Device
    N: float
    f0: float
    C: float
    changes: dict[str, float | str]

    @property
    def shock(self) -> dict[str, float]:
        """N, f0 and C."""
        return {"N": self.N, "f0": self.f0, "C": self.C}


class Requirement(NamedTuple):
    """A shock that must or must not trip the device.

    pulse: values for `shocks_of`; N: multiples of g; f0: Hz; snaps: whether it must
    """

    name: str
    pulse: dict
    N: float
    f0: float
    snaps: bool


@dataclass(frozen=True, eq=False)
class Study:
    """A device, a model and the cells of a sweep.

    device: the nominal one, or several by name
    model: name and options, as given
    grid: all axes, each ascending
    skip: whether a device without a second stable shape is marked, not refused
    settings: how each cell is followed
    shocks: their pulses; pulse: the values of the section, for `shocks_of`
    requirements: shocks that must or must not trip the device
    tolerances: what scatters from device to device, or nothing
    threshold_tolerance: of the thresholds in N, relative
    maps, curves, boundary: what is drawn of cells, thresholds, and the damage boundary
    marks: path of a user's own points on the maps, or nothing
    left_out: one line on what is not drawn, or nothing
    """

    device: Device | dict[str, Device]
    model: dict
    grid: Grid
    skip: bool
    settings: Settings
    shocks: Shocks
    pulse: dict
    requirements: tuple[Requirement, ...]
    tolerances: Tolerances | None
    threshold_tolerance: float
    histories: tuple[History, ...]
    maps: tuple[View, ...]
    curves: tuple[View, ...]
    boundary: View
    marks: str
    left_out: str

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values by name, in the order of all products."""
        return self.grid.axes

    def document(self) -> dict:
        """What its products say was asked for: the same however the config spells it."""
        return asked_for(self.device, self.shocks, self.model, self.settings.asked())

    def doubts(self) -> list[str]:
        """Lines on what its devices and its recorded shocks may leave out."""
        shortest, device = 1e6 / self.axes["f0"][-1], nominal(self.device)
        named = self.device if isinstance(self.device, Mapping) else {"device": self.device}
        tilts = [f"{name}: {line}" for name, one in named.items() if (line := tilting(one.beam))]
        return tilts + [
            line
            for pulse in self.shocks.shapes.values()
            for line in pulse.doubts(float(device.own_frequency), float(shortest))
        ]


def tilting(beam: Beam) -> str:
    """One line on what a beam that is guided, or free to tilt, means for its labels, or nothing."""
    if not beam.free and not beam.stays_if_free:
        return (
            f"rise/thickness = {beam.bistability:.4g}: labels hold for a guided beam only; one "
            "free to tilt does not stay in the second shape"
        )
    if beam.free and find_barrier(beam, buckling_shapes(TILTING)).energy == 0:
        return (
            "free to tilt, the beam has no stable second shape: a snap is the midpoint's first "
            "arrival where a guided beam has its own, and nothing latches"
        )
    return ""


TILTING = 8
"""Shapes of each kind by which it is told whether a free beam has a second one."""
SHARES = ("rise", "fall")
"""Of a trapezoid, over its duration."""

# ASSUME: without a list of histories, the grid's cell nearest the handout's own case is drawn.
HANDOUT_CASE = {"N": 1000.0, "f0": 1500.0, "C": 0.025}

_KINDS = {
    **dict.fromkeys(("span", "rise", "thickness", "depth"), "length"),
    **{"youngs_modulus": "modulus", "density": "density", "damping": "rate", "mass": "mass"},
    **{"residual_stress": "stress", "imperfection": "distance", "gap": "distance"},
    **{"spring": "stiffness", "contact": "contact", "C": "damper", "f0": "frequency"},
    **{"duration": "pulse", "N": "number"},
}


def load_study(document: Mapping) -> Study:
    """Check a whole config document and convert it; raises ConfigError naming every fault."""
    faults = schema_faults(document)
    parts = document if isinstance(document, Mapping) else {}
    device = _devices(parts, faults)
    given = parts.get("sweep")
    recorded = isinstance(parts.get("pulse"), Mapping) and "file" in parts["pulse"]
    pulse = _pulse_key(given, ("sweep",), faults, recorded)
    varied = [key for key in given if key in VALUES] if isinstance(given, Mapping) else []
    shocks = _part(document, ("pulse",), faults, _shocks) if "pulse" in parts else HANDOUT_SHOCK
    keys = [*varied, "C", *([pulse] if pulse else []), "N"]
    axes = {
        "f0" if key == "duration" else key: _part(document, ("sweep", key), faults, _axis, key)
        for key in keys
    }
    cells = parts.get("histories")
    for place, cell in enumerate(cells if isinstance(cells, list | tuple) else ()):
        _pulse_key(cell, ("histories", place), faults)
    requirements = _requirements(parts, faults)
    _refuse(faults)
    skip = given.get("not_bistable") == "skip"
    if "f0" not in axes:
        axes["f0"] = np.array([shocks.own_frequency()])
    grid = _part(document, ("sweep",), faults, lambda _: _grid(device, axes, skip, shocks))
    tolerances = None
    if "tolerances" in parts:
        devices = list(device.values()) if isinstance(device, Mapping) else [device]
        at = ("tolerances",)
        tolerances = _part(document, at, faults, read_tolerances, devices, _KINDS)
    histories = _histories(document, device, grid, faults)
    marks = _part(document, ("marks",), faults, _marks) if "marks" in parts else ""
    maps = _views(document, "maps", faults, grid)
    curves = _views(document, "thresholds", faults, grid)
    _refuse(faults)
    chosen, left_out = choose_maps(grid, nominal(device), maps)
    return Study(
        device=device,
        model=_model(document["model"]),
        grid=grid,
        skip=skip,
        settings=_settings(given),
        shocks=shocks,
        pulse=_pulse_values(parts.get("pulse", {})),
        requirements=requirements,
        tolerances=tolerances,
        threshold_tolerance=given.get("threshold_tolerance", THRESHOLD_TOLERANCE),
        histories=histories,
        maps=chosen,
        curves=choose_curves(grid, nominal(device), curves),
        boundary=choose_boundary(grid, nominal(device)),
        marks=marks,
        left_out=left_out,
    )


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """The device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device


def load_device(path: str | Path) -> Device:
    """Read the device of a config file, whatever its other sections; raises ConfigError.

    >>> snapmap.load_device("config/config.yaml").beam.thickness
    2.0
    """
    document = read_document(path)
    if "device" not in document:
        raise ConfigError(f"device: missing; write {_wanted('device')}")
    faults = {at: line for at, line in schema_faults(document).items() if at[:1] == ("device",)}
    device = _part(document, ("device",), faults, _device)
    _refuse(faults)
    return device


def _part(document, path, faults, convert, *options):
    """Convert the section at `path` unless it is faulty; a fault found here joins `faults`."""
    if any(at[: len(path)] == path[: len(at)] for at in faults):
        return None
    for key in path:
        document = document[key]
    try:
        return convert(document, *options)
    except ValueError as error:
        faults[path] = str(error)
    return None


def _refuse(faults):
    if faults:
        raise ConfigError(*(faults[path] for path in sorted(faults, key=order_of)))


def _devices(document, faults):
    """The device of a study, or several by name; one of the two sections must be there."""
    both = "device" in document, "devices" in document
    if faults.get(()):
        return None
    if not any(both):
        faults[("device",)] = f"device: missing; write {_wanted('device')}"
    elif all(both):
        faults[("devices",)] = "devices: stand beside device; write one of them"
    elif both[0]:
        return _part(document, ("device",), faults, _device)
    elif not any(at[:1] == ("devices",) for at in faults):
        return {
            name: _part(document, ("devices", name), faults, _device, f"devices.{name}")
            for name in document["devices"]
        }
    return None


def _wanted(key):
    return validator().schema["properties"][key]["description"]


def _device(section, name="device"):
    formats = validator().schema["$defs"]["device"]["properties"]
    try:
        return Device(
            beam=_beam(section["beam"], formats["beam"]["properties"]),
            **_convert({key: section[key] for key in section if key != "beam"}, formats),
        )
    except ValueError as error:
        raise ValueError(str(error).replace("device.", f"{name}.", 1)) from None


def _beam(section, formats):
    values = {key: value for key, value in section.items() if key != "guide"}
    free = section.get("guide") == "free"
    if "imperfection" in section and not free:
        raise ValueError("device.beam.imperfection: is of a free beam; write guide: free")
    return Beam(**_convert(values, formats), free=float(free))


def _convert(section, formats):
    return {key: read(value, formats[key]["format"]) for key, value in section.items()}


def _shocks(section):
    """The shocks of a section with shape or file."""
    if "file" in section:
        beside = next((key for key in ("shape", "rise", "fall") if key in section), None)
        if beside:
            raise ValueError(f"pulse.{beside}: stands beside file; write one of them")
        try:
            _check_path(section["file"])
            return shocks_of(_pulse_values(section))
        except ValueError as error:
            raise ValueError(f"pulse.file: {error}") from None
    return shocks_of(_pulse_values(section))


def _marks(path):
    """The path of a user's own points, which are all in order."""
    try:
        _check_path(path)
        read_points(path)
    except ValueError as error:
        raise ValueError(f"marks: {error}") from None
    return path


def _check_path(path):
    if Path(path).is_absolute() or ".." in Path(path).parts:
        raise ValueError(f"{path} lies outside the study's folder; copy it there")


def _pulse_values(section):
    """Values of a section of a pulse, shares as numbers."""
    keys = [key for key in ("shape", "rise", "fall", "file", "direction") if key in section]
    return {key: read(section[key], "share") if key in SHARES else section[key] for key in keys}


def _requirements(document, faults):
    """What must or must not trip the device; names are written once."""
    asked = document.get("requirements")
    found, names = [], set()
    for place, section in enumerate(asked if isinstance(asked, list | tuple) else ()):
        path = ("requirements", place)
        recorded = isinstance(section, Mapping) and "file" in section
        _pulse_key(section, path, faults, recorded)
        found.append(_part(document, path, faults, _requirement, path, names))
    return tuple(found)


def _requirement(section, path, names):
    name = section["name"]
    if name in names:
        raise ValueError(f"{name_of((*path, 'name'))}: {show(name)} comes twice; write another")
    names.add(name)
    try:
        shocks = _shocks(section)
        given = {
            key: read(section[key], _KINDS[key]) for key in ("f0", "duration") if key in section
        }
        f0 = _frequency(given["duration"]) if "duration" in given else given.get("f0")
        N = read(section["N"], "number")
        if not N > 0:
            raise ValueError(f"N: {N:g} is not above 0; a direction of -z pushes the other way")
        return Requirement(
            name, _pulse_values(section), N, f0 or shocks.own_frequency(), section["snaps"]
        )
    except ValueError as error:
        raise ValueError(f"{name_of(path)}: {error}") from None


def _grid(device, axes, skip, shocks):
    remedy = "write other values" if skip else "write other values, or not_bistable: skip"
    try:
        grid = make_grid(device, axes, skip, shocks)
    except ValueError as error:
        raise ValueError(f"sweep: {error}; {remedy}") from None
    if (grid.device_of < 0).all():
        raise ValueError(f"sweep: no device has a second stable shape; {remedy}")
    return grid


def _model(section):
    formats = validator().schema["properties"]["model"]["properties"]
    return {
        key: read(value, formats[key]["format"]) if "format" in formats[key] else value
        for key, value in section.items()
    }


def _settings(section):
    given = {key: section[key] for key in ("until", "repeat", "energy_tolerance") if key in section}
    given.setdefault("repeat", given.get("until", "settled") == "settled")
    return Settings(horizon=read(section["horizon"], "duration"), **given)


def _pulse_key(section, path, faults, recorded=False):
    """Which of f0 and duration the section at `path` has; a fault unless it is one of them.

    recorded: whether it may have neither, as a recorded shock has a duration of its own; then ""
    """
    if not isinstance(section, Mapping) or ("f0" in section) != ("duration" in section):
        return "duration" if isinstance(section, Mapping) and "duration" in section else "f0"
    if "f0" in section:
        key, complaint = "duration", "is one over f0, which is there, too; write one of them"
    elif recorded:
        return ""
    else:
        key, complaint = "f0", "missing; write frequencies (1/time), or duration"
    faults[(*path, key)] = f"{name_of((*path, key))}: {complaint}"
    return "f0"


def _histories(document, device, grid, faults):
    cells = document.get("histories")
    if cells is None:
        return () if grid is None else (_nearest_history(device, grid),)
    places = (("histories", place) for place in range(len(cells)))
    return tuple(_part(document, at, faults, _asked_history, at, device) for at in places)


def _nearest_history(device, grid):
    """The grid's cell nearest the handout's case."""
    at = nearest_cell(grid, nominal(device), HANDOUT_CASE)
    values = {key: grid.axes[key][place].item() for key, place in at.items()}
    names = {"N": "N", "f": "f0", "C": "C"}
    names |= {key: key for key in at if key not in (*SHOCK, *PULSE_AXES)}
    named = (value_name(word, grid.axes[key], at[key]) for word, key in names.items())
    cell = {key: value for key, value in values.items() if key not in PULSE_AXES}
    return _history(cell, device, read_values=False)._replace(name="_".join(named))


def _asked_history(cell, path, device):
    try:
        return _history(cell, device)
    except ValueError as error:
        raise ValueError(f"{name_of(path)}: {error}") from None


def _history(cell, device, read_values=True):
    name = cell.get(DEVICE)
    if isinstance(device, Mapping):
        name = next(iter(device)) if name is None else name
        if name not in device:
            known = ", ".join(device)
            raise ValueError(f"no device is called {show(name)}; known are {known}")
        device = device[name]
    elif name is not None:
        raise ValueError("device is for studies of several devices; leave it out")
    values = {key: cell[key] for key in cell if key != DEVICE}
    if read_values:
        values = {key: read(value, _KINDS[key]) for key, value in values.items()}
    if "duration" in values:
        values["f0"] = _frequency(values.pop("duration"))
    changes = {key: values[key] for key in values if key in VALUES}
    if changes:
        device = batch([device]).vary({k: np.array([v]) for k, v in changes.items()}).pick(0)
    if name is not None:
        changes = {DEVICE: name} | changes
    N, f0, C = (values[key] for key in ("N", "f0", "C"))
    parts = {"N": N, "f": f0, "C": C, **changes}
    words = "_".join(v if k == DEVICE else f"{k}{v:.15g}" for k, v in parts.items())
    return History(words.replace("inf", "hard"), device, N, f0, C, changes)


def _views(document, section, faults, grid):
    """Views of a section, with `at` as places on the axes; the nearest value stands for another."""
    asked = document.get(section)
    if asked is None or grid is None:
        return None
    places = ((section, place) for place in range(len(asked)))
    return [_part(document, place, faults, _view, place, grid.axes) for place in places]


def _view(asked, path, axes):
    at = {}
    used = {key: asked[key] for key in ("x", "y", "lines") if key in asked}
    for key, axis in used.items():
        if axis_behind(axis) not in axes:
            raise ValueError(f"{name_of((*path, key))}: {axis} is no axis of this sweep")
    drawn = {axis_behind(axis) for axis in used.values()}
    if len(drawn) < len(used):
        raise ValueError(f"{name_of(path)}: {' and '.join(used)} are the same axis; write two")
    for asked_axis, value in asked.get("at", {}).items():
        name, axis = name_of((*path, "at", asked_axis)), axis_behind(asked_axis)
        if axis not in axes or axis in drawn or axis in at:
            raise ValueError(f"{name}: is no axis of this sweep, or one that is drawn")
        if axis in NAMES:
            if value not in axes[axis]:
                raise ValueError(f"{name}: no {axis} is called {show(value)}")
            at[axis] = axes[axis].tolist().index(value)
            continue
        try:
            number = read(value, _KINDS[asked_axis])
            number = _frequency(number) if asked_axis == DURATION else number
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        with np.errstate(invalid="ignore"):
            apart = np.where(axes[axis] == number, 0, np.nan_to_num(abs(axes[axis] - number)))
        at[axis] = int(np.argmin(apart))
    return used | {"at": at}


def _frequency(duration):
    """Hz, of a pulse of so many us, to 14 digits: 0.5 ms is 2000 Hz."""
    return float(f"{1e6 / duration:.14g}")


def _axis(section, key):
    kind = _KINDS[key]
    if isinstance(section, Mapping):
        values = _range(section, f"sweep.{key}", kind)
    else:
        values = np.array([read(value, kind) for value in section])
    values = np.sort(values)
    before, after = values[:-1], values[1:]
    repeated = after[(after == before) | (after * (1 - 1e-14 * np.sign(after)) <= before)]
    if repeated.size:
        value = f"{repeated[0]:.15g} {KINDS[kind].unit}".strip()
        raise ValueError(f"sweep.{key}: {value} comes twice; write every value once")
    if key == "duration":
        return np.array([_frequency(value) for value in values[::-1].tolist()])
    return values


def _range(section, key, kind):
    start, stop, points = read(section["from"], kind), read(section["to"], kind), section["points"]
    if not np.isfinite([start, stop]).all():
        raise ValueError(f"{key}: hard is no end of a range; write a list")
    if (points == 1) != (start == stop):
        need = "equal ends" if points == 1 else "from and to that differ"
        raise ValueError(f"{key}.points: {points} needs {need}; write other ends or points")
    if section.get("spacing") != "log":
        return linear(start, stop, points)
    if min(start, stop) <= 0:
        raise ValueError(f"{key}.spacing: log needs from and to above 0; write linear, or a list")
    return geometric(start, stop, points)

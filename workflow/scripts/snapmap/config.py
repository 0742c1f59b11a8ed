"""The door: a config document to a `Study` in internal units, or one line for every fault."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from jsonschema import Draft202012Validator, ValidationError, validators

from .device import Beam, Device
from .document import ConfigError, read_document, unwieldy_part
from .portable import geometric, linear
from .protocol import THRESHOLD_TOLERANCE, Protocol
from .quantity import KINDS, read, show


class History(NamedTuple):
    """A cell whose time history is drawn: N in multiples of g, f0 in Hz, C in uN us/um."""

    N: float
    f0: float
    C: float


@dataclass(frozen=True, eq=False)
class Study:
    """A device, a model and the cells of a sweep.

    model: name and options, as given
    N, f0, C: ascending axes; multiples of g, Hz, uN us/um
    protocol: how each cell is followed
    threshold_tolerance: of the thresholds in N, relative
    """

    device: Device
    model: dict
    N: np.ndarray
    f0: np.ndarray
    C: np.ndarray
    protocol: Protocol
    threshold_tolerance: float
    histories: tuple[History, ...]


# ASSUME: without a list of histories, the handout's own case is drawn.
HANDOUT_CASE = History(N=1000.0, f0=1500.0, C=0.025)

_KINDS = {"N": "number", "f0": "frequency", "duration": "pulse", "C": "damper"}
_LONGEST_KEY = 40


def load_study(document: Mapping) -> Study:
    """Check a whole config document and convert it; raises ConfigError naming every fault."""
    faults = _schema_faults(document)
    device = _part(document, ("device",), faults, _device)
    parts = document if isinstance(document, Mapping) else {}
    keys = "N", _pulse_key(parts.get("sweep"), ("sweep",), faults), "C"
    N, f0, C = (_part(document, ("sweep", key), faults, _axis, key) for key in keys)
    cells = parts.get("histories")
    for place, cell in enumerate(cells if isinstance(cells, list | tuple) else ()):
        _pulse_key(cell, ("histories", place), faults)
    _refuse(faults)
    return Study(
        device=device,
        model=_model(document["model"]),
        N=N,
        f0=f0,
        C=C,
        protocol=_protocol(document["sweep"]),
        threshold_tolerance=document["sweep"].get("threshold_tolerance", THRESHOLD_TOLERANCE),
        histories=(HANDOUT_CASE,) if cells is None else tuple(_history(cell) for cell in cells),
    )


def load_device(path: str | Path) -> Device:
    """Read the device of a config file, whatever its other sections; raises ConfigError.

    >>> snapmap.load_device("config/config.yaml").beam.thickness
    2.0
    """
    document = read_document(path)
    faults = {at: line for at, line in _schema_faults(document).items() if at[0] == "device"}
    device = _part(document, ("device",), faults, _device)
    _refuse(faults)
    return device


def device_document(device: Device) -> dict:
    """The device section of a config, with units, for a device in internal units."""
    formats = _validator().schema["properties"]["device"]["properties"]
    beam = _write_out(device.beam, formats["beam"]["properties"])
    return {"beam": beam} | _write_out(device, {k: formats[k] for k in formats if k != "beam"})


def _write_out(section, formats):
    values = {key: (getattr(section, key), KINDS[formats[key]["format"]].unit) for key in formats}
    return {
        key: "hard" if value == math.inf else f"{value!r} {unit}"
        for key, (value, unit) in values.items()
    }


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
        raise ConfigError(*(faults[path] for path in sorted(faults, key=_order)))


def _device(section):
    formats = _validator().schema["properties"]["device"]["properties"]
    return Device(
        beam=Beam(**_convert(section["beam"], formats["beam"]["properties"])),
        **_convert({key: section[key] for key in section if key != "beam"}, formats),
    )


def _convert(section, formats):
    return {key: read(value, formats[key]["format"]) for key, value in section.items()}


def _model(section):
    formats = _validator().schema["properties"]["model"]["properties"]
    return {
        key: read(value, formats[key]["format"]) if "format" in formats[key] else value
        for key, value in section.items()
    }


def _protocol(section):
    given = {key: section[key] for key in ("until", "repeat", "energy_tolerance") if key in section}
    given.setdefault("repeat", given.get("until", "settled") == "settled")
    return Protocol(horizon=read(section["horizon"], "duration"), **given)


def _pulse_key(section, path, faults):
    """Which of f0 and duration the section at `path` has; a fault unless it is one of them."""
    if not isinstance(section, Mapping) or ("f0" in section) != ("duration" in section):
        return "duration" if isinstance(section, Mapping) and "duration" in section else "f0"
    if "f0" in section:
        key, complaint = "duration", "is one over f0, which is there, too; write one of them"
    else:
        key, complaint = "f0", "missing; write frequencies (1/time), or duration"
    faults[(*path, key)] = f"{_name((*path, key))}: {complaint}"
    return "f0"


def _history(cell):
    values = {key: read(value, _KINDS[key]) for key, value in cell.items()}
    if "duration" in values:
        values["f0"] = _frequency(values.pop("duration"))
    return History(**values)


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
    repeated = values[1:][np.diff(values) <= 1e-14 * np.abs(values[1:])]
    if repeated.size:
        value = f"{repeated[0]:.15g} {KINDS[kind].unit}".strip()
        raise ValueError(f"sweep.{key}: {value} comes twice; write every value once")
    if key == "duration":
        return np.array([_frequency(value) for value in values[::-1].tolist()])
    return values


def _range(section, key, kind):
    start, stop, points = read(section["from"], kind), read(section["to"], kind), section["points"]
    if (points == 1) != (start == stop):
        need = "equal ends" if points == 1 else "from and to that differ"
        raise ValueError(f"{key}.points: {points} needs {need}; write other ends or points")
    if section.get("spacing") != "log":
        return linear(start, stop, points)
    if min(start, stop) <= 0:
        raise ValueError(f"{key}.spacing: log needs from and to above 0; write linear, or a list")
    return geometric(start, stop, points)


def _schema_faults(document):
    """Where the document breaks the schema: {path: line}."""
    if unwieldy := unwieldy_part(document):
        path, complaint = unwieldy
        return {path: f"{_name(path)}: {complaint}"}
    errors = _validator().iter_errors(document)
    return {
        path: f"{_name(path)}: {message}" for error in errors for path, message in _explain(error)
    }


def _explain(error) -> Iterator[tuple[tuple, str]]:
    path, value, schema = tuple(error.absolute_path), error.instance, error.schema
    known = schema.get("properties", {})
    if error.validator == "required":
        for key in error.validator_value:
            if key not in value:
                yield (*path, key), f"missing; write {known[key]['description']}"
    elif error.validator == "additionalProperties":
        for key in value:
            if key not in known:
                yield (*path, key), f"unknown key; known here are {', '.join(known)}"
    elif error.validator == "format":
        yield path, error.message
    elif "format" not in schema:
        yield path, f"{show(value)} is not {schema['description']}"


def _name(path):
    """device.beam.span, sweep.f0[2]; the document itself is `config`."""
    name = ""
    for key in path:
        plain = isinstance(key, str) and key.isidentifier() and len(key) <= _LONGEST_KEY
        name += f".{key}" if plain else f"[{show(key)}]"
    return name.removeprefix(".") or "config"


def _order(path):
    return [f"{key:07d}" if isinstance(key, int) else str(key) for key in path]


@cache
def _validator():
    schema = yaml.safe_load(Path(__file__).with_name("schema.yaml").read_text(encoding="utf-8"))
    types = Draft202012Validator.TYPE_CHECKER.redefine_many(
        {
            "object": lambda _, value: isinstance(value, Mapping),
            "array": lambda _, value: isinstance(value, list | tuple),
            "integer": lambda _, value: type(value) is int,
            "number": lambda _, value: type(value) in (int, float) and abs(value) < math.inf,
        }
    )
    strict = validators.extend(Draft202012Validator, {"format": _check_format}, type_checker=types)
    return strict(schema)


def _check_format(validator, kind, value, schema):
    try:
        read(value, kind)
    except ValueError as error:
        yield ValidationError(str(error))

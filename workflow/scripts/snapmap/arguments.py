"""What each argument of a public function may be, in one line each.

ARGUMENTS says of each name what would be right, in words with an example, what fits, and what is
handed on of that, so that a number of numpy's or xarray's is one of Python's from there on; values
of the device, N, f0 and C take their units and ranges from `quantities.py`. Options of models are
held against it whether they come from Python or from a config.
"""

import re
from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from os.path import exists

import numpy as np

from .device.argument import Argument, as_plain, integer, number, of_type, pairs, row, word
from .device.checks import numbers
from .device.device import VALUES, Device
from .device.quantities import QUANTITIES, Bounds, bounds_of
from .pulse.options import OF_PULSE
from .pulse.pulse import DIRECTIONS, SHAPES, Pulse
from .solver.options import OF_MODEL, OPTIONS


def _dataset(need: str, variable: str) -> Argument:
    """By its attributes: xarray is imported by those alone who make one."""
    return Argument(need, lambda value: hasattr(value, "data_vars") and variable in value)


def _is_flag(value):
    return isinstance(value, bool | np.bool_) or (
        getattr(value, "ndim", None) == 0 and np.asarray(value).dtype.kind == "b"
    )


def _is_pair(value):
    pair = numbers(value)
    return pair is not None and pair.shape == (2,) and bool(np.isfinite(pair).all())


def _is_pulse(value):
    if isinstance(value, str):
        return value in SHAPES
    return isinstance(value, Pulse) or (isinstance(value, Mapping | list | tuple) and bool(value))


def _is_path(value):
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


def _is_list(value, fits):
    return isinstance(value, list | tuple) and all(map(fits, value))


def _is_table(value):
    columns = [value[key] for key in value] if hasattr(value, "keys") else [None]
    return all(map(_is_column, columns))


def _is_column(value):
    return _is_list(list(value) if getattr(value, "ndim", 0) == 1 else value, _is_entry)


def _is_entry(value):
    if isinstance(value, str):
        return "\n" not in value
    array = numbers(value)
    return value is None or _is_flag(value) or (array is not None and array.ndim == 0)


def _mapping_of(need: str, *keys: str) -> Argument:
    def fits(value):
        return isinstance(value, Mapping) and len(value) > 0 and all(key in keys for key in value)

    return Argument(f"a mapping of {need}", fits, as_plain)


def _are_directions(value):
    if isinstance(value, str):
        return value in (*DIRECTIONS, "both")
    named = _is_list(value, lambda name: isinstance(name, str) and name in DIRECTIONS)
    return named and 0 < len(value) == len({*value})


def _is_device(value):
    if not isinstance(value, Device):
        return False
    parts = (value, value.beam)
    return not any(np.ndim(getattr(part, field.name)) for part in parts for field in fields(part))


def _are_devices(value):
    named = value.values() if isinstance(value, Mapping) and value else [value]
    return all(map(_is_device, named))


def _is_requirement(value):
    return (
        isinstance(value, Mapping)
        and REQUIRED.keys() <= value.keys()
        and all(kind.fits(value[key]) for key, kind in REQUIRED.items())
        and START.fits(value.get("start", "first"))
    )


def _requirement(value):
    return {**value, **{key: kind.convert(value[key]) for key, kind in REQUIRED.items()}}


def _of_axis(key: str, example: str) -> tuple[Bounds, str, str]:
    return QUANTITIES[key].range, QUANTITIES[key].unit, example


POSITIVE = number("(0, inf)")
FLAG, START = Argument("True or False", _is_flag, bool), word("first", "second")
TRIPS = Argument(
    'True, False, or "any"',
    lambda value: FLAG.fits(value) or (isinstance(value, str) and value == "any"),
    lambda value: value if isinstance(value, str) else bool(value),
)
REQUIRED = {"name": of_type("a name", str), "N": POSITIVE, "f0": POSITIVE, "snaps": TRIPS}
"""What a requirement has."""
THRESHOLDS = _dataset("a Dataset of thresholds, as threshold returns it", "N_first")
PATH = Argument("the path of a file that is there", _is_path)
DEVICE = Argument("a single Device; load_device reads one", _is_device)
SERIES = Argument("a row of numbers", lambda value: numbers(value) is not None, numbers)
LAW = Argument("a function of numbers, nor None", lambda value: value is None or callable(value))
SHOCK = {
    "N": (bounds_of("[0, inf)"), "multiples of g (direction -z pushes the other way)", "1000"),
    "f0": _of_axis("f0", "1500"),
    "C": _of_axis("C", "25"),
}
SINGLE = {key: number(*words) for key, words in SHOCK.items()}

ARGUMENTS = {
    "device": Argument("a Device, or several by name; load_device reads one", _are_devices),
    **dict.fromkeys(
        (f"{name}.device" for name in ("statics", "calibrate", "design", "simulate")), DEVICE
    ),
    **{key: row(within, unit, f"[{text}]") for key, (within, unit, text) in SHOCK.items()},
    **{key: row(*_of_axis(key, "")) for key in VALUES},
    **{f"{name}.{key}": SINGLE[key] for name in ("simulate", "design") for key in SINGLE},
    "design.N": POSITIVE,
    "calibrate.C": SINGLE["C"],
    "model": Argument(
        f"one of {', '.join(OPTIONS)}, nor a mapping of its name and options, as reference makes",
        lambda value: isinstance(value, Mapping) or (isinstance(value, str) and value in OPTIONS),
    ),
    **{f"model.{key}": argument for key, argument in OF_MODEL.items()},
    "horizon": number("[0, inf)", "us", "1500"),
    "energy_tolerance": number("(0, 1)", "", "1e-3"),
    "threads": integer(1, 1024),
    "until": word("settled", "snap"),
    "start": START,
    "repeat": FLAG,
    "skip": FLAG,
    "pulse": Argument(
        f"one of {', '.join(SHAPES)}, nor what sampled or read_pulse makes", _is_pulse
    ),
    **{f"pulse.{key}": argument for key, argument in OF_PULSE.items()},
    "direction": Argument("+z, -z, both, or a list of these", _are_directions),
    **dict.fromkeys(
        (f"{name}.direction" for name in ("simulate", "srs_test", "calibrate")), word("+z", "-z")
    ),
    "tolerance": number("[1e-9, 0.01]", "", "1e-4"),
    "tolerance.tolerance": number("[1e-5, 0.01]", "", "1e-3"),
    "highest": number("(0, inf)", "multiples of g", "2000"),
    "value": Argument(
        "C, nor the name of a value of the device, such as thickness",
        lambda value: isinstance(value, str) and (value == "C" or value in VALUES),
    ),
    "between": Argument("a pair of numbers, low and high, such as (1.8, 2.2)", _is_pair, as_plain),
    "requirements": Argument(
        'a list of mappings of name, N, f0 (Hz) and snaps (True, False, or "any")',
        lambda value: _is_list(value, _is_requirement),
        lambda value: [*map(_requirement, value)],
    ),
    "scatters": _mapping_of(
        'what can scatter to its width, such as {"thickness": "3 %"}', *VALUES, "N", "duration", "C"
    ),
    "together": Argument(
        "a list of groups of names, as [[span, rise]]",
        lambda value: _is_list(
            value, lambda group: _is_list(group, lambda key: isinstance(key, str))
        ),
    ),
    "samples": integer(2, 100_000),
    "index_samples": integer(2, 100_000),
    "seed": integer(0, 2**32 - 1),
    "psd": pairs("Hz and g^2/Hz", "[(20, 0.04), (2000, 0.04)]"),
    "srs": pairs("Hz and multiples of g", "[(500, 700), (2000, 1500)]"),
    "vibration.duration": number("(0, inf)", "s", "60"),
    "records": integer(1, 10_000),
    "reach": number("(0, 1)", "", "0.01"),
    "shots": Argument(
        "the path of a file that is there, nor columns by name",
        lambda value: _is_table(value) or _is_path(value),
    ),
    "unknowns": _mapping_of(
        'values of the device, or C, to ranges, such as {"thickness": (1.7, 2.3)}', *VALUES, "C"
    ),
    "cube": _dataset("a cube, as sweep and open_cube return it", "outcome"),
    "path": PATH,
    "sha256": Argument(
        "the 64 hexadecimal digits of a SHA-256",
        lambda value: isinstance(value, str) and re.fullmatch("([0-9a-f]{64})?", value) is not None,
    ),
    **dict.fromkeys(("sampled.time", "sampled.acceleration"), SERIES),
    "sampled.name": of_type("a name", str),
    **{f"reference.{key}": LAW for key in ("damping", "contact", "force")},
    "reference.elements": OF_MODEL["elements"],
    "ax": Argument("Axes of matplotlib", lambda value: hasattr(value, "get_xlim")),
    "x": of_type("the name of an axis of the cube", str),
    "y": of_type("the name of an axis of the cube", str),
    "found": THRESHOLDS,
    "ends": FLAG,
}
"""By name, or by function and name where it is another's, too."""

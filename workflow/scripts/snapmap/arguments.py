"""What each argument of a public function may be, in one line each.

ARGUMENTS says of each name what would be right, in words with an example, what fits, and what is
handed on of that, so that a number of numpy's or xarray's is one of Python's from there on; values
of the device, N, f0 and C take their units and ranges from `quantities.py`. Options of models are
held against it whether they come from Python or from a config.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from os import PathLike
from os.path import exists
from typing import NamedTuple

import numpy as np

from .checks import numbers, show
from .device import VALUES, Device
from .pulse import DIRECTIONS, SHAPES, SHARES, TENTH, Pulse
from .quantities import QUANTITIES, Bounds, bounds_of

OPTIONS = {
    "reference": ("elements",),
    "elements": ("elements", "modes"),
    "cosines": ("cosines", "modes"),
    "auto": ("tolerance",),
}
"""Of each model."""


class Argument(NamedTuple):
    """need: what would be right, as it follows "is not"; fits: whether a value is; convert: what is
    handed on of one that fits."""

    need: str
    fits: Callable[[object], bool]
    convert: Callable[[object], object] = lambda value: value

    def take(self, name: str, value: object) -> object:
        """Convert a value; raises ValueError, one line, for one that does not fit."""
        if not self.fits(value):
            raise ValueError(f"{name}: {show(value)} is not {self.need}")
        return self.convert(value)


def _number(within: str | Bounds, unit: str = "", example: str = "") -> Argument:
    within = bounds_of(within) if isinstance(within, str) else within

    def fits(value):
        array = numbers(value)
        return array is not None and array.ndim == 0 and bool(within.holds(array))

    return Argument(_words("a number", within, unit, example), fits, _plain)


def _row(within: Bounds, unit: str, example: str) -> Argument:
    def fits(value):
        array = numbers(value)
        if array is None or array.ndim > 1 or not array.size or not within.holds(array).all():
            return False
        return np.unique(array).size == array.size

    words = _words("a number or several, each once,", within, unit, example)
    return Argument(words, fits, lambda value: np.atleast_1d(numbers(value)))


def _plain(value):
    """What is a number, or several, as Python's floats, also in a mapping; all else as it is."""
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    array = numbers(value)
    return value if array is None else array.tolist()


def _words(what, within, unit, example):
    words = " ".join(filter(None, (what, str(within), unit and f"in {unit}")))
    return f"{words}, such as {example}" if example else words


def integer(low: int, high: float = math.inf) -> Argument:
    """A whole number from low up to high."""
    number = _number(Bounds(low, high, low_fits=True, high_fits=high < math.inf))
    return Argument(
        f"a whole {number.need.removeprefix('a ')}",
        lambda value: number.fits(value) and np.asarray(value).dtype.kind in "iu",
        lambda value: int(np.asarray(value)),
    )


def _pairs(units: str, example: str) -> Argument:
    def fits(value):
        pairs = numbers(value)
        if pairs is None or pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) < 2:
            return False
        positive = np.isfinite(pairs).all() and (pairs > 0).all()
        return bool(positive and (np.diff(pairs[:, 0]) > 0).all())

    words = f"two pairs or more of {units}, above 0 and ascending, such as {example}"
    return Argument(words, fits, numbers)


def _word(*words: str) -> Argument:
    need = f"one of {', '.join(words)}"
    return Argument(need, lambda value: isinstance(value, str) and value in words)


def _of_type(need: str, *types: type) -> Argument:
    return Argument(need, lambda value: isinstance(value, types))


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

    return Argument(f"a mapping of {need}", fits, _plain)


def _are_directions(value):
    if isinstance(value, str):
        return value in (*DIRECTIONS, "both")
    named = _is_list(value, lambda each: isinstance(each, str) and each in DIRECTIONS)
    return named and 0 < len(value) == len({*value})


def _is_device(value):
    if not isinstance(value, Device):
        return False
    parts = (value, value.beam)
    return not any(np.ndim(getattr(part, one.name)) for part in parts for one in fields(part))


def _are_devices(value):
    named = value.values() if isinstance(value, Mapping) and value else [value]
    return all(map(_is_device, named))


def _is_requirement(value):
    return (
        isinstance(value, Mapping)
        and REQUIRED.keys() <= value.keys()
        and all(REQUIRED[key].fits(value[key]) for key in REQUIRED)
        and START.fits(value.get("start", "first"))
    )


def _requirement(value):
    return {**value, **{key: REQUIRED[key].convert(value[key]) for key in REQUIRED}}


def _is_group(value):
    return _is_list(value, lambda key: isinstance(key, str))


def _of_axis(key: str, example: str) -> tuple[Bounds, str, str]:
    return QUANTITIES[key].range, QUANTITIES[key].unit, example


POSITIVE, ANY = _number("(0, inf)"), _number("(-inf, inf)")
SHARE = _number("(0, 1)", "", "0.95")
FLAG, START = Argument("True or False", _is_flag, bool), _word("first", "second")
TRIPS = Argument(
    'True, False, or "any"',
    lambda value: FLAG.fits(value) or (isinstance(value, str) and value == "any"),
    lambda value: value if isinstance(value, str) else bool(value),
)
REQUIRED = {"name": _of_type("a name", str), "N": POSITIVE, "f0": POSITIVE, "snaps": TRIPS}
"""What a requirement has."""
THRESHOLDS = _dataset("a Dataset of thresholds, as threshold returns it", "N_first")
PATH = Argument("the path of a file that is there", _is_path)
DEVICE = Argument("a single Device; load_device reads one", _is_device)
SHOCK = {
    "N": (bounds_of("[0, inf)"), "multiples of g (direction -z pushes the other way)", "1000"),
    "f0": _of_axis("f0", "1500"),
    "C": _of_axis("C", "25"),
}
SINGLE = {key: _number(*words) for key, words in SHOCK.items()}

ARGUMENTS = {
    "device": Argument("a Device, or several by name; load_device reads one", _are_devices),
    **dict.fromkeys(
        (f"{name}.device" for name in ("statics", "calibrate", "design", "simulate")),
        DEVICE,
    ),
    **{key: _row(within, unit, f"[{text}]") for key, (within, unit, text) in SHOCK.items()},
    **{key: _row(*_of_axis(key, "")) for key in VALUES},
    **{f"{name}.{key}": SINGLE[key] for name in ("simulate", "design") for key in SINGLE},
    "design.N": POSITIVE,
    "calibrate.C": SINGLE["C"],
    "model": Argument(
        f"one of {', '.join(OPTIONS)}, nor a mapping of its name and options",
        lambda value: isinstance(value, Mapping) or (isinstance(value, str) and value in OPTIONS),
    ),
    "model.tolerance": _number("(0, 1)", "", "1e-3"),
    "model.elements": integer(1, 100),
    "model.cosines": integer(1, 100),
    "model.modes": integer(1, 200),
    "horizon": _number("[0, inf)", "us", "1500"),
    "energy_tolerance": _number("(0, 1)", "", "1e-3"),
    "threads": integer(1, 1024),
    "until": _word("settled", "snap"),
    "start": START,
    "repeat": FLAG,
    "skip": FLAG,
    "pulse": Argument(f"one of {', '.join(SHAPES)}, nor what read_pulse gives", _is_pulse),
    "pulse.shape": _word(*SHAPES),
    "pulse.N": Argument(
        "a number above or below 0", lambda value: ANY.fits(value) and value != 0, _plain
    ),
    **{f"pulse.{key}": _number("(0, inf)", "us", "500") for key in ("duration", "wait")},
    "pulse.height": _number("(0, inf)", "um", "1e6"),
    "pulse.rebound": _number("[0, 0.99]", "", "0.5"),
    **dict.fromkeys(("pulse.rise", "pulse.fall"), SHARE),
    "pulse.repeat": integer(1),
    "direction": Argument("+z, -z, both, or a list of these", _are_directions),
    **dict.fromkeys(
        (f"{name}.direction" for name in ("simulate", "srs_test", "calibrate")),
        _word("+z", "-z"),
    ),
    "tolerance": _number("[1e-9, 0.01]", "", "1e-4"),
    "tolerance.tolerance": _number("[1e-5, 0.01]", "", "1e-3"),
    "highest": _number("(0, inf)", "multiples of g", "2000"),
    "value": Argument(
        "C, nor the name of a value of the device, such as thickness",
        lambda value: isinstance(value, str) and (value == "C" or value in VALUES),
    ),
    "between": Argument("a pair of numbers, low and high, such as (1.8, 2.2)", _is_pair, _plain),
    "requirements": Argument(
        'a list of mappings of name, N, f0 (Hz) and snaps (True, False, or "any")',
        lambda value: _is_list(value, _is_requirement),
        lambda value: [*map(_requirement, value)],
    ),
    "scatters": _mapping_of(
        'what can scatter to its width, such as {"thickness": "3 %"}', *VALUES, "N", "duration", "C"
    ),
    "together": Argument(
        "a list of groups of names, as [[span, rise]]", lambda value: _is_list(value, _is_group)
    ),
    "samples": integer(2, 100_000),
    "index_samples": integer(2, 100_000),
    "seed": integer(0, 2**32 - 1),
    "psd": _pairs("Hz and g^2/Hz", "[(20, 0.04), (2000, 0.04)]"),
    "srs": _pairs("Hz and multiples of g", "[(500, 700), (2000, 1500)]"),
    "vibration.duration": _number("(0, inf)", "s", "60"),
    "records": integer(1, 10_000),
    "reach": _number("(0, 1)", "", "0.01"),
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
    "ax": Argument("Axes of matplotlib", lambda value: hasattr(value, "get_xlim")),
    "x": _of_type("the name of an axis of the cube", str),
    "y": _of_type("the name of an axis of the cube", str),
    "found": THRESHOLDS,
    "ends": FLAG,
}
"""By name, or by function and name where it is another's, too."""


def take_model(model: Mapping) -> dict:
    """A model's name and options, converted; ValueError, one line, for one that cannot be."""
    name = _word(*OPTIONS).take("model.name", model.get("name"))
    taken = {"name": name}
    for key, value in model.items():
        if key in OPTIONS[name]:
            taken[key] = ARGUMENTS[f"model.{key}"].take(f"model.{key}", value)
        elif key != "name":
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: not an option of {name}; its options are {known}")
    return taken


def take_pulse(
    path: str, given: Mapping, needed: Sequence[str], others: Sequence[str] = ()
) -> dict[str, object]:
    """Convert a mapping of these keys to what a pulse may have; else ValueError, one line."""
    if not isinstance(given, Mapping) or not {*needed} <= {*given} <= {*needed, *others}:
        more = f"; it may have {', '.join(others)}" if others else ""
        raise ValueError(f"{path}: {show(given)} is not a mapping of {', '.join(needed)}{more}")
    taken = {key: ARGUMENTS[f"pulse.{key}"].take(f"{path}.{key}", given[key]) for key in given}
    shares = {key: taken[key] for key in SHARES if key in taken}
    if shares and taken.get("shape") != "trapezoid":
        raise ValueError(f"{path}.{next(iter(shares))}: is of a trapezoid alone; leave it out")
    if sum({"rise": TENTH, "fall": TENTH, **shares}.values()) > 1:
        raise ValueError(f"{path}.rise: with fall is more than the duration; write smaller shares")
    return taken

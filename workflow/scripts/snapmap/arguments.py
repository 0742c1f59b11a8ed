"""What each argument of a public function may be, in one line each, and calls held against it.

ARGUMENTS says of each name what would be right, in words with an example, and what fits; values of
the device, N, f0 and C take their units and ranges from `quantities.py`. Options of models are
held against it whether they come from Python or from a config.
"""

import functools
import inspect
import math
import reprlib
import warnings
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from numbers import Number, Real
from os import PathLike
from os.path import exists
from typing import NamedTuple, get_args

import numpy as np

from .config.plausible import implausible, unusual, wide
from .device import VALUES, Device, batch
from .pulse import DIRECTIONS, SHAPES, Pulse
from .quantities import QUANTITIES, Range, range_of
from .tolerances.samples import OF_DEVICE, SHOCK_FACTORS, Plan

LONGEST = 60
"""Characters of a value in a message."""
MOST_CELLS = 10**8
"""Of one call; those of a config go to files, slab by slab."""
OF_ELEMENTS = ("elements", "mass_matrix", "step", "scheme", "modes")
OPTIONS = {
    "reference": OF_ELEMENTS[:3],
    **dict.fromkeys(("handout", "elements"), OF_ELEMENTS),
    "cosines": ("cosines", "modes", "scheme", "step"),
    "auto": ("tolerance",),
}
"""Of each model."""


class Argument(NamedTuple):
    """need: what would be right, as it follows "is not"; fits: whether a value is."""

    need: str
    fits: Callable[[object], bool]

    def require(self, name: str, value: object) -> None:
        """Raise ValueError, one line, for a value that does not fit."""
        if not self.fits(value):
            raise ValueError(f"{name}: {show(value)} is not {self.need}")


def show(value: object) -> str:
    """Quote a value in one short line."""
    if not isinstance(value, str | bytes | Number | list | tuple | dict | None):
        name = type(value).__name__
        return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
    try:
        text = reprlib.repr(value.item() if isinstance(value, np.generic) else value)
    except ValueError:  # an int of more than 4300 digits
        return "a number of thousands of digits"
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]}...{text[-1]}"


def _numbers(value):
    """The numbers in a value, as an array of floats of its shape; None where there are others."""
    if isinstance(value, str | bytes | bool | Mapping):
        return None
    try:
        found = np.asarray(value)
        return found.astype(float) if found.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def _is_real(value):
    return isinstance(value, Real | np.generic | np.ndarray) and np.ndim(value) == 0


def _number(within: Range, unit: str = "", example: str = "") -> Argument:
    def fits(value):
        found = _numbers(value)
        return found is not None and found.ndim == 0 and bool(within.holds(found))

    return Argument(_words("a number", within, unit, example), fits)


def _row(within: Range, unit: str, example: str) -> Argument:
    def fits(value):
        found = _numbers(value)
        if found is None or found.ndim > 1 or not found.size or not within.holds(found).all():
            return False
        return np.unique(found).size == found.size

    return Argument(_words("a number or several, each once,", within, unit, example), fits)


def _words(what, within, unit, example):
    words = " ".join(filter(None, (what, str(within), unit and f"in {unit}")))
    return f"{words}, such as {example}" if example else words


def _whole(low: int, high: float = math.inf) -> Argument:
    number = _number(Range(low, high, low_fits=True, high_fits=high < math.inf))

    def fits(value):
        return number.fits(value) and value == int(value)

    return Argument(f"a whole {number.need.removeprefix('a ')}", fits)


def _pairs(units: str, example: str) -> Argument:
    def fits(value):
        found = _numbers(value)
        if found is None or found.ndim != 2 or found.shape[1] != 2 or len(found) < 2:
            return False
        positive = np.isfinite(found).all() and (found > 0).all()
        return bool(positive and (np.diff(found[:, 0]) > 0).all())

    return Argument(f"two pairs or more of {units}, above 0 and ascending, such as {example}", fits)


def _word(*words: str) -> Argument:
    need = f"one of {', '.join(words)}"
    return Argument(need, lambda value: isinstance(value, str) and value in words)


def _of_type(need: str, *types: type) -> Argument:
    return Argument(need, lambda value: isinstance(value, types))


def _dataset(need: str, *variables: str) -> Argument:
    """By its attributes: xarray is imported by those alone who make one."""
    return Argument(
        need, lambda value: hasattr(value, "data_vars") and all(key in value for key in variables)
    )


def _is_pair(value):
    found = _numbers(value)
    return found is not None and found.shape == (2,) and bool(np.isfinite(found).all())


def _is_prior(value):
    return THRESHOLDS.fits(value) or hasattr(value, "data_vars") or _is_pair(value)


def _is_pulse(value):
    if isinstance(value, str):
        return value in SHAPES
    return isinstance(value, Pulse) or (
        isinstance(value, Mapping | list | tuple) and len(value) > 0
    )


def _is_path(value):
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


def _is_table(value):
    named = hasattr(value, "keys") and [value[key] for key in value]
    return isinstance(named, list) and all(
        hasattr(column, "__len__") and not isinstance(column, str) for column in named
    )


def _mapping_of(need: str, *keys: str) -> Argument:
    def fits(value):
        return isinstance(value, Mapping) and len(value) > 0 and all(key in keys for key in value)

    return Argument(f"a mapping of {need}", fits)


def _are_directions(value):
    if isinstance(value, str):
        return value in (*DIRECTIONS, "both")
    named = isinstance(value, list | tuple) and all(isinstance(one, str) for one in value)
    return bool(named and value and {*value} <= {*DIRECTIONS} and len({*value}) == len(value))


def _are_devices(value):
    named = value.values() if isinstance(value, Mapping) and value else [value]
    return all(isinstance(one, Device) for one in named)


def _are_requirements(value):
    return isinstance(value, list | tuple) and all(
        isinstance(one, Mapping)
        and {"name", "N", "f0", "snaps"} <= one.keys()
        and POSITIVE.fits(one["N"])
        and POSITIVE.fits(one["f0"])
        and isinstance(one["snaps"], bool | np.bool_)
        for one in value
    )


def _are_groups(value):
    return isinstance(value, list | tuple) and all(
        isinstance(group, list | tuple) and all(isinstance(key, str) for key in group)
        for group in value
    )


def _of_axis(key: str, example: str) -> dict[str, tuple]:
    quantity = QUANTITIES[key]
    return quantity.range, quantity.unit, example


POSITIVE = _number(range_of("(0, inf)"))
SHARE = _number(range_of("(0, 1)"), "", "0.95")
FLAG = _of_type("True or False", bool, np.bool_)
THRESHOLDS = _dataset("a Dataset of thresholds, as threshold returns it", "N_first")
PATH = Argument("the path of a file that is there", _is_path)
DEVICE = _of_type("a Device; load_device reads one", Device)
SHOCK = {
    "N": (range_of("[0, inf)"), "multiples of g", "1000"),
    "f0": _of_axis("f0", "1500"),
    "C": _of_axis("C", "25"),
}
SINGLE = {key: _number(*words) for key, words in SHOCK.items()}

ARGUMENTS = {
    "device": Argument("a Device, or several by name; load_device reads one", _are_devices),
    **dict.fromkeys(
        (f"{name}.device" for name in ("describe", "statics", "calibrate", "design", "simulate")),
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
    "model.tolerance": _number(range_of("(0, 1)"), "", "1e-3"),
    "model.elements": _whole(1),
    "model.cosines": _whole(1),
    "model.modes": _whole(1),
    "model.step": _number(range_of("(0, 1]"), "", "0.8"),
    "model.mass_matrix": _word("consistent", "hrz"),
    "model.scheme": _word("explicit", "conserving"),
    "horizon": _number(range_of("[0, inf)"), "us", "1500"),
    "energy_tolerance": _number(range_of("(0, 1)"), "", "1e-3"),
    "threads": _whole(1),
    "until": _word("settled", "snap"),
    "repeat": FLAG,
    "skip": FLAG,
    "pulse": Argument(f"one of {', '.join(SHAPES)}, nor what read_pulse gives", _is_pulse),
    "direction": Argument("+z, -z, both, or a list of these", _are_directions),
    **dict.fromkeys(
        (f"{name}.direction" for name in ("simulate", "srs_test", "design", "calibrate")),
        _word("+z", "-z"),
    ),
    "tolerance": _number(range_of("[1e-9, 0.01]"), "", "1e-4"),
    "tolerance.tolerance": _number(range_of("[1e-5, 0.01]"), "", "1e-3"),
    "highest": _number(range_of("(0, inf)"), "multiples of g", "2000"),
    "earlier": THRESHOLDS,
    "value": Argument(
        "the name of a value of the device, such as thickness",
        lambda value: isinstance(value, str) and value in VALUES,
    ),
    "between": Argument("a pair of numbers, low and high, such as (1.8, 2.2)", _is_pair),
    "requirements": Argument(
        "a list of mappings of name, N, f0 (Hz) and snaps (True or False)", _are_requirements
    ),
    "scatters": _mapping_of(
        'what can scatter to its width, such as {"thickness": "3 %"}', *OF_DEVICE, *SHOCK_FACTORS
    ),
    "together": Argument("a list of groups of names, as [[span, rise]]", _are_groups),
    "samples": _whole(2, 100_000),
    "index_samples": _whole(2, 100_000),
    "seed": _whole(0, 2**32 - 1),
    "psd": _pairs("Hz and g^2/Hz", "[(20, 0.04), (2000, 0.04)]"),
    "srs": _pairs("Hz and multiples of g", "[(500, 700), (2000, 1500)]"),
    "vibration.duration": _number(range_of("(0, inf)"), "s", "60"),
    "records": _whole(1, 100_000),
    "reach": _number(range_of("(0, 1)"), "", "0.01"),
    "shots": Argument(
        "the path of a file that is there, nor columns by name",
        lambda value: _is_table(value) or _is_path(value),
    ),
    "unknowns": _mapping_of(
        'values of the device, or C, to ranges, such as {"thickness": (1.7, 2.3)}', *VALUES, "C"
    ),
    "prior": Argument(
        "a mean and a standard deviation above 0, nor what tolerance returns", _is_prior
    ),
    "method": _word("neyer", "langlie", "up-and-down"),
    "confidence": SHARE,
    "reliability": SHARE,
    "failures": _whole(0),
    "cube": _dataset("a cube, as sweep and open_cube return it", "outcome"),
    "box": _whole(2),
    "path": PATH,
    "sha256": _of_type("the hexadecimal digits of a hash", str),
    "ax": Argument("Axes of matplotlib", lambda value: hasattr(value, "get_xlim")),
    "x": _of_type("the name of an axis of the cube", str),
    "y": _of_type("the name of an axis of the cube", str),
    "found": THRESHOLDS,
    "ends": FLAG,
    "studies": Argument(
        "a mapping of names to thresholds, as threshold returns them",
        lambda value: (
            isinstance(value, Mapping)
            and len(value) > 0
            and all(isinstance(k, str) and THRESHOLDS.fits(one) for k, one in value.items())
        ),
    ),
}
"""By name, or by function and name where it is another's, too."""
RUN = ("horizon", "energy_tolerance", "threads")
MADE = ("samples", "index_samples", "seed", "together", "requirements")
TAKEN = {
    "calibrate": (*RUN, "pulse", "direction"),
    "design": (*RUN, *MADE, "scatters", "pulse", "direction", *VALUES),
    "simulate": ("horizon", "energy_tolerance", "until", "pulse", "direction"),
    "srs_test": (*RUN, "direction", "skip", *VALUES),
    "sweep": (*RUN, "until", "repeat", "pulse", "direction", "skip", *VALUES),
    "threshold": (*RUN, "pulse", "direction", "skip", *VALUES),
    "tolerance": (*RUN, *MADE, "pulse", "direction"),
    "vibration": ("energy_tolerance", "threads", "reach", "skip", *VALUES),
}
"""Options of each function, beside those of the model."""


def checked(function: Callable) -> Callable:
    """The function, with each call held against ARGUMENTS; ValueError or TypeError, one line."""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def door(*given, **named):
        values = _bound(function.__name__, signature, given, named)
        for line in _doubts(values):
            warnings.warn(line, stacklevel=2)
        return function(*given, **named)

    door.__module__ = __package__  # by which it is pickled
    return door


def require_model(model: Mapping) -> None:
    """Raise ValueError, one line, for a model's name or an option that cannot be."""
    name = model.get("name")
    _word(*OPTIONS).require("model.name", name)
    for key, value in model.items():
        if key in OPTIONS[name]:
            ARGUMENTS[f"model.{key}"].require(f"model.{key}", value)
        elif key != "name":
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: not an option of {name}; its options are {known}")


def _bound(function, signature, given, named):
    """All arguments of a call by name, with its options; each fits."""
    parameters = {key: one for key, one in signature.parameters.items() if key != "options"}
    if len(given) > len(parameters):
        raise TypeError(f"{function}: takes {len(parameters)} arguments, not {len(given)}")
    values = dict(zip(parameters, given, strict=False))
    if twice := [key for key in values if key in named]:
        raise TypeError(f"{twice[0]}: comes twice; write it once")
    values |= named
    for key, one in parameters.items():
        own = ARGUMENTS.get(f"{function}.{key}") or ARGUMENTS[key]
        if key not in values:
            if one.default is one.empty:
                raise TypeError(f"{key}: missing; write {own.need}")
        elif values[key] is not one.default and not (
            values[key] is None and type(None) in get_args(one.annotation)
        ):
            own.require(key, values[key])
    options = {key: value for key, value in values.items() if key not in parameters}
    if "model" in parameters:
        model = values.get("model", parameters["model"].default)
        model = {"name": model} if isinstance(model, str) else model
        of_model = OPTIONS.get(model.get("name"), ())
        require_model(model | {key: options[key] for key in options if key in of_model})
        options = {key: value for key, value in options.items() if key not in of_model}
    for key, value in options.items():
        if key not in TAKEN.get(function, ()):
            raise ValueError(f"{key}: is no option{_hint(function, key, parameters)}")
        (ARGUMENTS.get(f"{function}.{key}") or ARGUMENTS[key]).require(key, value)
    if function == "sweep":
        sizes = [np.size(value) for key, value in values.items() if key in (*VALUES, *SHOCK)]
        if math.prod(sizes) > MOST_CELLS:
            raise ValueError(
                f"N: {math.prod(sizes):.3g} cells with f0, C and all axes, more than "
                f"{MOST_CELLS:.0e}; write fewer, or a config"
            )
    return values


def _hint(function, key, parameters):
    """What was meant by an option that is none."""
    if key in VALUES:
        return f" of {function}; vary the device"
    of_models = [option for options in OPTIONS.values() for option in options]
    if key in of_models:
        return " of this model; write another model"
    known = [*parameters, *TAKEN.get(function, ()), *(of_models if "model" in parameters else ())]
    near = get_close_matches(key, known, 1, 0.75)
    return f"; did you mean {near[0]}?" if near else f" of {function}"


def _doubts(values):
    """Lines on values that are hardly meant."""
    device = values.get("device")
    named = device if isinstance(device, Mapping) else {} if device is None else {"": device}
    for one in named.values():
        whole = batch([one])
        C, f0 = (values.get(key) for key in ("C", "f0"))
        if C is None or f0 is None:
            yield from unusual(whole)
        else:
            ascending = (np.sort(np.atleast_1d(np.asarray(v, float))) for v in (C, f0))
            yield from implausible(whole, *ascending)
        if "scatters" in values:
            yield from wide(Plan(one, values["scatters"], values.get("together", ())))

"""The door: calls of the public functions, held against what `arguments.py` says."""

import functools
import inspect
import math
import warnings
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import get_args

import numpy as np

from .applications import functions
from .arguments import ARGUMENTS, SHOCK
from .config.plausible import implausible, unusual, wide
from .device.device import VALUES, batch
from .device.samples import Plan
from .solver.options import OPTIONS, take_model

MOST_CELLS = 10**8
"""Of one call; those of a config go to files, slab by slab."""
RUN = ("horizon", "energy_tolerance", "threads")
MADE = ("samples", "index_samples", "seed", "together", "requirements")
TAKEN = {
    "calibrate": (*RUN, "pulse", "direction"),
    "design": (*RUN, "requirements", "start", "pulse", "direction"),
    "simulate": ("horizon", "energy_tolerance", "until", "start", "pulse", "direction"),
    "srs_test": (*RUN, "direction", "skip", *VALUES),
    "sweep": (*RUN, "start", "until", "repeat", "pulse", "direction", "skip", *VALUES),
    "threshold": (*RUN, "start", "pulse", "direction", "skip", *VALUES),
    "tolerance": (*RUN, *MADE, "start", "pulse", "direction"),
    "vibration": ("energy_tolerance", "threads", "reach", "skip", *VALUES),
}
"""Options of each function, beside those of the model."""


OF_LAWS = ("simulate", "sweep", "threshold")
"""Functions that follow a model with a user's own laws, of which no energy is known."""


def checked(function: Callable) -> Callable:
    """The function, with each call held against ARGUMENTS; ValueError or TypeError, one line."""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def door(*positional, **named):
        values = _bound(function.__name__, signature, positional, named)
        for line in _doubts(values):
            warnings.warn(line, stacklevel=2)
        if function.__name__ == "sweep":
            values["observers"] = functions("observe")
        return function(**values)

    door.__module__ = __package__  # by which it is pickled
    return door


def _bound(function, signature, positional, named):
    """Convert all arguments of a call, by name, with its options; each fits."""
    parameters = {**signature.parameters}
    parameters.pop("options", None)
    if len(positional) > len(parameters):
        raise TypeError(f"{function}: takes {len(parameters)} arguments, not {len(positional)}")
    values = dict(zip(parameters, positional, strict=False))
    if twice := [key for key in values if key in named]:
        raise TypeError(f"{twice[0]}: comes twice; write it once")
    values |= named
    for key, parameter in parameters.items():
        argument = _argument(function, key)
        if key not in values and parameter.default is parameter.empty:
            raise TypeError(f"{key}: missing; write {argument.need}")
        value = values.get(key, parameter.default)
        if value is not parameter.default and (
            value is not None or type(None) not in get_args(parameter.annotation)
        ):
            values[key] = argument.take(key, value)
    options = [key for key in values if key not in parameters]
    if "model" in parameters:
        model = values.get("model", parameters["model"].default)
        model = take_model({"name": model} if isinstance(model, str) else model)
        of_model = [key for key in options if key in OPTIONS[model["name"]]]
        values["model"] = take_model(model | {key: values.pop(key) for key in of_model})
        options = [key for key in options if key not in of_model]
        if "laws" in values["model"] and function not in OF_LAWS:
            raise ValueError(f"model.laws: are for {', '.join(OF_LAWS)}; write another model")
    for key in options:
        if key not in TAKEN.get(function, ()):
            raise ValueError(f"{key}: is no option{_hint(function, key, parameters)}")
        values[key] = _argument(function, key).take(key, values[key])
    if function == "sweep":
        sizes = [np.size(value) for key, value in values.items() if key in (*VALUES, *SHOCK)]
        if math.prod(sizes) > MOST_CELLS:
            raise ValueError(
                f"N: {math.prod(sizes):.3g} cells with f0, C and all axes, more than "
                f"{MOST_CELLS:.0e}; write fewer, or a config"
            )
    return values


def _argument(function, key):
    """The description of an argument of a function."""
    return ARGUMENTS.get(f"{function}.{key}") or ARGUMENTS[key]


def _hint(function, key, parameters):
    """Say what was meant by an option that is none."""
    if key in VALUES:
        return f" of {function}; vary the device"
    of_models = [option for options in OPTIONS.values() for option in options]
    if key in of_models:
        return " of this model; write another model"
    known = [*parameters, *TAKEN.get(function, ()), *(of_models if "model" in parameters else ())]
    near = get_close_matches(key, known, 1, 0.8)
    return f"; did you mean {near[0]}?" if near else f" of {function}"


def _doubts(values):
    """Lines on values that are hardly meant."""
    device, laws = values.get("device"), values.get("model", {}).get("laws")
    named = device if isinstance(device, Mapping) else {} if device is None else {"": device}
    for single in named.values():
        alone = batch([single])
        C, f0 = (values.get(key) for key in ("C", "f0"))
        if C is None or f0 is None or laws:  # of a law's C the unit is its own
            yield from unusual(alone)
        else:
            ascending = (np.sort(np.atleast_1d(np.asarray(v, float))) for v in (C, f0))
            yield from implausible(alone, *ascending)
        if "scatters" in values:
            yield from wide(Plan(single, values["scatters"], values.get("together", ())))

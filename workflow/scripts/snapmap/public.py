"""Calls of the public functions are checked against the types of their signatures."""

import functools
import inspect
import warnings
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from difflib import get_close_matches
from typing import get_args

import numpy as np

from .applications import observers
from .config.plausible import OF_RUNS, implausible, unusual, unusual_runs, wide
from .device.argument import Argument, argument_of
from .device.device import VALUES, batch
from .device.samples import Plan
from .files.counting import counting
from .solver.laws import laws_of
from .solver.options import OF_MODEL, OPTIONS, take_model

OF_LAWS = ("simulate", "sweep", "threshold")
"""Functions that follow a user's own laws; `simulate` needs a motion, which solvers do not give."""


def checked(function: Callable) -> Callable:
    """Wrap a function so that each call is checked; ValueError or TypeError, one line."""
    parameters, options = {**inspect.signature(function).parameters}, options_of(function)
    parameters.pop("options", None)

    @functools.wraps(function)
    def call(*positional, **named):
        values = _checked_arguments(function.__name__, parameters, options, positional, named)
        for line in _doubts(values):
            warnings.warn(line, stacklevel=2)
        if function.__name__ == "sweep":
            values["observers"] = observers()
        # Functions with a model follow cells, which are counted.
        with counting(function.__name__) if "model" in parameters else nullcontext():
            return function(**values)

    call.__module__ = __package__  # by which it is pickled
    return call


def options_of(function: Callable) -> dict[str, Argument]:
    """Give the options of a function by name, without those of the model."""
    options = inspect.signature(function).parameters.get("options")
    (named,) = get_args(options.annotation) if options else [None]
    kinds = named.__annotations__.items() if named else ()
    return {key: argument_of(kind) for key, kind in kinds if key not in OF_MODEL}


def _checked_arguments(function, parameters, of_function, positional, named):
    """Check and convert all arguments and options of a call; returns them by name."""
    if len(positional) > len(parameters):
        raise TypeError(f"{function}: takes {len(parameters)} arguments, not {len(positional)}")
    values = dict(zip(parameters, positional, strict=False))
    if twice := [key for key in values if key in named]:
        raise TypeError(f"{twice[0]}: comes twice; write it once")
    values |= named
    for key, parameter in parameters.items():
        argument = argument_of(parameter.annotation)
        may_be_none = type(None) in get_args(parameter.annotation)
        if key not in values and parameter.default is parameter.empty:
            raise TypeError(f"{key}: missing; write {argument.need}")
        if key in values and not (may_be_none and values[key] is None):
            values[key] = argument.take(key, values[key])
    options = [key for key in values if key not in parameters]
    if "model" in parameters:
        model = values.get("model", parameters["model"].default)
        model = take_model({"name": model} if isinstance(model, str) else model)
        of_model = [key for key in options if key in OPTIONS[model["name"]]]
        values["model"] = take_model(model | {key: values.pop(key) for key in of_model})
        options = [key for key in options if key not in of_model]
        laws = laws_of(values["model"])
        names = OF_LAWS[1:] if laws and laws.solver else OF_LAWS
        if laws and function not in names:
            raise ValueError(f"model.laws: work only with {', '.join(names)}; leave them out")
    for key in options:
        if key not in of_function:
            known = [*parameters, *of_function, *(OF_MODEL if "model" in parameters else ())]
            raise ValueError(f"{key}: is not an option{_hint(function, key, known)}")
        values[key] = of_function[key].take(key, values[key])
    return values


def _hint(function, key, known):
    """Say what an unknown option may mean."""
    if key in VALUES:
        return f" of {function}; vary the device"
    if key in OF_MODEL:
        models = " or ".join(name for name, options in OPTIONS.items() if key in options)
        return f" of this model; write the model {models}"
    near = get_close_matches(key, known, 3, 0.8)
    near.sort(key=lambda word: sorted(word) != sorted(key))  # two letters that changed places
    return f"; did you mean {near[0]}?" if near else f" of {function}"


def _doubts(values):
    """Give lines on values that are hardly meant."""
    device, laws = values.get("device"), values.get("model", {}).get("laws")
    named = device if isinstance(device, Mapping) else {} if device is None else {"": device}
    yield from unusual_runs(**{key: values[key] for key in OF_RUNS if values.get(key) is not None})
    for single in named.values():
        alone = batch([single])
        C, f0 = (values.get(key) for key in ("C", "f0"))
        if C is None or f0 is None:
            yield from unusual(alone)
        else:
            C, f0 = (np.sort(np.atleast_1d(np.asarray(v, float))) for v in (C, f0))
            yield from implausible(alone, None if laws else C, f0)
        if "scatters" in values:
            yield from wide(Plan(single, values["scatters"], values.get("together", ())))

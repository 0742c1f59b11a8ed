"""The door: calls of the public functions are checked, doubted and counted."""

import functools
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import fields
from typing import Any

import numpy as np

from .applications import observers
from .config.plausible import implausible, unusual, unusual_runs, wide
from .device.device import VALUES, batch
from .device.samples import Plan
from .files.counting import counting
from .solver.options import MODELS
from .solver.settings import FIRST
from .study.axes import frequencies
from .study.study import Study
from .values.arguments import Reading, by_name, convert, one_time
from .values.faults import Faults, WrongCall, warn
from .values.kinds import argument_of
from .values.records import shown
from .values.units import OF_DAMPER

ELSEWHERE = {
    **{key: f"; write it as axes={{'{key}': ...}}" for key in VALUES},
    **{
        field.name: f"; write Study(device, model={{'name': '{name}', '{field.name}': ...}})"
        for name, made in MODELS.items()
        for field in fields(made)
        if field.name != "name"
    },
    **{f.name: f"; write Study(device, {f.name}=...)" for f in fields(Study)},
}
"""Where a value belongs that a function does not take, by its name."""


def checked(function: Callable) -> Callable:
    """Wrap a public function so that its arguments are converted by their kinds.

    A wrong call raises WrongCall, a line for each argument that is wrong, missing or too many.
    """
    if function.__name__ == "sweep":
        function = _with_observers(function)
    signature = inspect.signature(function)
    parameters, at_home = signature.parameters, _at_home(function)
    arguments = {
        key: argument_of(part.annotation, part.default is not part.empty)
        for key, part in parameters.items()
    }

    @functools.wraps(function)
    def call(*positional: Any, **named: Any) -> Any:
        given, faults = by_name(function.__name__, parameters, positional, named)
        faults |= _one_time(arguments, given)
        reading = Reading(unit_of_C=_unit_of_C(given))
        try:
            values = convert(arguments, given, reading, faults, "is not an argument", ELSEWHERE)
        except Faults as error:
            raise WrongCall(*error.args) from None
        with _prepare(function, values):
            return at_home(**values)

    call.__signature__ = shown(signature, arguments)
    call.__module__ = __package__  # by which it is pickled
    return call


def _one_time(arguments, given):
    """Let f0 be left out beside a duration, which excludes it; returns lines by name."""
    if not {"f0", "duration"} <= arguments.keys():
        return {}
    written = {key for key in given if given[key] is not None}
    faults = one_time(written, lasts_itself="f0" in given or arguments["f0"].is_optional)
    if "duration" in given:
        given.setdefault("f0")
    return faults


def _at_home(function):
    """Let a function run under numpy's and xarray's own settings, whatever its caller's are."""

    @functools.wraps(function)
    def call(**values):
        xarray = sys.modules.get("xarray")
        own = {"keep_attrs": "default", "arithmetic_join": "inner"}
        settings = xarray.set_options(**own) if xarray else nullcontext()
        with settings, np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
            return function(**values)

    return call


def _with_observers(sweep):
    @functools.wraps(sweep)
    def observed(**values):
        return sweep(**values, observers=observers())

    signature = inspect.signature(sweep)
    kept = [part for key, part in signature.parameters.items() if key != "observers"]
    observed.__signature__ = signature.replace(parameters=kept)
    return observed


def _unit_of_C(values):
    """Give the unit in which the study of a call counts C."""
    study = values.get("study")
    return study.unit_of_C if isinstance(study, Study) else OF_DAMPER


@contextmanager
def _prepare(function: Callable, values: Mapping) -> Iterator[None]:
    """Warn of values that are hardly meant, then count the cells of the block."""
    study = values.get("study")
    if study is None:
        yield
        return
    for line in _doubts(study, values):
        warn(line)
    with counting(function.__name__):
        yield


def _doubts(study, values):
    """Give lines on values that are hardly meant."""
    N = values.get("N")
    yield from unusual_runs(horizon=study.horizon, **({} if N is None else {"N": N}))
    yield from study.shocks.doubts(is_pressed=study.start == FIRST)
    C, f0 = values.get("C"), None
    if "f0" in values:
        f0 = frequencies(values["f0"], values.get("duration"))
    for single in study.devices().values():
        alone = batch([single])
        if C is None or f0 is None:
            yield from unusual(alone)
        else:
            C, f0 = (np.sort(np.atleast_1d(np.asarray(row, float))) for row in (C, f0))
            swings = max(pulse.swings for pulse in study.shocks.pulses)
            yield from implausible(alone, None if study.model.laws else C, f0, swings)
        if "scatters" in values:
            yield from wide(Plan(single, values["scatters"], values.get("together", ())))

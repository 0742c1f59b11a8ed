"""Calls of functions, held to the kinds of their signatures."""

import functools
import inspect
import re
from collections.abc import Callable, Mapping
from types import NoneType
from typing import Any, get_args

from .arguments import Argument, Reading, by_name, convert, one_time
from .faults import Faults, WrongCall
from .kinds import argument_of

FOLDERS = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z]|ndarray)")
"""The module before a type's name."""


def checked(
    function: Callable, elsewhere: Mapping[str, str], prepare: Callable, unit_of_C: Callable
) -> Callable:
    """Wrap a function so that its arguments are converted by their kinds.

    elsewhere: where a value that the function does not take belongs, by its name
    prepare: takes function and arguments by name, and gives a context in which the function runs
    unit_of_C: takes the arguments by name as they are, and gives the unit in which C counts
    A wrong call raises WrongCall, a line for each argument that is wrong, missing or too many.
    """
    signature = inspect.signature(function)
    parameters = signature.parameters
    arguments = {
        key: argument_of(part.annotation, part.default is not part.empty)
        for key, part in parameters.items()
    }
    unknown = "is not an argument"

    @functools.wraps(function)
    def call(*positional: Any, **named: Any) -> Any:
        given, faults = by_name(function.__name__, parameters, positional, named)
        faults |= _one_time(arguments, given)
        reading = Reading(unit_of_C=unit_of_C(given))
        try:
            values = convert(arguments, given, reading, faults, unknown, elsewhere)
        except Faults as error:
            raise WrongCall(*error.args) from None
        with prepare(function, values):
            return function(**values)

    call.__signature__ = shown(signature, arguments)
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


class _Words(str):
    """Words that a signature shows as they are."""

    __repr__ = str.__str__


def shown(signature: inspect.Signature, arguments: Mapping[str, Argument]) -> inspect.Signature:
    """Give a signature whose types are those that a reader knows."""
    parameters = [
        part.replace(annotation=_typed(part.annotation, arguments[key].kind))
        for key, part in signature.parameters.items()
    ]
    returned = _typed(signature.return_annotation, None)
    return signature.replace(parameters=parameters, return_annotation=returned)


def _typed(hint, kind):
    """Name the type of an annotation."""
    noted = next((p for p in (hint, *get_args(hint)) if hasattr(p, "__metadata__")), None)
    if noted:
        own = noted.__origin__
        shown = kind.type if own is Any else own
        hint = shown | None if NoneType in get_args(hint) else shown
    return _Words(FOLDERS.sub("", inspect.formatannotation(hint)))

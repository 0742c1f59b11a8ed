"""Calls of functions, held to the kinds of their signatures."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from .arguments import Reading, by_name, convert
from .faults import Faults, WrongCall
from .kinds import argument_of


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
        reading = Reading(unit_of_C=unit_of_C(given))
        try:
            values = convert(arguments, given, reading, faults, unknown, elsewhere)
        except Faults as error:
            raise WrongCall(*error.args) from None
        with prepare(function, values):
            return function(**values)

    plain = [part.replace(annotation=_plain(part, arguments)) for part in parameters.values()]
    call.__signature__ = signature.replace(parameters=plain)
    return call


def _plain(part, arguments):
    """Give the type of an argument, as a reader knows it."""
    argument = arguments[part.name]
    plain = argument.kind.type
    return plain | None if argument.may_be_none else plain

"""Calls of functions, held to the kinds of their signatures."""

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, get_args

from .faults import Faults, line_at
from .fields import taken
from .kinds import kind_of


def checked(
    function: Callable, elsewhere: Mapping[str, str], prepare: Callable, around: Callable
) -> Callable:
    """Wrap a function so that its arguments are converted by their kinds.

    elsewhere: where a value that the function does not take belongs, by its name
    prepare: takes function and arguments by name, and gives a context in which the function runs
    around: takes the arguments as they are, and gives a context for their conversion, too
    A call raises TypeError for arguments that are missing or too many, and ValueError for wrong
    ones; a line for each.
    """
    parameters = inspect.signature(function).parameters
    converters = {key: taking(parameter.annotation) for key, parameter in parameters.items()}

    @functools.wraps(function)
    def call(*positional: Any, **named: Any) -> Any:
        values, faults = by_name(function.__name__, parameters, positional, named, elsewhere)
        if faults:
            raise TypeError("\n".join(faults))
        with around(values):
            convert(values, converters)
            with prepare(function, values):
                return function(**values)

    return call


def taking(hint: object) -> Callable | None:
    """Give what converts a value of Python by the kind of an annotation; None if that has none."""
    kind = kind_of(hint)
    return kind and optional(kind.take, hint)


def optional(converter: Callable, hint: object) -> Callable:
    """Let None through a converter if an annotation does."""
    if type(None) not in get_args(hint):
        return converter
    return lambda value: None if value is None else converter(value)


def convert(
    values: dict[str, Any], converters: Mapping[str, Callable | None], faults: Sequence[str] = ()
) -> None:
    """Convert values in place, by name; raises Faults, a line for each, behind those known."""
    faults = [*faults]
    for key, converter in converters.items():
        if converter and key in values:
            try:
                values[key] = converter(values[key])
            except ValueError as error:
                faults += [line_at((key,), line) for line in str(error).splitlines()]
    if faults:
        raise Faults(*faults)


def by_name(
    function: str,
    parameters: Mapping[str, inspect.Parameter],
    positional: Sequence,
    named: Mapping[str, Any],
    elsewhere: Mapping[str, str],
) -> tuple[dict[str, Any], list[str]]:
    """Give the arguments of a call by name, and lines on those that are missing or too many."""
    first = [key for key, part in parameters.items() if part.kind is not part.KEYWORD_ONLY]
    faults = []
    if len(positional) > len(first):
        faults = [f"{function}: takes {len(first)} arguments without a name, not {len(positional)}"]
    values = dict(zip(first, positional, strict=False))
    faults += [f"{key}: comes twice; write it once" for key in values if key in named]
    for key in named:
        if key not in parameters:
            near = get_close_matches(key, [*parameters, *elsewhere], 3, 0.8)
            near.sort(key=lambda word: sorted(word) != sorted(key))  # two letters changed places
            hint = f"; did you mean {near[0]}?" if near else f" of {function}"
            faults.append(f"{key}: is not an argument{elsewhere.get(key, hint)}")
    for key, part in parameters.items():
        if part.default is part.empty and key not in values and key not in named:
            faults.append(f"{key}: missing; write {taken(part.annotation)}")
    return values | named, faults

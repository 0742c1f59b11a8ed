"""Records: frozen dataclasses whose fields have kinds. A record is a section of a config, too.

    @record
    class Run:
        horizon: Duration = 1500.0
        '''time followed after the pulse's end'''

`Run(horizon=500.0)` and `Run(horizon="0.5 ms")` convert their values by the kinds, `read(Run,
section)` reads a section of a config, `schema(Run)` describes it to an editor, and `rows(Run)` to
docs/config.md.
"""

import functools
import inspect
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache, partial
from typing import Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from typing_extensions import dataclass_transform

from ..files.text import show
from .calls import by_name, convert, optional, taking
from .described import Docstring, described
from .faults import Faults, within
from .fields import beside, hints, record_in
from .kinds import Word
from .reading import explained

Made = TypeVar("Made")


@dataclass_transform(frozen_default=True)
def record(made: type[Made]) -> type[Made]:
    """Make a frozen dataclass whose values are converted by their kinds.

    Its method `beside(written)` may give lines, by key, on values that lack or exclude each other;
    written: those that are there, by key. Its `__post_init__` may raise ValueError, `key: ...`.
    """
    made.__repr__ = _write
    made.__pydantic_config__ = {"extra": "forbid"}
    made.__get_pydantic_core_schema__ = classmethod(explained)
    made.__get_pydantic_json_schema__ = classmethod(described)
    words = made.__doc__  # not the signature that a dataclass has where python -OO has no words
    made = dataclass(frozen=True, repr=False)(made)
    made.__doc__ = Docstring(words)
    made.__init__ = _converting(made.__init__)
    return made


def _converting(initialize):
    """Wrap the `__init__` of a record, which pydantic does not call, to convert its values."""
    parameters = dict(inspect.signature(initialize).parameters)
    del parameters["self"]

    @functools.wraps(initialize)
    def __init__(self, *positional, **named):
        made = type(self)
        given, faults = by_name(made.__name__, parameters, positional, named, {})
        if faults:
            raise TypeError("\n".join(faults))
        faults = [f"{key}: {fault}" for key, fault in beside(made, given).items()]
        convert(given, _converters(made), faults)
        initialize(self, **given)

    return __init__


def _write(self):
    """Write what differs from the defaults, as Python reads it."""
    said = (f"{key}={value!r}" for key, value in told(self).items())
    return f"{type(self).__name__}({', '.join(said)})"


def _differs(value, default):
    return default is MISSING or (value is not default and np.any(value != default))


@cache
def _converters(made):
    """Give a function for each field that converts its value of Python, or None."""
    return {key: _converter(hint) for key, hint in hints(made).items()}


def _converter(hint):
    holder = record_in(hint)
    if get_origin(hint) is Literal:
        return Word(get_args(hint)).take
    return taking(hint) or (holder and optional(partial(build, holder), hint))


def build(made: type[Made], values: object) -> Made:
    """Make a record of a mapping of Python, or take one as it is.

    Raises Faults, lines that begin with `.key: `.
    """
    if isinstance(values, made):
        return values
    if not isinstance(values, Mapping):
        raise ValueError(f"{show(values)} is not a {made.__name__}, nor a mapping of its values")
    try:
        return made(**values)
    except (TypeError, ValueError) as error:
        raise Faults(*map(within, str(error).splitlines())) from None


def assemble(made: type[Made], values: Mapping) -> Made:
    """Make a record of values that have been converted, by the names of its fields."""
    whole = object.__new__(made)
    vars(whole).update(values)
    getattr(whole, "__post_init__", lambda: None)()
    return whole


def told(whole: object) -> dict[str, Any]:
    """Give the values of a record that differ from its defaults, by key, in the order written."""
    defaults = {field.name: field.default for field in fields(whole)}
    own = {key: value for key, value in vars(whole).items() if key in defaults}
    return {key: value for key, value in own.items() if _differs(value, defaults[key])}


def row_of_kinds(
    name: str, kinds: Mapping[str, tuple[object, str]], *above: type[Made]
) -> type[Made]:
    """Make a record whose optional fields have a type and a sentence each, by name.

    above: record whose fields it has, too
    """
    body = dict.fromkeys(kinds) | {
        "__annotations__": {key: hint | None for key, (hint, _) in kinds.items()},
        "sentences": {key: what for key, (_, what) in kinds.items()},
    }
    if above:
        body["__doc__"] = vars(above[0])["__doc__"].text
    return record(type(name, above, body))

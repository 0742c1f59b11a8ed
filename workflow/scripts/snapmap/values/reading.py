"""Sections of a config are read into records by pydantic; each fault is a line of its own."""

from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache, partial
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError
from pydantic_core.core_schema import with_info_wrap_validator_function

from ..files.text import describe
from .faults import LONGEST_KEY, Faults, few, line_at, within
from .fields import beside, hints, need_of
from .kinds import WRITTEN

MOST_KNOWN = 20
"""Most keys that a message lists in full; of more, it lists half as many, the nearest."""
Made = TypeVar("Made")
_fault = partial(PydanticCustomError, "fault", "{line}")


def explained(made: type, source: Any, handler: Any) -> Any:
    """Make the schema by which pydantic reads a section; each fault becomes a line of its own."""

    def explain(values, inner, info):
        faults = {}
        if isinstance(values, made):
            return values
        if isinstance(values, Mapping):
            for key, line in beside(made, values).items():
                faults[key if isinstance(key, tuple) else (key,)] = [line]
            empty = [key for key in values if key in hints(made) and values[key] is None]
            faults |= {(key,): _wrong(made, key, None) for key in empty}
            values = {key: value for key, value in values.items() if key not in empty}
        try:
            section = inner(values)
        except ValidationError as error:
            for detail in error.errors():
                if not (detail["loc"] in faults and detail["type"].startswith("missing")):
                    faults.setdefault(detail["loc"], []).extend(_lines(made, detail))
        if not faults:
            own = vars(section)
            written = {key: own.pop(key) for key in values if key in own}
            own |= written  # behind those that are not written
            return section
        errors = [
            {"type": _fault({"line": line}), "loc": path, "input": None}
            for path, lines in faults.items()
            for line in lines
        ]
        raise ValidationError.from_exception_data(made.__name__, errors)

    return with_info_wrap_validator_function(explain, handler(source))


def _lines(made, detail):
    """Write what is wrong with the value of a key, one line or more."""
    first, *inner = detail["loc"] or [None]
    match detail["type"]:
        case "fault":
            return [detail["msg"]]
        case "value_error":
            error = detail["ctx"]["error"]
            lines = error.args if isinstance(error, Faults) else [str(error)]
            return lines if detail["loc"] else [within(line) for line in lines]
        case "missing" | "missing_argument" if not inner:
            return [f"missing; write {need_of(hints(made)[first])}"]
        case "extra_forbidden" | "unexpected_keyword_argument" | "invalid_key":
            return [f"unknown key; known here are {_nearest(first, hints(made))}"]
    return _wrong(made, first, detail["input"])


def _wrong(made, key, value):
    need = need_of(hints(made)[key]) if key in hints(made) else need_of(made)
    return [f"{describe(value)} is not {need}"]


def _nearest(key, known):
    known = list(known)
    if len(known) <= MOST_KNOWN:
        return ", ".join(known)
    nearest = get_close_matches(str(key)[:LONGEST_KEY], known, MOST_KNOWN // 2, 0)
    return f"{', '.join(nearest)} and {len(known) - len(nearest)} others"


@cache
def adapter(made: type) -> TypeAdapter:
    """Give what reads and describes a record."""
    return TypeAdapter(made)


def read(made: type[Made], section: object, *at: str) -> Made:
    """Read a section of a config, at a path; raises Faults, a line for each."""
    try:
        return adapter(made).validate_python(section, context=WRITTEN)
    except ValidationError as error:
        raise Faults(*lines_of(error, *at)) from None


def read_part(made: type[Made], section: object) -> Made:
    """Read a section within another one, whose faults begin with `.key: `."""
    try:
        return read(made, section)
    except Faults as faults:
        raise Faults(*map(within, faults.args)) from None


def lines_of(error: ValidationError, *at: str | int) -> list[str]:
    """Write a line for each fault of a section, with the name of its key; at: path of the section.

    Of the items of a list at most MOST_ALIKE have a line each.
    """
    alike, lines = {}, []
    for number, fault in enumerate(error.errors()):
        path = (*at, *fault["loc"])
        of_list = _list_of(path)
        group = alike.setdefault(number if of_list == path else of_list, [])
        group.append(line_at(path, fault["msg"]))
    for faults in alike.values():
        lines += few(faults)
    return lines


def _list_of(path):
    """Give the path of the outermost list whose items, or items of items, end a path."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    return path


def schema(made: type) -> dict:
    """Describe a record in JSON Schema, for editors of YAML."""
    return adapter(made).json_schema()

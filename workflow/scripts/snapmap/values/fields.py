"""What the fields of a record are: their types, sentences, defaults and needs, for all who ask."""

import ast
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from itertools import pairwise
from math import inf
from textwrap import dedent
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from .kinds import Quantity, kind_of


@cache
def hints(made: type) -> dict[str, Any]:
    """Give the annotations of a record's fields."""
    found = get_type_hints(made, include_extras=True)
    return {field.name: found[field.name] for field in fields(made)}


def record_in(hint: object) -> type | None:
    """Find the record in an annotation, also of an optional value."""
    parts = (hint, *get_args(hint))
    return next((part for part in parts if isinstance(part, type) and is_dataclass(part)), None)


def beside(made: type, written: Mapping) -> dict[str, str]:
    """Find values that lack or exclude each other; returns lines by key."""
    if not hasattr(made, "beside"):
        return {}
    return made.beside({key: value for key, value in written.items() if value is not None})


def need_of(hint: object) -> str:
    """Say what is right for an annotation, in words that follow "is not" or "write"."""
    parts = (hint, *get_args(hint))
    if kind := kind_of(hint):
        return kind.asks
    if words := next((get_args(part) for part in parts if get_origin(part) is Literal), ()):
        return f"one of {', '.join(map(str, words))}"
    if str in parts:
        return "text"
    if holder := record_in(hint):
        words = re.split("[;\n]", summary(holder))[0].rstrip(".")
        return f"a mapping: {words[:1].lower()}{words[1:]}".removesuffix(": ")
    lists = [part for part in parts if get_origin(part) is list]
    return f"a list, each {need_of(get_args(lists[0])[0])}" if lists else "a mapping"


def taken(hint: object) -> str:
    """Say what Python takes for an annotation."""
    kind, holder = kind_of(hint), record_in(hint)
    return kind.need if kind else holder.__name__ if holder else need_of(hint)


def summary(made: type) -> str:
    """Give the first paragraph of a record's docstring; python -OO has none."""
    return inspect.cleandoc(vars(made)["__doc__"].text or "").partition("\n\n")[0]


@cache
def sentences(made: type) -> dict[str, str]:
    """Give the sentence of each field, as the source says it."""
    found = {}
    for part in filter(is_dataclass, reversed(made.__mro__)):
        found |= vars(part).get("sentences") or _written_in(part)
    return found


def _written_in(made):
    body = ast.parse(dedent(inspect.getsource(made))).body[0].body
    return {
        field.target.id: " ".join(said.value.value.split())
        for field, said in pairwise(body)
        if isinstance(field, ast.AnnAssign) and isinstance(said, ast.Expr)
    }


class Row(NamedTuple):
    """A row of a table of keys: what it is, what is right, what holds if it is left out.

    default: as a config has it; None if there is none that a config could have
    """

    key: str
    what: str
    need: str
    default: object
    required: bool


def rows(made: type) -> Iterator[Row]:
    """Yield a row for each key of a record."""
    instead = instead_of(made)
    for field in fields(made):
        hint = hints(made)[field.name]
        needed = field.default is MISSING or instead.get(field.name) == []
        what = sentences(made).get(field.name, "")
        yield Row(field.name, what, need_of(hint), _default(field.default, hint), needed)


def instead_of(made: type) -> dict[str, list[dict]]:
    """Find, for each key that an empty section misses, what can stand in its place."""
    written = []
    for key, hint in hints(made).items():
        kind = kind_of(hint)
        words = kind.words if isinstance(kind, Quantity) else ()
        written.append({key: words[0][0] if words else {}})
    return {
        key: [part for part in written if key not in {**part, **beside(made, part)}]
        for key in beside(made, {})
    }


def _default(default, hint):
    if not isinstance(default, str | int | float) or default in (inf, -inf):
        return None
    kind = kind_of(hint)
    return kind.write(default) if kind else default

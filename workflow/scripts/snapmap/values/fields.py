"""What the fields of a record are: their types, sentences, defaults and needs, for all who ask."""

import ast
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from itertools import pairwise
from math import inf
from textwrap import dedent
from typing import Any, NamedTuple, get_type_hints

from .kinds import Quantity, kind_of


@cache
def hints(made: type) -> dict[str, Any]:
    """Give the annotations of a record's fields."""
    found = get_type_hints(made, include_extras=True)
    return {field.name: found[field.name] for field in fields(made)}


def beside(made: type, written: Mapping) -> dict[str, str]:
    """Find values that lack or exclude each other; returns lines by key."""
    if not hasattr(made, "beside"):
        return {}
    return made.beside({key: value for key, value in written.items() if value is not None})


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
        kind = kind_of(hints(made)[field.name])
        needed = field.default is MISSING or instead.get(field.name) == []
        what, default = sentences(made).get(field.name, ""), None
        if isinstance(field.default, str | int | float) and field.default not in (inf, -inf):
            default = kind.write(field.default)
        yield Row(field.name, what, kind.asks, default, needed)


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


class Docstring:
    """The docstring of a record, with its fields as parameters once someone reads it."""

    def __init__(self, text):
        """Take the text of the class."""
        self.text = text

    def __get__(self, whole, made):
        """Write it in the form of numpydoc."""
        if not self.text:
            return None
        text, heading, examples = inspect.cleandoc(self.text).partition("\n\nExamples\n")
        lines = [text, "", "Parameters", "----------"]
        told = {row.key: row for row in rows(made)}
        for key in inspect.signature(made).parameters:
            default = told[key].default
            said = "" if default is None else f", default {default}"
            lines += [f"{key} : {kind_of(hints(made)[key]).need}{said}", f"    {told[key].what}"]
        return "\n".join(lines) + heading + examples

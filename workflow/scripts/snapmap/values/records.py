"""Records: frozen dataclasses whose fields have kinds. A record is a section of a config, too.

    @record
    class Run:
        horizon: Duration = 1500.0
        '''time followed after the pulse's end'''

`Run(horizon=500.0)` and `Run(horizon="0.5 ms")` convert their values by the kinds, `read(Run,
section)` reads a section of a config, and `kind_of(Run).schema()` describes it to an editor.
"""

import ast
import functools
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from itertools import pairwise
from math import inf
from textwrap import dedent
from types import NoneType
from typing import Any, NamedTuple, TypeVar, dataclass_transform, get_args, get_type_hints

import numpy as np

from ..files.text import show
from .arguments import PYTHON, Argument, Reading, by_name, convert, lines_of
from .faults import Faults, WrongCall, line_at, within
from .kinds import Kind, Quantity, argument_of, kind_of


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


Made = TypeVar("Made")
FOLDERS = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z]|ndarray)")
"""The module before a type's name."""


@dataclass_transform(frozen_default=True)
def record(made: type[Made]) -> type[Made]:
    """Make a frozen dataclass whose values are converted by their kinds.

    Its method `beside(written)` may give lines, by key, on values that lack or exclude each other;
    written: those that are there, by key. Its `__post_init__` may raise ValueError, `key: ...`. Its
    `elsewhere` may say, by key, where a key belongs that it does not have.
    """
    made.__repr__ = _write
    words = made.__doc__  # not the signature that a dataclass has where python -OO has no words
    made = dataclass(frozen=True, repr=False)(made)
    made.__doc__ = Docstring(words)
    made.kind_of_record = RecordKind(made)
    made.__signature__ = _Signature(inspect.signature(made.__init__))
    made.__init__ = _converting(made.__init__)
    return made


class _Signature:
    """The signature of a record, with types that a reader knows, once someone asks for it."""

    def __init__(self, signature):
        """Take that of `__init__`."""
        _, *parameters = signature.parameters.values()
        self.signature = signature.replace(parameters=parameters)

    def __get__(self, whole, made):
        """Name the types."""
        return shown(self.signature, made.kind_of_record.arguments)


def _converting(initialize):
    """Make the `__init__` of a record, which converts its values."""
    parameters = dict(inspect.signature(initialize).parameters)
    del parameters["self"]

    @functools.wraps(initialize)
    def __init__(self, *positional, **named):
        kind = type(self).kind_of_record
        given, faults = by_name(type(self).__name__, parameters, positional, named)
        try:
            values = kind.values(given, PYTHON, faults, "is not an argument")
        except Faults as error:
            raise WrongCall(*error.args) from None
        _fill(self, values)

    return __init__


def _fill(whole, values):
    """Set the values of a record, those that are not written before the others."""
    defaults = type(whole).kind_of_record.defaults
    vars(whole).update({k: v for k, v in defaults.items() if k not in values} | values)
    getattr(whole, "__post_init__", bool)()
    return whole


def assemble(made: type[Made], values: Mapping) -> Made:
    """Make a record of values that have been converted, by the names of its fields."""
    return _fill(object.__new__(made), values)


class RecordKind(Kind):
    """A record: of a mapping of its values, or as it is."""

    unknown = "unknown key"

    def __init__(self, made: type):
        """Take the record."""
        self.made = self.type = made
        self.need, self.records = made.__name__, (made,)

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        words = summary(self.made).replace("\n", ";").partition(";")[0].rstrip(".:")
        return f"a mapping: {words[:1].lower()}{words[1:]}".removesuffix(": ")

    @functools.cached_property
    def arguments(self) -> dict[str, Argument]:
        """The fields."""
        optional = self.defaults
        return {key: argument_of(hint, key in optional) for key, hint in hints(self.made).items()}

    @functools.cached_property
    def defaults(self) -> dict[str, Any]:
        """The values of fields that may be left out."""
        return {f.name: f.default for f in fields(self.made) if f.default is not MISSING}

    def values(self, given, reading, faults=None, unknown="") -> dict[str, Any]:
        """Convert the values of the record by name; raises Faults."""
        known = beside(self.made, given) | (faults or {})
        elsewhere = getattr(self.made, "elsewhere", None)
        return convert(self.arguments, given, reading, known, unknown or self.unknown, elsewhere)

    def convert(self, value: object, reading: Reading) -> Any:
        """Make the record of a mapping; raises Faults, lines that begin with `.key: `."""
        if isinstance(value, self.made):
            return value
        if not isinstance(value, Mapping):
            if reading.written:
                raise self.refuse(value, reading)
            raise ValueError(f"{show(value)} is not a {self.need}, nor a mapping of its values")
        try:
            return assemble(self.made, self.values(value, reading))
        except ValueError as error:
            raise Faults(*map(within, lines_of(error))) from None

    def schema(self) -> dict:
        """Describe the section, with sentences and defaults as a config has them."""
        properties = {}
        for row in rows(self.made):
            default = {} if row.default is None else {"default": row.default}
            kind = self.arguments[row.key].kind
            properties[row.key] = kind.schema() | default | {"description": row.what}
        described = {"type": "object", "description": summary(self.made), "properties": properties}
        described |= {"additionalProperties": False}
        is_const = [key for key, about in properties.items() if "const" in about]
        required = [row.key for row in rows(self.made) if row.required or row.key in is_const]
        described |= {"required": required}
        instead = [[{key: {}}, *others] for key, others in instead_of(self.made).items() if others]
        every = [{"anyOf": [*map(_has, parts)]} for parts in instead]
        return described | ({"allOf": every} if every else {})


class ByKeys(RecordKind):
    """Values by name, as a record has them: what is written, and nothing else."""

    def __init__(self, made: type, need: str, unknown: str = "unknown key", least: int = 0):
        """Take the record, what is right in words, and what a name is that it does not have.

        least: number of values
        """
        super().__init__(made)
        self.need, self.unknown, self.least, self.type = need, unknown, least, dict

    def convert(self, value: object, reading: Reading) -> dict[str, Any]:
        """Convert the values; raises Faults, lines that begin with `.key: `."""
        if not isinstance(value, Mapping) or len(value) < self.least:
            raise self.refuse(value, reading)
        return told(super().convert(value, reading))


def _has(part):
    """Describe a section that has a value; {} is any."""
    ((key, value),) = part.items()
    return {"required": [key]} | ({"properties": {key: {"const": value}}} if value else {})


def _write(self):
    """Write what differs from the defaults, as Python reads it."""
    said = (f"{key}={value!r}" for key, value in told(self).items())
    return f"{type(self).__name__}({', '.join(said)})"


def _differs(value, default):
    return default is MISSING or (value is not default and np.any(value != default))


def build(made: type[Made], values: object, reading: Reading = PYTHON) -> Made:
    """Make a record of a mapping, or take one as it is.

    Raises Faults, lines that begin with `.key: `.
    """
    return kind_of(made).convert(values, reading)


def read(made: type[Made], section: object, *at: str, unit_of_C: str = PYTHON.unit_of_C) -> Made:
    """Read a section of a config, at a path; raises Faults, a line for each."""
    try:
        return build(made, section, Reading(True, unit_of_C))
    except ValueError as error:
        raise Faults(*(line_at(at, line) for line in lines_of(error))) from None


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

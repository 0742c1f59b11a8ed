"""Records: frozen dataclasses whose fields have kinds. A record is a section of a config, too.

    @record
    class Run:
        horizon: Duration = 1500.0
        '''time followed after the pulse's end'''

`Run(horizon=500.0)` and `Run(horizon="0.5 ms")` convert their values by the kinds, `read(Run,
section)` reads a section of a config, `schema(Run)` describes it to an editor, and `rows(Run)` to
docs/config.md.
"""

import ast
import functools
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from itertools import pairwise
from math import inf
from textwrap import dedent
from typing import (
    Any,
    Literal,
    NamedTuple,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError
from pydantic_core.core_schema import with_info_wrap_validator_function
from typing_extensions import dataclass_transform

from ..files.text import describe, show
from .faults import LONGEST_KEY, Faults, few, line_at
from .kinds import WRITTEN, Quantity, Word, kind_of

MOST_KNOWN = 20
"""Most keys that a message lists in full; of more, it lists half as many, the nearest."""
_BEGINS = re.compile(r"[A-Za-z_]\w*(\.\w+|\[\d+\])*: ")
Made = TypeVar("Made")


@dataclass_transform(frozen_default=True)
def record(made: type[Made]) -> type[Made]:
    """Make a frozen dataclass whose values are converted by their kinds.

    Its method `beside(written)` may give lines, by key, on values that lack or exclude each other;
    written: those that are there, by key. Its `__post_init__` may raise ValueError, `key: ...`.
    """
    made.__repr__ = _write
    made.__pydantic_config__ = {"extra": "forbid"}
    made.__get_pydantic_core_schema__ = classmethod(_explained)
    made.__get_pydantic_json_schema__ = classmethod(_described)
    words = made.__doc__  # not the signature that a dataclass has where python -OO has no words
    made = dataclass(frozen=True, repr=False)(made)
    made.__doc__ = _Docstring(words)
    made.__init__ = _converting(made.__init__, [field.name for field in fields(made)])
    return made


class _Docstring:
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
        for key, what, _, default, _ in rows(made):
            said = "" if default is None else f", default {default}"
            lines += [f"{key} : {_taken(hints(made)[key])}{said}", f"    {what}"]
        return "\n".join(lines) + heading + examples


def _taken(hint):
    """Say what Python takes for an annotation."""
    kind, holder = kind_of(hint), record_in(hint)
    return kind.need if kind else holder.__name__ if holder else need_of(hint)


def _converting(initialize, names):
    """Wrap the `__init__` of a record, which pydantic does not call, to convert its values."""

    @functools.wraps(initialize)
    def __init__(self, *positional, **named):
        given, made = dict(zip(names, positional, strict=False)) | named, type(self)
        if twice := [key for key in names[: len(positional)] if key in named]:
            raise TypeError(f"{twice[0]}: comes twice; write it once")
        for key in (key for key in given if key not in names):
            near = get_close_matches(key, names, 1)
            hint = f"; did you mean {near[0]}?" if near else f" of {made.__name__}"
            raise TypeError(f"{key}: is not a value{hint}")
        for key, hint in hints(made).items():
            if key not in given and _is_required(made, key):
                raise TypeError(f"{key}: missing; write {need_of(hint)}")
        for key, fault in beside(made, given).items():
            raise ValueError(f"{key}: {fault}")
        for key, convert in _converters(made).items():
            if key in given:
                try:
                    given[key] = convert(given[key])
                except ValueError as error:
                    raise ValueError(line_at((key,), str(error))) from None
        initialize(self, **given)

    return __init__


def _is_required(made, key):
    field = made.__dataclass_fields__[key]
    return field.default is MISSING and field.default_factory is MISSING


def _write(self):
    """Write what differs from the defaults, as Python reads it."""
    said = (f"{key}={value!r}" for key, value in told(self).items())
    return f"{type(self).__name__}({', '.join(said)})"


def _differs(value, default):
    return default is MISSING or (value is not default and np.any(value != default))


@cache
def _converters(made):
    """Give a function for each field that converts its value of Python."""
    return {key: _converter(hint) for key, hint in hints(made).items() if _converter(hint)}


def _converter(hint):
    kind, optional = kind_of(hint), type(None) in get_args(hint)
    if kind:
        return lambda value: None if optional and value is None else kind.take(value)
    if get_origin(hint) is Literal:
        return Word(get_args(hint)).take
    holder = record_in(hint)
    if holder is None:
        return None

    def convert(value):
        if isinstance(value, holder) or (optional and value is None):
            return value
        if isinstance(value, Mapping):
            return build(holder, value)
        raise ValueError(f"{show(value)} is not a {holder.__name__}")

    return convert


def build(made: type[Made], values: Mapping) -> Made:
    """Make a record of a mapping of Python; ValueError, one line that begins with `.key: `."""
    try:
        return made(**values)
    except (TypeError, ValueError) as error:
        raise ValueError(within(str(error))) from None


def assemble(made: type[Made], values: Mapping) -> Made:
    """Make a record of values that have been converted, by the names of its fields."""
    whole = object.__new__(made)
    vars(whole).update(values)
    getattr(whole, "__post_init__", lambda: None)()
    return whole


def within(line: str) -> str:
    """Mark a line that begins with the name of a key as one of the section around it."""
    return f".{line}" if _BEGINS.match(line) else line


def told(whole: object) -> dict[str, Any]:
    """Give the values of a record that differ from its defaults, by key, in the order written."""
    defaults = {field.name: field.default for field in fields(whole)}
    own = {key: value for key, value in vars(whole).items() if key in defaults}
    return {key: value for key, value in own.items() if _differs(value, defaults[key])}


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


def _explained(made, source, handler):
    """Make the schema by which pydantic reads a section; each fault becomes a line of its own."""

    def explain(values, inner, info):
        faults = {}
        if isinstance(values, made):
            return values
        if isinstance(values, Mapping):
            faults = {_path(key): [line] for key, line in beside(made, values).items()}
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
            {
                "type": PydanticCustomError("fault", line.replace("{", "{{")),
                "loc": path,
                "input": None,
            }
            for path, lines in faults.items()
            for line in lines
        ]
        raise ValidationError.from_exception_data(made.__name__, errors)

    return with_info_wrap_validator_function(explain, handler(source))


def _path(key):
    return key if isinstance(key, tuple) else (key,)


def _lines(made, detail):
    """Write what is wrong with the value of a key, one line or more."""
    first, *inner = detail["loc"] or [None]
    match detail["type"]:
        case "fault":
            return [detail["msg"].replace("{{", "{")]
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
        group.append(line_at(path, fault["msg"].replace("{{", "{")))
    for faults in alike.values():
        lines += few(faults)
    return lines


def _list_of(path):
    """Give the path of the outermost list whose items, or items of items, end a path."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    return path


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


def schema(made: type) -> dict:
    """Describe a record in JSON Schema, for editors of YAML."""
    return adapter(made).json_schema()


def _described(made, core, handler):
    """Describe a record to `schema`, with sentences and defaults as a config has them."""
    described = handler(core)
    whole = handler.resolve_ref_schema(described)
    whole.pop("title", None)
    whole["description"] = summary(made)
    whole["required"] = []
    for row in rows(made):
        about = whole["properties"][row.key]
        options = [part for part in about.pop("anyOf", ()) if part != {"type": "null"}]
        about |= options[0] if len(options) == 1 else {"anyOf": options} if options else {}
        for key in ("default", "title"):
            about.pop(key, None)
        about |= {"description": row.what}
        about |= {} if row.default is None else {"default": row.default}
        if row.required or "const" in about:
            whole["required"].append(row.key)
    if instead := {key: others for key, others in _instead(made).items() if others}:
        whole["allOf"] = [
            {"anyOf": [{"required": [key]}, *map(_has, others)]} for key, others in instead.items()
        ]
    return described


def _has(part):
    """Describe a section that has a value; {} is any."""
    ((key, value),) = part.items()
    return {"required": [key]} | ({"properties": {key: {"const": value}}} if value else {})


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
    instead = _instead(made)
    for field in fields(made):
        hint = hints(made)[field.name]
        needed = _is_required(made, field.name) or instead.get(field.name) == []
        what = sentences(made).get(field.name, "")
        yield Row(field.name, what, need_of(hint), _default(field.default, hint), needed)


def _instead(made):
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

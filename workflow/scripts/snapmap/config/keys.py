"""Types of the keys of a config: quantities with units, arguments, axes, paths, sections.

A field's description says what would be right, in messages and on docs/config.md.
"""

import re
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import PurePath
from typing import Annotated, ClassVar

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ..device.argument import Argument, argument_of, integer
from ..device.argument import word as one_of
from ..device.quantities import KINDS, bounds_of
from ..files.text import SIGNS, is_showable
from ..numerics.portable import geometric, linear
from .units import read, show

_WITHIN = re.compile(r"(\.[A-Za-z_]\w*|\[\d+\])+: ")
_LONGEST_KEY = 40
MOST_ALIKE = 3
"""Most faults of items of a list that have a line each."""
_MOST_KNOWN = 20
"""Most keys that a message lists in full; of more, it lists half as many, the nearest."""
_FAULT = "fault"
"""Type of pydantic's errors whose message is a line of this package."""


class Section(BaseModel):
    """A mapping of known keys; each of its faults is an error of its own."""

    known_as: ClassVar[str] = ""
    """Path by which errors of the made object name this section, as they also do from Python."""
    model_config = ConfigDict(extra="forbid", frozen=True)
    _made: object = PrivateAttr(None)
    _keys: tuple[str, ...] = PrivateAttr(())

    @classmethod
    def beside(cls, section: Mapping) -> dict[tuple, str]:
        """Find keys that are missing or too many beside others; returns lines by path."""
        return {}

    def make(self) -> object:
        """Make the object that the section describes; a ValueError may begin with `.key: `."""

    @property
    def made(self) -> object:
        """The object that `make` made."""
        return self._made

    @property
    def given(self) -> dict:
        """The values that the config has, by key, in its order."""
        return {key: getattr(self, key) for key in self._keys}

    def has(self, *keys: str) -> bool:
        """Tell whether the config has one of these keys."""
        return not self.model_fields_set.isdisjoint(keys)

    @classmethod
    def what(cls) -> str:
        """Say what would be right in place of the section."""
        words = (cls.__doc__ or "").partition("\n")[0].rstrip(".")  # python -OO has none
        return f"a mapping: {words[:1].lower()}{words[1:]}".removesuffix(": ")

    @classmethod
    def needs(cls) -> dict[str, str]:
        """Say what would be right for each key."""
        fields = cls.model_fields.items()
        return {field.alias or key: field.description for key, field in fields}

    @model_validator(mode="wrap")
    @classmethod
    def _explained(cls, values, handler):
        faults, section = cls.beside(values) if isinstance(values, Mapping) else {}, None
        try:
            section = handler(values)
            section._keys = tuple(values)
            if not faults:
                section._made = section.make()
        except ValidationError as error:
            faults |= {detail["loc"]: cls._line(detail) for detail in error.errors()}
        except ValueError as error:
            faults = {(): str(error).removeprefix(cls.known_as).removeprefix(": ")}
        if faults:
            errors = [
                {"type": PydanticCustomError(_FAULT, line), "loc": path, "input": None}
                for path, line in faults.items()
            ]
            raise ValidationError.from_exception_data(cls.__name__, errors)
        return section

    @classmethod
    def _line(cls, error):
        needs, (first, *inner) = cls.needs(), error["loc"] or [None]
        match error["type"]:
            case "fault":
                return error["msg"]
            case "value_error":
                return str(error["ctx"]["error"])
            case "missing" if not inner:
                return f"missing; write {needs[first]}"
            case "extra_forbidden" | "invalid_key":
                return f"unknown key; known here are {_nearest(first, list(needs))}"
        return f"{show(error['input'])} is not {needs.get(first) or cls.what()}"


def _nearest(key, known):
    if len(known) <= _MOST_KNOWN:
        return ", ".join(known)
    nearest = get_close_matches(str(key)[:_LONGEST_KEY], known, _MOST_KNOWN // 2, 0)
    return f"{', '.join(nearest)} and {len(known) - len(nearest)} others"


def lines_of(error: ValidationError, *at: str | int) -> list[str]:
    """Write a line for each fault of a section, with the name of its key; at: path of the section.

    If a list has more than MOST_ALIKE faults, one line gives the first and the number of others.
    """
    alike, lines = {}, []
    for number, fault in enumerate(error.errors()):
        path = (*at, *fault["loc"])
        of_list = _list_of(path)
        group = alike.setdefault(number if of_list == path else of_list, [])
        group.append(line_at(path, fault["msg"]))
    for faults in alike.values():
        if len(faults) > MOST_ALIKE:
            faults = [f"{faults[0]} (and {len(faults) - 1} others of this list)"]
        lines += faults
    return lines


def _list_of(path):
    """Give the path of the outermost list whose items, or items of items, end a path."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    return path


def line_at(path: tuple, line: str) -> str:
    """Put the name of its key before a fault, unless the line has it, or begins with `.key: `."""
    name = name_of(path)
    if _WITHIN.match(line):
        return f"{name if path else ''}{line}".removeprefix(".")
    return line if line.startswith((f"{name}:", f"{name}.")) else f"{name}: {line}"


def in_list(place: int, line: str) -> str:
    """Put the place of an item in a list before a fault, which may begin with `.key: `."""
    return f"[{place}]{line}" if _WITHIN.match(line) else f"[{place}]: {line}"


def name_of(path: tuple) -> str:
    """Write a path as `device.beam.span` or `sweep.f0[2]`; the document itself is `config`."""
    name = ""
    for key in path:
        plain = isinstance(key, str) and key.isidentifier() and len(key) <= _LONGEST_KEY
        name += f".{key}" if plain else f"[{show(key, _LONGEST_KEY)}]"
    return name.removeprefix(".") or "config"


def key(convert: Callable, need: str, what="", example="", out="") -> object:
    """Make the type of a key whose value a function converts, or refuses with a ValueError.

    need: values that would be right; what: meaning of the key; out: what holds if it is left out
    """
    return Annotated[object, PlainValidator(convert), words(need, what, example, out)]


def words(need: str, what="", example="", out="", **limits: int) -> object:
    """Make the field of a key; arguments as for `key`, limits as for pydantic's Field."""
    shown = {"example": example, "left_out": out or "required"}
    default = {"default": None} if out else {}
    description = ": ".join(filter(None, [need, what]))
    return Field(description=description, json_schema_extra=shown, **default, **limits)


def quantity(kind: str, what="", example="", out="") -> object:
    """Make the type of a number with a unit, converted to the internal one; kind: key of KINDS."""
    example = example or KINDS[kind].example.replace("'", "")
    return key(lambda value: read(value, kind), _need(kind), what, example, out)


def _need(kind):
    return f"{KINDS[kind].name} {bounds_of(KINDS[kind].interval)}".strip()


def argument(taken: object, what="", example="", out="") -> object:
    """Make the type of a key by an Argument, or by a type in the signature of a function."""
    taken = taken if isinstance(taken, Argument) else argument_of(taken)

    def fit(value):
        if not taken.fits(value):
            raise ValueError(f"{show(value)} is not {': '.join(filter(None, [taken.need, what]))}")
        return taken.convert(value)

    return key(fit, taken.need, what, example, out)


def word(*words: str, what="", out="") -> object:
    """Make the type of a key that has one of some words."""
    return argument(one_of(*words), what, "", out)


def flag(what: str, out="") -> object:
    """Make the type of a key that is true or false."""
    return argument(Argument("true or false", lambda value: isinstance(value, bool)), what, "", out)


def path(what: str, example="", out="", check: Callable = str) -> object:
    """Make the type of a path of a file in the study's folder; check: converts the path."""
    need = f"the path of {what}"

    def convert(value):
        if not (isinstance(value, str) and value):
            raise ValueError(f"{show(value)} is not {need}")
        return check(inside(value))

    return key(convert, need, "", example, out)


def either(section: type[Section], other: object, need: str, what="", example="", out="") -> object:
    """Make the type of a key that has a section, or a value of another type."""
    other = TypeAdapter(other)

    def convert(value):
        is_section = isinstance(value, Mapping)
        return section.model_validate(value) if is_section else other.validate_python(value)

    return key(convert, need, what, example, out)


def part(section: type[Section], out="") -> object:
    """Make the type of a key that has a section."""
    return Annotated[section, words(section.what(), "", "", out)]


def many(item: object, need: str, example="", out="", least=0) -> object:
    """Make the type of a list of items, at least so many."""
    return Annotated[list[item], words(need, "", example, out, min_length=least)]


def inside(file: str) -> str:
    """Return the path of a file in the study's folder; ValueError, one line, for any other.

    Paths stand in tables and on the terminal.
    """
    if not is_showable(file):
        raise ValueError(f"{show(file)} has signs that do not print or are in {SIGNS}; rename it")
    if PurePath(file).is_absolute() or ".." in PurePath(file).parts:
        raise ValueError(f"{file} lies outside the study's folder; copy it there")
    return file


class Range(Section):
    """A range of values, both ends counted."""

    start: Annotated[object, words("one end"), Field(alias="from")]
    stop: Annotated[object, words("the other end"), Field(alias="to")]
    points: argument(integer(1, 1_000_000), "number of values")
    spacing: word("linear", "log", out="`linear`")

    def make(self) -> np.ndarray:
        """Make the values; ValueError for ends that do not fit their number or the spacing."""
        ends = [self.start, self.stop]
        if not np.isfinite(ends).all():
            raise ValueError("hard cannot be an end of a range; write a list")
        if (self.points == 1) != (self.start == self.stop):
            need = "equal ends" if self.points == 1 else "from and to that differ"
            raise ValueError(f".points: {self.points} needs {need}; write other ends or points")
        if self.spacing != "log":
            return linear(*ends, self.points)
        if min(ends) <= 0:
            raise ValueError(".spacing: log needs from and to above 0; write linear, or a list")
        return geometric(*ends, self.points)


@cache
def _range(kind):
    ends = {
        name: (quantity(kind, "one end", KINDS[kind].example), Field(alias=alias))
        for name, alias in (("start", "from"), ("stop", "to"))
    }
    return create_model("Range", __base__=Range, __doc__=Range.__doc__, **ends)


def axis(kind: str, what: str, example="", out="") -> object:
    """Make the type of an axis: a list of quantities, or a range, as an ascending array."""

    def ascending(written):
        values = np.sort(written.made if isinstance(written, Range) else written)
        before, after = values[:-1], values[1:]
        repeated = after[(after == before) | (after * (1 - 1e-14 * np.sign(after)) <= before)]
        if repeated.size:
            value = f"{repeated[0]:.15g} {KINDS[kind].unit}".strip()
            raise ValueError(f"{value} comes twice; write every value once")
        return values

    need = f"a list or a range {{from, to, points, spacing}}, each {_need(kind)}"
    values = many(quantity(kind), need, least=1)
    field = either(_range(kind), values, need, what, example, out)
    return Annotated[field, AfterValidator(ascending)]

"""Kinds of values. Each is one alias that says noun, unit, example and bounds to all who ask:

    thickness: Length          # in a record, in a signature, in a section of a config

A type checker reads a number there, and `help` prints the alias. `take` converts a value of Python,
`read` one of a config, and an editor of YAML completes by the schema.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, Union, get_args

import numpy as np
from pydantic_core.core_schema import (
    with_info_plain_validator_function,
    with_info_wrap_validator_function,
)

from ..files.text import describe, plain, show
from ..numerics.portable import geometric, linear
from . import units
from .faults import Faults, few, line_at, within

WRITTEN = {"written": True}
"""Context in which pydantic reads a config."""
Number = float | np.ndarray


@dataclass(frozen=True)
class Bounds:
    """An interval of numbers; low_fits, high_fits: whether its ends belong to it."""

    low: float
    high: float
    low_fits: bool
    high_fits: bool

    def holds(self, values: Number) -> np.ndarray:
        """Return whether each value is in the interval; NaN is not."""
        above = np.greater(values, self.low) | (self.low_fits & np.equal(values, self.low))
        return above & (np.less(values, self.high) | (self.high_fits & np.equal(values, self.high)))

    def __str__(self):
        """Write the interval in words that follow a noun."""
        ends = []
        if self.low_fits and self.high_fits and self.high < inf:
            return f"from {self.low:.10g} to {self.high:.10g}"
        if self.low > -inf:
            ends.append(f"{'from' if self.low_fits else 'above'} {self.low:.10g}")
        if self.high < inf:
            ends.append(f"{'up to' if self.high_fits else 'below'} {self.high:.10g}")
        return " and ".join(ends)


class Kind:
    """A kind of value; `take` and `read` convert one, or raise ValueError in one line."""

    need: str
    """What is right, in words that follow "is not"."""
    records: tuple = ()
    """Records of which a config has one."""

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return self.need

    def take(self, value: object) -> object:
        """Convert a value of Python."""
        raise NotImplementedError

    def read(self, value: object) -> object:
        """Convert a value of a config."""
        return self.take(value)

    def write(self, value: Any) -> object:
        """Write a value as a config has it."""
        return value

    def schema(self) -> dict:
        """Describe, in JSON Schema, what a config has."""
        return {}

    def __get_pydantic_core_schema__(self, source, handler):
        """Read values of a config, and take all others."""

        def fit(value, info):
            return (self.read if info.context == WRITTEN else self.take)(value)

        if not self.records:
            return with_info_plain_validator_function(fit)
        described = handler.generate_schema(Union[self.records])  # noqa: UP007, of a variable
        return with_info_wrap_validator_function(lambda value, _, info: fit(value, info), described)

    def __get_pydantic_json_schema__(self, schema, handler):
        """Give `schema` to pydantic, or that of the records."""
        return handler(schema) if self.records else self.schema()


@dataclass(frozen=True)
class Quantity(Kind):
    """A number, or an array of numbers, in an internal unit.

    noun: with article; example: in a config; words: numbers behind words
    reads: unit in which users read it, a key of `units.READ`; "" for the internal one
    """

    noun: str
    unit: str = ""
    example: str = ""
    interval: str = "(0, inf)"
    words: tuple[tuple[str, float], ...] = ()
    reads: str = ""

    @cached_property
    def bounds(self) -> Bounds:
        """The interval, such as "[0, inf)"."""
        low, high = (float(end) for end in self.interval[1:-1].split(","))
        return Bounds(low, high, self.interval[0] == "[", self.interval[-1] == "]")

    @property
    def need(self) -> str:
        """What is right in Python, in words that follow "is not"."""
        return " ".join(f"a number {self.bounds} {self.unit and f'in {self.unit}'}".split())

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        words = "".join(f", or the word {word}" for word, _ in self.words)
        return " ".join(f"{self.noun} {self.bounds}".split()) + words

    def take(self, value: object) -> Number:
        """Convert numbers, text with a unit, and objects with one; a single one becomes a float."""
        if isinstance(value, str) and (self.unit or self.words or units.is_plain(value)):
            return self.read(value)
        if isinstance(value, list | tuple) and any(isinstance(item, str) for item in value):
            value = [self.take(item) for item in value]
        try:
            array = units.numbers_in(value, self.unit)
        except ValueError as error:
            raise ValueError(f"{show(value)} {error}; write {self.need}") from None
        if array is None or not array.size:
            raise ValueError(f"{show(value)} is not {self.need}")
        worded = [number for _, number in self.words]
        wrong = array[~(self.bounds.holds(array) | np.isin(array, worded))]
        if wrong.size:
            raise ValueError(f"{show(wrong[0] if array.ndim else value)} is not {self.need}")
        return array if array.ndim else array.item()

    def read(self, value: object) -> float:
        """Convert text with a unit, or a number without one."""
        if isinstance(value, str) and value in dict(self.words):
            return dict(self.words)[value]
        try:
            number = units.read(value, self.unit)
            if not self.bounds.holds(number):
                raise ValueError(f"is not {self.bounds}")
        except ValueError as error:
            example = f"'{self.example}'" if self.unit else self.example
            also = "".join(f", or the word {word}" for word, _ in self.words)
            such = f" such as {example}" if example else ""
            raise ValueError(f"{describe(value)} {error}; write {self.noun}{such}{also}") from None
        return number

    def write(self, value: float) -> object:
        """Write a number with its unit."""
        if not self.unit:
            return value
        if self.unit == "%":
            return f"{plain(100 * value)} %"
        return units.used(f"{value} {self.unit}", self.reads).replace(" 1/", " /")

    def schema(self) -> dict:
        """Describe text with a unit, or a number."""
        number = r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?"
        if self.unit:
            some = [{"type": "string", "pattern": rf"^{number} *(/ *|1 */ *)?[A-Za-zµμ%].*$"}]
        else:
            some = [{"type": "number"}, {"type": "string", "pattern": rf"^{number}\s*$"}]
        some += [{"enum": [word for word, _ in self.words]}] if self.words else []
        such = f", such as {self.example}" if self.example else ""
        about = {"title": self.asks, "errorMessage": f"write {self.asks}{such}"}
        about |= {"examples": [self.example]} if self.example else {}
        return about | (some[0] if len(some) == 1 else {"anyOf": some})


@dataclass(frozen=True)
class Single(Quantity):
    """A single number."""

    def take(self, value: object) -> float:
        """Convert a number; an array is refused."""
        number = super().take(value)
        if not isinstance(number, float):
            raise ValueError(f"{show(value)} is not {self.need}")
        return number


@dataclass(frozen=True)
class Several(Kind):
    """A number or several different ones of a kind; in a config a list, or a range."""

    of: Quantity

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        return self.of.need.replace("a number", "a number or several, each once,", 1)

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a list or a range {{from, to, points, spacing}}, each {self.of.asks}"

    def take(self, value: object) -> np.ndarray:
        """Convert numbers to a row, (n,)."""
        try:
            row = np.atleast_1d(self.of.take(value))
        except ValueError as error:
            raise ValueError(str(error).replace(self.of.need, self.need)) from None
        if row.ndim > 1 or not row.size or np.unique(row).size < row.size:
            raise ValueError(f"{show(value)} is not {self.need}")
        return row

    def read(self, value: object) -> np.ndarray:
        """Convert a list or a range of a config to an ascending row, (n,)."""
        if isinstance(value, Mapping):
            values = self._spaced(value)
        elif not isinstance(value, list | tuple) or not value:
            raise ValueError(f"{describe(value)} is not {self.asks}")
        else:
            values = read_each(self.of, value)
        values = np.sort(values)
        before, after = values[:-1], values[1:]
        repeated = after[(after == before) | (after * (1 - 1e-14 * np.sign(after)) <= before)]
        if repeated.size:
            twice = f"{repeated[0]:.15g} {self.of.unit}".strip()
            raise ValueError(f"{twice} comes twice; write every value once")
        return values

    def _spaced(self, section):
        """Space values as a range says, both ends counted."""
        kinds, values, faults = self._of_range, {"points": 1, "spacing": "linear"}, []
        for key, kind in kinds.items():
            try:
                if key in section:
                    values[key] = kind.read(section[key])
                elif key != "spacing":
                    faults.append(f".{key}: missing; write {kind.asks}")
            except ValueError as error:
                faults.append(f".{key}: {error}")
        unknown = f"unknown key; known here are {', '.join(kinds)}"
        faults += [within(line_at((key,), unknown)) for key in section if key not in kinds]
        if faults:
            raise Faults(*faults)
        points, ends = values["points"], [values["from"], values["to"]]
        if not np.isfinite(ends).all():
            raise ValueError("hard cannot be an end of a range; write a list")
        if (points == 1) != (ends[0] == ends[1]):
            need = "equal ends" if points == 1 else "from and to that differ"
            raise ValueError(f".points: {points} needs {need}; write other ends or points")
        if values["spacing"] == "linear":
            return linear(*ends, points)
        if min(ends) <= 0:
            raise ValueError(".spacing: log needs from and to above 0; write linear, or a list")
        return geometric(*ends, points)

    def schema(self) -> dict:
        """Describe a list or a range."""
        described = {key: kind.schema() for key, kind in self._of_range.items()}
        of_range = {"type": "object", "properties": described, "additionalProperties": False}
        of_range["required"] = [key for key in described if key != "spacing"]
        return {"anyOf": [{"type": "array", "items": self.of.schema(), "minItems": 1}, of_range]}

    @property
    def _of_range(self):
        """Kind of each key of a range."""
        ends, spacings = {"from": self.of, "to": self.of}, Word(("linear", "log"))
        return ends | {"points": Whole(1, 1_000_000), "spacing": spacings}


def read_each(kind: Kind, items: Sequence) -> list:
    """Read the items of a list of a config; raises Faults, a line for each wrong one, or `few`."""
    values, faults = [], []
    for place, item in enumerate(items):
        try:
            values.append(kind.read(item))
        except ValueError as error:
            faults.append(line_at((place,), str(error)))
    if faults:
        raise Faults(*few(faults))
    return values


class Plain(Kind):
    """A kind whose values a config has as Python has them."""

    def read(self, value: object) -> object:
        """Convert a value of a config."""
        try:
            return self.take(value)
        except ValueError:
            raise ValueError(f"{describe(value)} is not {self.asks}") from None


@dataclass(frozen=True)
class Whole(Plain):
    """A whole number from low to high."""

    low: int
    high: int | None = None

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        return f"a whole number from {self.low}{'' if self.high is None else f' to {self.high}'}"

    def take(self, value: object) -> int:
        """Convert a whole number, also of numpy or xarray."""
        array = units.plain_numbers(value)
        whole = array is not None and array.ndim == 0 and np.asarray(value).dtype.kind in "iu"
        if not whole or not self.low <= array <= (inf if self.high is None else self.high):
            raise ValueError(f"{show(value)} is not {self.need}")
        return int(np.asarray(value))

    def schema(self) -> dict:
        """Describe a whole number."""
        most = {} if self.high is None else {"maximum": self.high}
        return {"type": "integer", "minimum": self.low} | most


@dataclass(frozen=True)
class Flag(Plain):
    """True or false."""

    need: str = "True or False"
    asks: str = "true or false"

    def take(self, value: object) -> bool:
        """Convert a bool, also of numpy or xarray."""
        single = getattr(value, "ndim", None) == 0 and np.asarray(value).dtype.kind == "b"
        if not isinstance(value, bool | np.bool_) and not single:
            raise ValueError(f"{show(value)} is not {self.need}")
        return bool(value)

    def schema(self) -> dict:
        """Describe true or false."""
        return {"type": "boolean"}


@dataclass(frozen=True)
class Word(Plain):
    """One of some words; a word stays as it is."""

    words: tuple[str, ...]

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        return f"one of {', '.join(self.words)}"

    def take(self, value: object) -> str:
        """Take one of the words."""
        if not isinstance(value, str) or value not in self.words:
            raise ValueError(f"{show(value)} is not {self.need}")
        return value

    def schema(self) -> dict:
        """Describe the words."""
        return {"enum": [*self.words]}


@dataclass(frozen=True)
class Fitting(Kind):
    """Any value for which a function holds; json: its schema."""

    need: str
    fits: Callable[[Any], object]
    json: tuple[tuple[str, object], ...] = ()

    def take(self, value: object) -> object:
        """Take a value that fits, as it is."""
        if not self.fits(value):
            raise ValueError(f"{show(value)} is not {self.need}")
        return value

    def schema(self) -> dict:
        """Describe what a config has."""
        return dict(self.json)


def kind_of(hint: object) -> Kind | None:
    """Give the kind behind an annotation, also of an optional value."""
    parts = (hint, *get_args(hint))
    notes = (n for p in parts for n in getattr(getattr(p, "__value__", p), "__metadata__", ()))
    return next((note for note in notes if isinstance(note, Kind)), None)

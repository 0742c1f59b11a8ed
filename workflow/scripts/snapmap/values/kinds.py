"""Kinds of values. Each is one alias that says noun, unit, example and bounds to all who ask:

    thickness: Length          # in a record, in a signature, in a section of a config

`take` converts a value of Python, `read` one of a config, `write` writes one as a config has it,
and an editor of YAML completes by the schema. A type of Python without a kind of its own, as
`list[Blow]` or `Literal["auto"]`, has one by `kind_of`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from types import NoneType
from typing import Any, Literal, get_args, get_origin

import numpy as np

from ..files.text import describe, plain, show
from ..numerics.portable import geometric, linear
from . import units
from .arguments import PYTHON, Argument, Reading, convert, lines_of, nearest
from .faults import Faults, few, line_at, within

Number = float | np.ndarray
CONFIG = Reading(written=True)


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
    """A kind of value; `take` and `read` convert one, or raise ValueError, a line for each fault.

    A kind of parts overrides `convert`, by which it converts the parts; others `take`, and `read`
    if a config has other values than Python, or other words for what is wrong.
    """

    need: str
    """What is right in Python, in words that follow "is not"."""
    type: Any = object
    """Type of Python, as a signature shows it."""
    records: Any = ()
    """Records of which a config has one, or several."""

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return self.need

    def wants(self, reading: Reading) -> str:
        """What is right."""
        return self.asks if reading.written else self.need

    def convert(self, value: object, reading: Reading) -> Any:
        """Convert a value."""
        return self.read(value) if reading.written else self.take(value)

    def take(self, value: object) -> Any:
        """Convert a value of Python."""
        return self.convert(value, PYTHON)

    def read(self, value: object) -> Any:
        """Convert a value of a config."""
        return self.convert(value, CONFIG)

    def write(self, value: Any) -> object:
        """Write a value as a config has it."""
        return value

    def schema(self) -> dict:
        """Describe, in JSON Schema, what a config has."""
        each = [kind_of(made).schema() for made in self.records]
        return {"anyOf": each} if each else {}

    def refuse(self, value: object, reading: Reading = PYTHON) -> ValueError:
        """Make the error of a value that is not right."""
        told = (describe if reading.written else show)(value)
        return ValueError(f"{told} is not {self.wants(reading)}")


@dataclass(frozen=True)
class Quantity(Kind):
    """A number, or an array of numbers, in an internal unit.

    noun: with article; example: in a config; words: numbers behind words
    reads: unit in which users read it, a key of `units.READ`; "" for the internal one
    is_single: whether an array is refused
    """

    noun: str
    unit: str = ""
    example: str = ""
    interval: str = "(0, inf)"
    words: tuple[tuple[str, float], ...] = ()
    reads: str = ""
    is_single: bool = False
    type = float

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
        if type(value) is float and self.bounds.low < value < self.bounds.high:
            return value
        if isinstance(value, str) and (self.unit or self.words or units.is_plain(value)):
            return self.read(value)
        if isinstance(value, list | tuple) and any(isinstance(item, str) for item in value):
            value = [self.take(item) for item in value]
        try:
            array = units.numbers_in(value, self.unit)
        except ValueError as error:
            raise ValueError(f"{show(value)} {error}; write {self.need}") from None
        if array is None or not array.size or array.ndim > (not self.is_single):
            raise self.refuse(value)
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

    def under(self, reading: Reading) -> "Quantity":
        """Give the kind in the unit of a reading, which only C does not have always."""
        return self

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
class Several(Kind):
    """A number or several different ones of a kind; in a config a list, or a range."""

    of: Quantity
    type = float | list[float]

    def convert(self, value: object, reading: Reading) -> np.ndarray:
        """Convert numbers, in the unit of a reading."""
        kind = replace(self, of=self.of.under(reading))
        return kind.read(value) if reading.written else kind.take(value)

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
        if np.unique(row).size < row.size:
            raise self.refuse(value)
        return row

    def read(self, value: object) -> np.ndarray:
        """Convert a list or a range of a config to an ascending row, (n,)."""
        if isinstance(value, Mapping):
            values = self._spaced(value)
        elif not isinstance(value, list | tuple) or not value:
            raise self.refuse(value, CONFIG)
        else:
            values = Items(self.of).read(value)
        values = np.sort(values)
        before, after = values[:-1], values[1:]
        repeated = after[(after == before) | (after * (1 - 1e-14 * np.sign(after)) <= before)]
        if repeated.size:
            twice = f"{repeated[0]:.15g} {self.of.unit}".strip()
            raise ValueError(f"{twice} comes twice; write every value once")
        return values

    def _spaced(self, section):
        """Space values as a range says, both ends counted."""
        arguments = {key: Argument(kind, key == "spacing") for key, kind in self._of_range.items()}
        try:
            values = {"spacing": "linear"} | convert(arguments, section, CONFIG)
        except Faults as faults:
            raise Faults(*map(within, faults.args)) from None
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


@dataclass(frozen=True)
class Pair(Kind):
    """Two numbers of a kind, low and high."""

    of: Quantity
    type = tuple[float, float]
    need = "a pair of numbers, low and high"

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a pair of values: its range, each {self.of.asks}"

    def convert(self, value: object, reading: Reading) -> tuple[float, float]:
        """Convert a pair; of Python also an array."""
        kind = replace(self.of.under(reading), is_single=False)
        if reading.written and isinstance(value, list) and len(value) == 2:
            return tuple(Items(kind).read(value))
        row = None if reading.written else kind.take(value)
        if np.shape(row) != (2,):
            raise self.refuse(value, reading)
        return tuple(row.tolist())

    def schema(self) -> dict:
        """Describe a pair."""
        return {"type": "array", "items": self.of.schema(), "minItems": 2, "maxItems": 2}


@dataclass(frozen=True)
class Items(Kind):
    """A list of values of a kind."""

    of: Kind
    type = list

    records = property(lambda self: self.of.records)

    @property
    def need(self) -> str:
        """What is right in Python, in words that follow "is not"."""
        return f"a list, each {self.of.need}"

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a list, each {self.of.asks}"

    def convert(self, value: object, reading: Reading) -> list:
        """Convert the items; raises Faults, a line for each wrong one, of wrong values a `few`."""
        if not isinstance(value, list | tuple):
            raise self.refuse(value, reading)
        values, alike, faults = [], [], []
        for place, item in enumerate(value):
            try:
                values.append(self.of.convert(item, reading))
            except ValueError as error:
                lines = [line_at((place,), line) for line in lines_of(error)]
                (faults if isinstance(error, Faults) else alike).extend(lines)
        if alike or faults:
            raise Faults(*few(alike), *faults)
        return values

    def schema(self) -> dict:
        """Describe the list."""
        return {"type": "array", "items": self.of.schema()}


@dataclass(frozen=True)
class ByName(Kind):
    """Values of a kind by name."""

    of: Kind
    need: str = "a mapping"
    type = dict

    records = property(lambda self: self.of.records)

    def convert(self, value: object, reading: Reading) -> dict:
        """Convert the values; raises Faults, a line for each wrong one."""
        if not isinstance(value, Mapping):
            raise self.refuse(value, reading)
        try:
            return convert(dict.fromkeys(value, Argument(self.of)), value, reading)
        except Faults as faults:
            raise Faults(*map(within, faults.args)) from None

    def schema(self) -> dict:
        """Describe the mapping."""
        return {"type": "object", "additionalProperties": self.of.schema() or True}


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number from low to high."""

    low: int
    high: int | None = None
    type = int

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        return f"a whole number from {self.low}{'' if self.high is None else f' to {self.high}'}"

    def convert(self, value: object, reading: Reading) -> int:
        """Convert a whole number, also of numpy or xarray."""
        array = units.plain_numbers(value)
        whole = array is not None and array.ndim == 0 and np.asarray(value).dtype.kind in "iu"
        if not whole or not self.low <= array <= (inf if self.high is None else self.high):
            raise self.refuse(value, reading)
        return int(np.asarray(value))

    def schema(self) -> dict:
        """Describe a whole number."""
        most = {} if self.high is None else {"maximum": self.high}
        return {"type": "integer", "minimum": self.low} | most


@dataclass(frozen=True)
class Word(Kind):
    """One of some words, among which may be true and false; called: what a word is, in words."""

    words: tuple[str | bool, ...]
    called: str = ""

    @property
    def type(self) -> Any:
        """Text, a flag, or both."""
        types = {type(word) for word in self.words}
        return types.pop() if len(types) == 1 else bool | str

    @property
    def need(self) -> str:
        """What is right in Python, in words that follow "is not"."""
        if self.called or self.type is str:
            return self.called or f"one of {', '.join(map(str, self.words))}"
        return _either([repr(word).replace("'", '"') for word in self.words])

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return self.need if self.type is str else _either([*map(describe, self.words)])

    def convert(self, value: object, reading: Reading) -> str | bool:
        """Take one of the words."""
        is_flag = getattr(value, "ndim", None) == 0 and np.asarray(value).dtype.kind == "b"
        value = bool(value) if is_flag else value  # of numpy or xarray
        if not isinstance(value, str | bool) or value not in self.words:
            near = nearest(str(value), [word for word in self.words if isinstance(word, str)])
            raise ValueError(f"{self.refuse(value, reading)}{near}")
        return value

    def schema(self) -> dict:
        """Describe the words."""
        if self.type is bool:
            return {"type": "boolean"}
        return {"enum": [*self.words]} if self.words[1:] else {"const": self.words[0]}


def _either(words):
    return " or ".join([", ".join(words[:-1]), words[-1]]).replace("'", "")


@dataclass(frozen=True)
class Fitting(Kind):
    """A value for which `fits` holds, converted by `by`.

    by: may raise ValueError; in_config: what is right there; json, writes: what a config has
    """

    need: str
    fits: Callable[[Any], object] = lambda value: True
    by: Callable[[Any], Any] = lambda value: value
    in_config: str = ""
    json: Mapping[str, object] = field(default_factory=dict, hash=False, compare=False)
    writes: Callable[[Any], object] = lambda value: value

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return self.in_config or self.need

    def convert(self, value: object, reading: Reading) -> Any:
        """Convert a value that fits."""
        if not self.fits(value):
            raise self.refuse(value, reading)
        return self.by(value)

    def write(self, value: Any) -> object:
        """Write a value as a config has it."""
        return self.writes(value)

    def schema(self) -> dict:
        """Describe what a config has."""
        return {**self.json}


JSON_TEXT = {"type": "string"}
TEXT = Fitting("text", lambda value: isinstance(value, str), json=JSON_TEXT)
ANYTHING = Fitting("a value")


def kind_of(hint: Any) -> Kind:
    """Give the kind of an annotation, also of an optional value."""
    parts = get_args(hint) if NoneType in get_args(hint) else (hint,)
    part = next((part for part in parts if part is not NoneType), None)
    for note in getattr(part, "__metadata__", ()):
        if isinstance(note, Kind):
            return note
    if hasattr(part, "kind_of_record"):
        return part.kind_of_record
    inner = get_args(part)
    origin = get_origin(part)
    if origin is Literal:
        return Word(inner)
    if origin is list:
        return Items(kind_of(inner[0]))
    if origin is dict:
        return ByName(kind_of(inner[1]))
    return TEXT if part is str else ANYTHING


def argument_of(hint: Any, is_optional: bool) -> Argument:
    """Give the argument of an annotation."""
    return Argument(kind_of(hint), is_optional, NoneType in get_args(hint))

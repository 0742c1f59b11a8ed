"""What an argument may be: what would be right, in words, what fits, and what is handed on.

An annotation such as `Annotated[float, number("(0, inf)", "s")]` describes an argument where it is
declared, for the type checker, for help(), and for whoever holds a call against it.
"""

import math
from collections.abc import Callable, Mapping
from os import PathLike
from os.path import exists
from typing import Annotated, NamedTuple, get_args

import numpy as np

from ..files.text import show
from .checks import numbers
from .quantities import Bounds, bounds_of


class Argument(NamedTuple):
    """need: what would be right, as it follows "is not"; fits: whether a value is; convert: what is
    handed on of one that fits."""

    need: str
    fits: Callable[[object], bool]
    convert: Callable[[object], object] = lambda value: value

    def __repr__(self):
        """As help() shows it in an annotation."""
        return self.need

    def take(self, name: str, value: object) -> object:
        """Convert a value; raises ValueError, one line, for one that does not fit."""
        if not self.fits(value):
            raise ValueError(f"{name}: {show(value)} is not {self.need}")
        return self.convert(value)


def number(within: str | Bounds, unit: str = "", example: str = "") -> Argument:
    """A number within bounds, in a unit."""
    within = bounds_of(within) if isinstance(within, str) else within

    def fits(value):
        array = numbers(value)
        return array is not None and array.ndim == 0 and bool(within.holds(array))

    return Argument(_words("a number", within, unit, example), fits, as_plain)


def row(within: Bounds, unit: str, example: str) -> Argument:
    """A number or several, each once."""

    def fits(value):
        array = numbers(value)
        if array is None or array.ndim > 1 or not array.size or not within.holds(array).all():
            return False
        return np.unique(array).size == array.size

    words = _words("a number or several, each once,", within, unit, example)
    return Argument(words, fits, lambda value: np.atleast_1d(numbers(value)))


def as_plain(value):
    """What is a number, or several, as Python's floats, also in a mapping; all else as it is."""
    if isinstance(value, Mapping):
        return {key: as_plain(inner) for key, inner in value.items()}
    array = numbers(value)
    return value if array is None else array.tolist()


def _words(what, within, unit, example):
    words = " ".join(filter(None, (what, str(within), unit and f"in {unit}")))
    return f"{words}, such as {example}" if example else words


def integer(low: int, high: float = math.inf) -> Argument:
    """A whole number from low up to high."""
    any_number = number(Bounds(low, high, low_fits=True, high_fits=high < math.inf))
    return Argument(
        f"a whole {any_number.need.removeprefix('a ')}",
        lambda value: any_number.fits(value) and np.asarray(value).dtype.kind in "iu",
        lambda value: int(np.asarray(value)),
    )


def pairs(units: str, example: str) -> Argument:
    """Pairs of numbers above 0, the first of each ascending."""

    def fits(value):
        rows = numbers(value)
        if rows is None or rows.ndim != 2 or rows.shape[1] != 2 or len(rows) < 2:
            return False
        positive = np.isfinite(rows).all() and (rows > 0).all()
        return bool(positive and (np.diff(rows[:, 0]) > 0).all())

    words = f"two pairs or more of {units}, above 0 and ascending, such as {example}"
    return Argument(words, fits, numbers)


def word(*words: str) -> Argument:
    """One of some words."""
    need = f"one of {', '.join(words)}"
    return Argument(need, lambda value: isinstance(value, str) and value in words)


def of_type(need: str, *types: type) -> Argument:
    """A value of some types."""
    return Argument(need, lambda value: isinstance(value, types))


def mapping_of(need: str, *keys: str) -> Argument:
    """A mapping of one key or more, each one of some."""

    def fits(value):
        return isinstance(value, Mapping) and len(value) > 0 and all(key in keys for key in value)

    return Argument(f"a mapping of {need}", fits, as_plain)


def is_list(value: object, fits: Callable[[object], bool]) -> bool:
    """Whether it is a list of values that fit."""
    return isinstance(value, list | tuple) and all(map(fits, value))


def is_flag(value: object) -> bool:
    """Whether it is true or false, also as numpy has it."""
    return isinstance(value, bool | np.bool_) or (
        getattr(value, "ndim", None) == 0 and np.asarray(value).dtype.kind == "b"
    )


def is_path(value: object) -> bool:
    """Whether it is the path of a file that is there."""
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


def argument_of(annotation: object) -> Argument:
    """What an annotation says of an argument, which may be None, too."""
    described, *_ = (
        note
        for part in (annotation, *get_args(annotation))
        for note in getattr(part, "__metadata__", ())
    )
    return described


Positive = Annotated[float, number("(0, inf)")]
Flag = Annotated[bool, Argument("True or False", is_flag, bool)]
ExistingPath = Annotated[str | PathLike, Argument("the path of a file that is there", is_path)]

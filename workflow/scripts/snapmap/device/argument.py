"""Descriptions of arguments: which values are right, in words and as a check, and their conversion.

An annotation such as `Annotated[float, number("(0, inf)", "s")]` describes an argument where it is
declared, for the type checker, for help(), and for the code that checks calls.
"""

import math
from collections.abc import Callable, Mapping
from os import PathLike
from os.path import exists
from typing import Annotated, NamedTuple, get_args

import numpy as np

from .checks import numbers, shown
from .quantities import Bounds, bounds_of


class Argument(NamedTuple):
    """A description of an argument.

    need: what is right, in words that follow "is not"
    fits: tells whether a value is right; convert: makes of a right value what the function gets
    """

    need: str
    fits: Callable[[object], bool]
    convert: Callable[[object], object] = lambda value: value

    def __repr__(self):
        """Return what help() shows in an annotation."""
        return self.need

    def take(self, name: str, value: object) -> object:
        """Convert a value; raises ValueError, one line with the name, if it does not fit."""
        if not self.fits(value):
            raise ValueError(f"{name}: {shown(value)} is not {self.need}")
        return self.convert(value)


def number(within: str | Bounds, unit: str = "", example: str = "") -> Argument:
    """Describe a number within bounds, such as "(0, inf)", in a unit."""
    within = bounds_of(within) if isinstance(within, str) else within

    def fits(value):
        array = numbers(value, unit)
        return array is not None and array.ndim == 0 and bool(within.holds(array))

    return Argument(_words("a number", within, unit, example), fits, as_plain)


def row(within: Bounds, unit: str, example: str) -> Argument:
    """Describe a number or several different ones, within bounds, in a unit."""

    def fits(value):
        array = numbers(value, unit)
        if array is None or array.ndim > 1 or not array.size or not within.holds(array).all():
            return False
        return np.unique(array).size == array.size

    words = _words("a number or several, each once,", within, unit, example)
    return Argument(words, fits, lambda value: np.atleast_1d(numbers(value)))


def as_plain(value):
    """Convert numbers, also in a mapping, to Python's own; leave any other value as it is."""
    if isinstance(value, Mapping):
        return {key: as_plain(inner) for key, inner in value.items()}
    array = numbers(value)
    return value if array is None else array.tolist()


def _words(what, within, unit, example):
    words = " ".join(filter(None, (what, str(within), unit and f"in {unit}")))
    return f"{words}, such as {example}" if example else words


def integer(low: int, high: float = math.inf) -> Argument:
    """Describe a whole number from low to high."""
    any_number = number(Bounds(low, high, low_fits=True, high_fits=high < math.inf))
    return Argument(
        f"a whole {any_number.need.removeprefix('a ')}",
        lambda value: any_number.fits(value) and np.asarray(value).dtype.kind in "iu",
        lambda value: int(np.asarray(value)),
    )


def pairs(units: str, example: str) -> Argument:
    """Describe pairs of numbers above 0 whose first numbers ascend."""

    def fits(value):
        rows = numbers(value)
        if rows is None or rows.ndim != 2 or rows.shape[1] != 2 or len(rows) < 2:
            return False
        positive = np.isfinite(rows).all() and (rows > 0).all()
        return bool(positive and (np.diff(rows[:, 0]) > 0).all())

    words = f"two pairs or more of {units}, above 0 and ascending, such as {example}"
    return Argument(words, fits, numbers)


def word(*words: str) -> Argument:
    """Describe a choice of words."""
    need = f"one of {', '.join(words)}"
    return Argument(need, lambda value: isinstance(value, str) and value in words)


def of_type(need: str, *types: type) -> Argument:
    """Describe a value of some types."""
    return Argument(need, lambda value: isinstance(value, types))


def mapping_of(need: str, *keys: str) -> Argument:
    """Describe a mapping that is not empty and has some of these keys only."""

    def fits(value):
        return isinstance(value, Mapping) and len(value) > 0 and all(key in keys for key in value)

    return Argument(f"a mapping of {need}", fits, as_plain)


def is_list(value: object, fits: Callable[[object], bool]) -> bool:
    """Return whether a value is a list whose items all fit."""
    return isinstance(value, list | tuple) and all(map(fits, value))


def is_flag(value: object) -> bool:
    """Return whether a value is true or false, of Python or numpy."""
    return isinstance(value, bool | np.bool_) or (
        getattr(value, "ndim", None) == 0 and np.asarray(value).dtype.kind == "b"
    )


def is_path(value: object) -> bool:
    """Return whether a value is the path of an existing file."""
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


def argument_of(annotation: object) -> Argument:
    """Return the description in an annotation, also in that of an optional argument."""
    described, *_ = (
        note
        for part in (annotation, *get_args(annotation))
        for note in getattr(part, "__metadata__", ())
    )
    return described


Positive = Annotated[float, number("(0, inf)")]
Flag = Annotated[bool, Argument("True or False", is_flag, bool)]
ExistingPath = Annotated[str | PathLike, Argument("the path of a file that is there", is_path)]

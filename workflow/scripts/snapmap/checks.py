"""Checks of a value, or of those of a batch; a complaint names the first that is wrong."""

import re
import reprlib
from collections.abc import Mapping
from numbers import Number
from os import PathLike

import numpy as np

from .quantities import QUANTITIES, Bounds

LONGEST = 60
"""Characters of a value in a message."""


def show(value: object) -> str:
    """Quote a value in one short line."""
    value = str(value) if isinstance(value, PathLike) else value
    if not isinstance(value, str | bytes | Number | list | tuple | dict | None):
        name = type(value).__name__
        return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
    try:
        text = reprlib.repr(value.item() if isinstance(value, np.generic) else value)
    except ValueError:  # an int of more than 4300 digits
        return "a number of thousands of digits"
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]}...{text[-1]}"


NAME = "letters, digits, spaces, .,:()/%+-_, the first a letter or digit"


def is_name(text: str) -> bool:
    """Whether it may stand in tables as it is: in CSV, in Markdown and on the page."""
    return re.fullmatch(r"[^\W_][\w .,:()/%+-]*", text) is not None


def numbers(value):
    """The numbers in a value, as an array of floats of its shape; None where there are others."""
    if isinstance(value, str | bytes | bool | Mapping):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def require_quantity(key: str, name: str, value: np.ndarray, within: Bounds | None = None) -> None:
    """Raise ValueError unless values, called `key`, are numbers that fit the quantity of a name.

    within: in place of its own range
    """
    within = within or QUANTITIES[name].range
    need = " ".join(f"is not a number {within} {QUANTITIES[name].unit}".split())
    if numbers(value) is None:
        raise ValueError(f"{key}: {show(value)} {need}")
    require(within.holds(value), f"{key}: {{}} {need}", value)


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError with the first values for which it does not hold."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

"""Checks of a single value or of a batch; an error quotes the first wrong value."""

from collections.abc import Mapping

import numpy as np

from ..files.text import show
from .quantities import QUANTITIES, Bounds


def numbers(value):
    """Return the numbers in a value as an array of floats; None if it holds anything else."""
    if isinstance(value, str | bytes | bool | Mapping):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def require_quantity(name: str, value: np.ndarray, within: Bounds | None = None) -> None:
    """Raise ValueError, with the key of a config, unless all values are in the quantity's range.

    within: bounds in place of that range
    """
    quantity = QUANTITIES[name]
    within, key = within or quantity.range, f"device.{quantity.key or name}"
    need = " ".join(f"is not a number {within} {quantity.unit}".split())
    if numbers(value) is None:
        raise ValueError(f"{key}: {show(value)} {need}")
    require(within.holds(value), f"{key}: {{}} {need}", value)


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError if `holds` is false anywhere; the first values there fill the complaint."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

"""Checks of a value, or of those of a batch; a complaint names the first that is wrong."""

from collections.abc import Mapping

import numpy as np

from ..files.text import show
from .quantities import QUANTITIES, Bounds


def numbers(value):
    """The numbers in a value, as an array of floats of its shape; None where there are others."""
    if isinstance(value, str | bytes | bool | Mapping):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def require_quantity(name: str, value: np.ndarray, within: Bounds | None = None) -> None:
    """Raise ValueError, with the key of a config, unless values fit the quantity of a name.

    within: in place of its own range
    """
    quantity = QUANTITIES[name]
    within, key = within or quantity.range, f"device.{quantity.key or name}"
    need = " ".join(f"is not a number {within} {quantity.unit}".split())
    if numbers(value) is None:
        raise ValueError(f"{key}: {show(value)} {need}")
    require(within.holds(value), f"{key}: {{}} {need}", value)


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError with the first values for which it does not hold."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

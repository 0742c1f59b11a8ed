"""Checks of a single value or of a batch; an error quotes the first wrong value."""

import warnings
from collections.abc import Mapping

import numpy as np

from ..files.text import show
from .quantities import QUANTITIES, SPELT, Bounds

IN_SI = {"um": 1e6, "MPa": 1e-6, "ng/um^3": 1e-6, "um/us^2": 1e-6}
"""Internal units of which SI numbers are told, with SI's unit in them."""
LENGTHS = 0.01, 1e6
"""Usual lengths, um."""


def numbers(value, unit=None):
    """Return the numbers in a value as an array of floats; None if it holds anything else.

    unit: as a config spells it, which a DataArray may have; None for any
    Objects of packages for units, as of pint and astropy, are no numbers.
    """
    if isinstance(value, str | bytes | bool | Mapping) or _is_quantity(value):
        return None
    spelt = (unit, SPELT.get(unit, SPELT[""]).files)
    if unit is not None and unit_of(value) not in ("", *spelt):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def _is_quantity(value):
    """Whether a value, what it wraps, or an item in its lists is of a class that has units."""
    if isinstance(value, list | tuple):
        kinds = {type(item): item for item in value}
        return any(map(_is_quantity, value if {list, tuple} & {*kinds} else kinds.values()))
    wrapped = type(value), type(getattr(value, "data", None))
    return any(hasattr(kind, name) for kind in wrapped for name in ("unit", "units"))


def unit_of(value: object) -> str:
    """Return the unit that a DataArray, or an object of a package for units, has; or ""."""
    attributes = getattr(value, "attrs", {})
    if not _is_quantity(value):
        return str(attributes.get("units", "")) if isinstance(attributes, Mapping) else ""
    return str(getattr(value, "units", getattr(value, "unit", "")))


def shown(value: object) -> str:
    """Write a value, with the unit that it has, in one short line."""
    return " in ".join(filter(None, [show(value), unit_of(value)[:30]]))


def warn_of_si(section: str, sign: str, values: Mapping[str, object]) -> None:
    """Warn, in one line, if the number of a section's `sign` would be usual in SI only.

    values: numbers by name; arrays are left out, as their devices have been made before
    """
    alike = {}
    for name in values.keys() & QUANTITIES.keys():
        value, unit = values[name], QUANTITIES[name].unit
        low, high = LENGTHS if unit == "um" else QUANTITIES[name].usual
        if type(value) in (int, float) and unit in IN_SI and not low <= value <= high:
            alike |= {name: unit} if low <= value * IN_SI[unit] <= high else {}
    if sign in alike:
        words = ", ".join(f"{name} = {values[name]:g} {alike[name]}" for name in sorted(alike))
        line = f"device.{section}{words}: is this SI? numbers are in um, ng, us, and hence MPa"
        warnings.warn(line, stacklevel=4)


def require_quantity(name: str, value: np.ndarray, within: Bounds | None = None) -> None:
    """Raise ValueError, with the key of a config, unless all values are in the quantity's range.

    within: bounds in place of that range
    """
    quantity = QUANTITIES[name]
    within, key = within or quantity.range, f"device.{quantity.key or name}"
    need = " ".join(f"is not a number {within} {quantity.unit}".split())
    if numbers(value, quantity.unit) is None:
        raise ValueError(f"{key}: {shown(value)} {need}")
    require(within.holds(value), f"{key}: {{}} {need}", value)


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError if `holds` is false anywhere; the first values there fill the complaint."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

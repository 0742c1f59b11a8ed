"""The conversion of text with a unit to internal units: um, ng, us; frequencies stay in Hz."""

import math
import re
from collections.abc import Mapping
from decimal import Context, Decimal
from functools import cache
from typing import NamedTuple

import numpy as np

from ..files.extras import needing
from ..files.text import plain, show

OF_DAMPER = "uN*us/um"
"""Unit of C, unless a user's own law states another one."""
LEAST, MOST = 1e-15, 1e15
"""Least and largest size of a text's value but 0, in internal units: others overflow later."""
USUAL = {
    "um": {"nm": "1e-3", "um": "1", "mm": "1e3", "m": "1e6"},
    "us": {"us": "1", "ms": "1e3", "s": "1e6"},
    "Hz": {"Hz": "1", "kHz": "1e3", "MHz": "1e6"},
    "ng": {"ng": "1", "ug": "1e3", "mg": "1e6", "g": "1e9", "kg": "1e12"},
    "MPa": {"Pa": "1e-6", "kPa": "1e-3", "MPa": "1", "GPa": "1e3"},
    "uN": {"uN": "1", "mN": "1e3", "N": "1e6"},
    "uN/um": {"uN/um": "1", "N/m": "1", "mN/m": "1e-3"},
    "ng/um^3": {"ng/um^3": "1", "kg/m^3": "1e-6", "g/cm^3": "1e-3"},
    "um/us^2": {"um/us^2": "1", "m/s^2": "1e-6"},
    "uN*us/um": {"uN*us/um": "1"},
    "1/us": {"/us": "1", "/s": "1e-6"},
    "1/K": {"/K": "1"},
}
"""Sizes of usual units in internal ones; pint, which is slow to import, converts all others."""


class Spelling(NamedTuple):
    """How a unit is spelt in files, in figures and on the page."""

    files: str
    figures: str
    page: str


SPELT = {
    "": Spelling("1", "", ""),
    "degC": Spelling("degC", "°C", "°C"),
    "1/K": Spelling("K-1", "K$^{-1}$", "1/K"),
    "ng/um^3": Spelling("ng um-3", "ng µm$^{-3}$", "ng/µm³"),
    "1/us": Spelling("us-1", "µs$^{-1}$", "1/µs"),
    "uN/um": Spelling("uN um-1", "N/m", "N/m"),
    "uN*us/um": Spelling("uN us um-1", "µN µs µm$^{-1}$", "µN\u00a0µs/µm"),
}
"""Internal units by their spelling in a config, but for those that `spelling` spells likewise."""

READ = {
    "GPa": (1e-3, "GPa"),
    "kg/m^3": (1e6, "kg/m³"),
    "ug": (1e-3, "µg"),
    "kg": (1e-12, "kg"),
    "m/s^2": (1e6, "m/s²"),
    "N/m": (1.0, "N/m"),
}
"""Units that users read in place of internal ones: the factor to them, and how a page spells it."""

# Pint evaluates arithmetic such as 9**9**9: a unit reaches it only if it has the form below.
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = r"[A-Za-z\u00b5\u03bc%]+(?: *(?:\^|\*\*) *-?\d|[²³])?"  # both the micro sign and mu
_UNIT = rf"(?:(?<= )1 *(?=/))?(/? *{_FACTOR}(?:(?: *[*/] *| +){_FACTOR})*)"
_PART = r"([*/ ]*)([A-Za-z\u00b5\u03bc%]+)(?: *(?:\^|\*\*) *(-?\d)|([²³]))?"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = re.compile(_NUMBER, re.ASCII)
_QUANTITY = re.compile(rf"({_NUMBER}) *{_UNIT}", re.ASCII)
_LONGEST = 60
_CELSIUS = ("degree_Celsius", "degrees_Celsius", "degree_C", "degrees_C", "deg_C", "celsius", "°C")
_ALIAS = {**dict.fromkeys(_CELSIUS, "degC"), "kelvin": "K", "percent": "%"}
_ALIAS |= {spelt.files: unit for unit, spelt in SPELT.items()}
"""Spellings of packages for units, and of CF, that text in a config does not have."""
_ZERO = Decimal("273.15")
_ARITHMETIC = Context(prec=40, traps=[])


def read(value: object, unit: str) -> float:
    """Convert a number, or text, with a unit to an internal unit; "" for a number without one.

    Raises ValueError, in words that follow the value.
    """
    number = _quantity(value, unit) if unit else _number(value)
    if not math.isfinite(number):
        raise ValueError("is not finite")
    least = LEAST if unit else 0.0
    if number and not least <= abs(number) <= MOST:
        raise ValueError(f"is not between {least:g} and {MOST:g} {unit}".rstrip())
    return number


def numbers_in(value: object, unit: str) -> np.ndarray | None:
    """Convert the numbers in a value to an internal unit; None if it holds anything else.

    value: plain numbers count in the unit, objects of pint, astropy and unyt and variables of
        xarray in their own; ValueError, in words that follow the value, if theirs does not convert
    """
    if isinstance(value, list | tuple) and any(map(_has_unit, value)):
        rows = [numbers_in(item, unit) for item in value]
        return None if any(row is None for row in rows) else np.array(rows)
    own, value = unit_of(value), _held(value)
    if own is not None and hasattr(type(value), "magnitude"):  # pint and Python's other packages
        value = value.magnitude
    elif own is not None and not hasattr(value, "attrs"):
        value = np.asarray(value)
    array = plain_numbers(value)
    if own == "dimensionless":
        own = ""
    if array is None or own is None or own in (unit, spelling("" if unit == "%" else unit).files):
        return array
    if not unit:
        raise ValueError(f"in {own[:30]} has a unit")
    try:
        converted = [_converted(number, own, unit) for number in array.ravel().tolist()]
    except ValueError as error:
        raise ValueError(f"in {own[:30]} {error}") from None
    return np.reshape(converted, array.shape)


def plain_numbers(value: object) -> np.ndarray | None:
    """Give the numbers in a value without a unit as floats; None if it holds anything else."""
    if np.ma.is_masked(value):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        return None


def unit_of(value: object) -> str | None:
    """Give the unit that a variable of xarray, or an object of a package for units, has."""
    held = _held(value)
    if _has_unit(held):
        return str(getattr(held, "units", getattr(held, "unit", "")))
    attributes = getattr(held, "attrs", None)
    has_units = isinstance(attributes, Mapping) and "units" in attributes
    return str(attributes["units"]) if has_units else None


def _held(value):
    """Give the object with a unit that a variable of xarray holds; leave others as they are."""
    data = getattr(value, "data", None) if hasattr(value, "attrs") else None
    return data if _has_unit(data) else value


def _has_unit(value):
    return any(hasattr(type(value), name) for name in ("unit", "units"))


def spelling_of(value: object, unit: str) -> tuple[str, float]:
    """Give the unit of a value that `read` takes: its spelling, and its size in internal units."""
    match = _matches(_QUANTITY, value)
    return (own := match[2].strip(), float(_factor(own, unit))) if match else (unit, 1.0)


def require_unit(text: object) -> str:
    """Give a unit as a config spells it, "" for "1"; raises ValueError for an unknown one."""
    if text == "1" or text in USUAL:
        return "" if text == "1" else text
    if not _matches(re.compile(_UNIT, re.ASCII), text):
        raise ValueError(f"{show(text)} is not a unit; write one such as uN*us^3/um^3, or 1")
    by_pint(text, text)
    return text


@cache
def spelling(unit: str) -> Spelling:
    """Spell a unit of a config; those that are not in SPELT as they are written."""
    if unit in SPELT:
        return SPELT[unit]
    figures = re.sub(r" *(?:\^|\*\*) *(-?\d)", r"$^{\1}$", unit)
    figures = re.sub(r"\bu(?=\w)", "µ", re.sub(r" *\* *", " ", figures))
    page = re.sub(r"\$\^{(.*?)}\$", lambda power: power[1].translate(_RAISED), figures)
    files = []
    for before, name, power, digit in re.findall(_PART, unit):
        power = int(power or {"²": 2, "³": 3}.get(digit, 1)) * (-1 if "/" in before else 1)
        files.append(f"{name}{power}" if power != 1 else name)
    return Spelling(" ".join(files), figures, page.replace(" ", "\u00a0"))


def of_file(unit: str) -> str:
    """Give a unit as a config spells it, by the spelling of CF or of a package for units."""
    powers = re.sub(r"(?<=[A-Za-z\u00b5\u03bc])(-?\d)", r"^\1", unit.removeprefix("1 "))
    return _ALIAS.get(unit, powers)


def is_plain(value: object) -> bool:
    """Tell whether a value is a number without a unit; text counts, as YAML reads 1e-3 as text."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number or bool(_matches(_PLAIN, value))


def used(text: str, reads: str, typeset: bool = False) -> str:
    """Convert text such as "150000.0 MPa" to the unit that users read, a key of READ or of SPELT.

    typeset: as on the page
    """
    number, _, unit = text.partition(" ")
    if not unit or not {unit, reads} & {*USUAL, *SPELT, *READ}:
        return text
    factor, page = READ.get(reads) or (1.0, spelling(unit).page)
    words = page if typeset else reads if reads in READ else unit
    return f"{plain(factor * float(number), 9)}{chr(160) if typeset else ' '}{words}"


def _matches(pattern, value):
    if isinstance(value, str) and len(value) <= _LONGEST:
        return pattern.fullmatch(value.strip())
    return None


def _number(value):
    if not is_plain(value):
        raise ValueError("is not a plain number")
    try:
        return float(value)
    except OverflowError:  # of an int; text beyond the range is inf
        return math.inf


def _quantity(value, target):
    if is_plain(value):
        raise ValueError("has no unit")
    match = _matches(_QUANTITY, value)
    if not match:
        raise ValueError("is not a number with a unit")
    return _convert(Decimal(match[1]), match[2].strip(), target)


def _converted(number, own, target):
    """Convert a float in a unit as packages for units, or CF, spell it; inf and NaN stay."""
    if not math.isfinite(number):
        return number
    own = of_file(own)
    if not _matches(re.compile(_UNIT, re.ASCII), own):
        raise ValueError(f"has an unknown unit, {show(own)}")
    return _convert(Decimal(repr(number)), own, target)


def _convert(number, unit, target):
    if target == "%":  # decibels have no dimension either
        if unit != "%" or not 0 < number < 100:
            raise ValueError("is not between 0 % and 100 %")
        return float(number / 100)
    if target == "degC" and unit in ("degC", "K"):
        return float(number - _ZERO if unit == "K" else number)
    # The product is rounded once: 2330 kg/m^3 is exactly the float 0.00233.
    return float(_ARITHMETIC.multiply(number, _factor(unit, target)))


def _factor(unit, target):
    """Give the size of a unit in units of `target`; a ValueError says what is wrong with it."""
    usual = USUAL.get(target, {target: "1"})
    return Decimal(usual[unit]) if unit in usual else by_pint(unit, target)


@cache
def by_pint(unit: str, target: str) -> Decimal:
    """Give the size of any unit in units of `target`, by pint; ValueError as of `_factor`."""
    registry = _registry()
    try:
        wanted, root_wanted = registry.get_root_units(registry.parse_units(target))
        parsed = registry.parse_units(f"1{unit}" if unit.startswith("/") else unit)
        factor, root = registry.get_root_units(parsed)
    except Exception:  # pint lets errors of a dozen types through
        raise ValueError(f"has an unknown unit, {show(unit)}") from None
    # Other scales of temperature have another zero.
    if root.dimensionality != root_wanted.dimensionality or target == "degC":
        raise ValueError(f"does not convert to {target}")
    # Radians, turns and counts have no dimension: pint would take 1 rad/s for 1 Hz.
    if root != root_wanted:
        raise ValueError(f"counts angles or events, which is not {target} (1 Hz is 2 pi rad/s)")
    # Pint's own factor carries noise (1 kg = 999999999999.9999 ng); 14 digits shed it.
    return Decimal(f"{factor / wanted:.14g}")


@cache
def _registry():
    with needing("a unit"):
        import pint  # imported late: it takes as long as all else

    return pint.UnitRegistry()

"""The conversion of text with a unit to internal units: um, ng, us; frequencies stay in Hz."""

import math
import re
from collections.abc import Mapping
from decimal import Context, Decimal
from functools import cache

from ..device.quantities import KINDS, bounds_of
from ..files.extras import needing

LEAST, MOST = 1e-15, 1e15
"""Least and largest size of a value but 0, in internal units; larger ones would overflow later."""
WORDS = {("contact", "hard"): math.inf, ("body", "none"): 0.0}
"""Numbers behind values that are a word, by kind and word."""
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

# Pint evaluates arithmetic such as 9**9**9: a unit reaches it only if it has the form below.
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = r"[A-Za-z\u00b5\u03bc%]+(?: *(?:\^|\*\*) *-?\d|[²³])?"  # both the micro sign and mu
_UNIT = rf"(?:(?<= )1 *(?=/))?(/? *{_FACTOR}(?:(?: *[*/] *| +){_FACTOR})*)"
_PLAIN = re.compile(_NUMBER, re.ASCII)
_QUANTITY = re.compile(rf"({_NUMBER}) *{_UNIT}", re.ASCII)
_LONGEST = 60
_ZERO = Decimal("273.15")
_ARITHMETIC = Context(prec=40, traps=[])


def read(value: object, kind: str) -> float:
    """Convert a value of the config to the internal unit of its kind, a key of KINDS.

    Raises ValueError, one line: the value, what is wrong with it, and what would be right.
    """
    if isinstance(value, str) and (kind, value) in WORDS:
        return WORDS[kind, value]
    name, unit, example, interval = KINDS[kind]
    try:
        number = _quantity(value, unit) if unit else _number(value)
        if not math.isfinite(number):
            raise ValueError("is not finite")
        if not bounds_of(interval).holds(number):
            raise ValueError(f"is not {bounds_of(interval)}")
        least = LEAST if unit else 0.0
        if number and not least <= abs(number) <= MOST:
            raise ValueError(f"is not between {least:g} and {MOST:g} {unit}".rstrip())
    except ValueError as error:
        raise ValueError(f"{show(value)} {error}; write {name} such as {example}") from None
    return number


FEW = 4
"""Most items of a list or mapping that a message shows."""


def show(value: object, longest: int = _LONGEST) -> str:
    """Quote a value for a message, in one line; text of more than `longest` signs is cut."""
    if isinstance(value, Mapping):
        keys = f" of {', '.join(map(show, value))}" if 0 < len(value) <= FEW else ""
        return f"a mapping{keys}"
    if isinstance(value, list | tuple):
        if any(isinstance(item, Mapping | list | tuple) for item in value) or len(value) > FEW:
            return "a list"
        return f"the list {', '.join(map(show, value))}" if value else "an empty list"
    if value is None or isinstance(value, bool):
        return {None: "an empty value", True: "true", False: "false"}[value]
    text = repr(value)
    return text if len(text) <= longest else f"{text[:40]}...{text[-1]}"


def _is_plain(value):
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number or _matches(_PLAIN, value)


def unit_of(value: object, kind: str) -> tuple[str, float]:
    """Give the unit of a value that `read` takes: its spelling, and its size in internal units."""
    target, match = KINDS[kind].unit, _matches(_QUANTITY, value)
    return (unit := match[2].strip(), float(_factor(unit, target))) if match else (target, 1.0)


def _matches(pattern, value):
    if isinstance(value, str) and len(value) <= _LONGEST:
        return pattern.fullmatch(value.strip())
    return None


def _number(value):
    if not _is_plain(value):
        raise ValueError("is not a plain number")
    try:
        return float(value)
    except OverflowError:  # of an int; text beyond the range is inf
        return math.inf


def _quantity(value, target):
    if _is_plain(value):
        raise ValueError("has no unit")
    match = _matches(_QUANTITY, value)
    if not match:
        raise ValueError("is not a number with a unit")
    number, unit = Decimal(match[1]), match[2].strip()
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
    usual = USUAL.get(target, {})
    return Decimal(usual[unit]) if unit in usual else by_pint(unit, target)


@cache
def by_pint(unit: str, target: str) -> Decimal:
    """Give the size of any unit in units of `target`, by pint; ValueError as of `_factor`."""
    registry = _registry()
    wanted, root_wanted = registry.get_root_units(registry.parse_units(target))
    try:
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
    with needing("a config"):
        import pint  # imported late: it takes as long as all else

    return pint.UnitRegistry()

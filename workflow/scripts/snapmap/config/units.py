"""Text with a unit to a number in internal units: um, ng, us; frequencies stay in Hz."""

import math
import re
from collections.abc import Mapping
from decimal import Context, Decimal
from functools import cache

from ..io.extras import needing
from ..quantities import KINDS

LEAST, MOST = 1e-15, 1e15
"""In internal units: no device has values beyond, and they would overflow further on."""

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

    Raises ValueError with one line: the value, what is wrong, what would be right.
    """
    if not KINDS[kind].unit:
        return _read_number(value, KINDS[kind])
    if kind == "contact" and value == "hard":
        return math.inf
    if kind == "body" and value == "none":
        return 0.0
    return _read_quantity(value, KINDS[kind])


def show(value: object, longest: int = _LONGEST) -> str:
    """Quote a value in a message, in one short line; text longer than that is cut."""
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list" if value else "an empty list"
    if value is None or isinstance(value, bool):
        return {None: "an empty value", True: "true", False: "false"}[value]
    text = repr(value)
    return text if len(text) <= longest else f"{text[:40]}...{text[-1]}"


def _read_number(value, kind):
    if not _is_number(value) and not _matches(_PLAIN, value):
        raise _fault(value, "is not a plain number", kind)
    try:
        number = float(value)
    except OverflowError:  # of an int; text beyond the range is inf
        number = math.inf
    if not math.isfinite(number):
        raise _fault(value, "is not finite", kind)
    if abs(number) > MOST:
        raise _fault(value, f"is not between {-MOST:g} and {MOST:g}", kind)
    _check_sign(value, number, kind)
    return number


def _read_quantity(value, kind):
    if _is_number(value) or _matches(_PLAIN, value):
        raise _fault(value, "has no unit", kind)
    match = _matches(_QUANTITY, value)
    if not match:
        raise _fault(value, "is not a number with a unit", kind)
    number, unit = match.groups()
    if kind.unit == "degC":
        return _read_temperature(value, number, unit, kind)
    if kind.unit == "%":
        return _read_share(value, number, unit, kind)
    try:
        factor = _factor(unit, kind.unit)
    except ValueError as error:
        raise _fault(value, str(error), kind) from None
    # The product is rounded once: 2330 kg/m^3 is exactly the float 0.00233.
    result = float(_ARITHMETIC.multiply(Decimal(number), factor))
    if not math.isfinite(result):
        raise _fault(value, "is not finite", kind)
    _check_sign(value, result, kind)
    if result and not LEAST <= abs(result) <= MOST:
        raise _fault(value, f"is not between {LEAST:g} and {MOST:g} {kind.unit}", kind)
    return result


def _check_sign(value, number, kind):
    if (number < 0 and not kind.signed) or (number == 0 and not kind.zero):
        raise _fault(value, "is negative" if kind.zero else "is not positive", kind)


def _read_temperature(value, number, unit, kind):
    """Of the two scales with an offset between them."""
    found = Decimal(number)
    if unit.strip() == "K":
        found -= _ZERO
    elif unit.strip() != "degC":
        try:
            _factor(unit, "K")
        except ValueError as error:
            raise _fault(value, str(error), kind) from None
        raise _fault(value, "does not convert to degC here", kind)
    if not -_ZERO < found <= MOST:
        raise _fault(value, f"is not above {-_ZERO} degC", kind)
    return float(found)


def _read_share(value, number, unit, kind):
    """Percent to a fraction; decibels have no dimension either, so the sign itself is asked for."""
    share = float(Decimal(number) / 100)
    if unit.strip() != "%" or not 0 < share < 1:
        raise _fault(value, "is not between 0 % and 100 %", kind)
    return share


def _is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool)


def _matches(pattern, value):
    if isinstance(value, str) and len(value) <= _LONGEST:
        return pattern.fullmatch(value.strip())
    return None


def _fault(value, complaint, kind):
    return ValueError(f"{show(value)} {complaint}; write {kind.name} such as {kind.example}")


@cache
def _factor(unit, target):
    """How many `target` make one `unit`; ValueError says what is wrong with `unit`."""
    registry = _registry()
    wanted, root_wanted = registry.get_root_units(registry.parse_units(target))
    try:
        unit_given = registry.parse_units(f"1{unit}" if unit.startswith("/") else unit)
        given, root_given = registry.get_root_units(unit_given)
    except Exception:  # pint lets errors of a dozen types through
        raise ValueError(f"has an unknown unit, {show(unit)}") from None
    if root_given.dimensionality != root_wanted.dimensionality:
        raise ValueError(f"does not convert to {target}")
    # Radians, turns and counts have no dimension: pint would take 1 rad/s for 1 Hz.
    if root_given != root_wanted:
        raise ValueError(f"counts angles or events, which is not {target} (1 Hz is 2 pi rad/s)")
    # Pint's own factor carries noise (1 kg = 999999999999.9999 ng); 14 digits shed it.
    return Decimal(f"{given / wanted:.14g}")


@cache
def _registry():
    with needing("a config"):
        import pint  # imported late: it takes as long as all else

    return pint.UnitRegistry()

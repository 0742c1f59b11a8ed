"""The unit of C, which a user's own law of damping may state for all that follows its cells."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from .kinds import Quantity, Single

INTERNAL = "uN*us/um"
"""Unit of C of the device's own damper."""
_UNIT = ContextVar("unit_of_C", default=INTERNAL)


@contextmanager
def damper_in(unit_of_C: str) -> Iterator[None]:
    """Give the context in which C counts in a unit, as a config spells it; "" for a number."""
    token = _UNIT.set(unit_of_C)
    try:
        yield
    finally:
        _UNIT.reset(token)


class Damper(Quantity):
    """C, or several, in the unit of the context."""

    unit = property(lambda self: _UNIT.get())
    example = property(lambda self: f"25 {self.unit}".rstrip())

    def __init__(self):
        vars(self).update(noun="a damper constant", interval="[0, inf)", words=(), reads="")


class SingleDamper(Damper, Single):
    """A single C."""

"""The physical kinds of values: the only place that says what a length is."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from os.path import exists
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ..files.text import is_title
from .arguments import Reading
from .kinds import Fitting, Number, Quantity, Several, Whole, Word
from .units import OF_DAMPER

Value = Any
"""A number, an array, or text with a unit; a record has made numbers of it."""
if TYPE_CHECKING:
    LeftOut = Any
else:
    LeftOut = None
"""None, in place of which a record puts what follows from its other values."""
single = partial(Quantity, is_single=True)
"""A kind of single numbers."""


class OfDamper(Quantity):
    """Dampers, in the unit that a reading has for C."""

    def under(self, reading: Reading) -> Quantity:
        """Give the kind in that unit."""
        unit = reading.unit_of_C
        if unit == self.unit:
            return self
        # Not a kind of its own, which would have the unit of the next reading.
        written = unit, f"25 {unit}".rstrip()
        return Quantity(self.noun, *written, self.interval, is_single=self.is_single)

    def convert(self, value: object, reading: Reading) -> Number:
        """Convert in that unit."""
        kind = self.under(reading)
        return kind.read(value) if reading.written else kind.take(value)


def _is_there(value):
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


_LINE = "a line of letters, digits, spaces, .,:()/%+-_, at most 60"
_SIGNS = {"type": "string", "maxLength": 60}
Title = Annotated[str, Fitting(_LINE, is_title, json=_SIGNS)]
ExistingPath = Annotated[str | PathLike, Fitting("the path of a file that is there", _is_there)]

# fmt: off
# ruff: noqa: E501, as a kind is one line
Length = Annotated[Value, Quantity("a length", "um", "600 um")]
Distance = Annotated[Value, Quantity("a length", "um", "0.5 um", "[0, inf)")]
Gap = Annotated[Value, Quantity("a length", "um", "1 um", "[0, inf]")]
Position = Annotated[Value, Quantity("a length", "um", "-5 um", "[-inf, inf)")]
Travel = Annotated[Value, Quantity("a length", "um", "14 um", "(0, inf]")]
Modulus = Annotated[Value, Quantity("a modulus", "MPa", "150 GPa", reads="GPa")]
Stress = Annotated[Value, Quantity("a stress", "MPa", "-11 MPa", "(-inf, inf)")]
Strength = Annotated[Value, Quantity("a stress", "MPa", "1.5 GPa", "(0, inf]")]
LeastStrength = Annotated[Value, Quantity("a stress", "MPa", "1.446 GPa", "[0, inf)")]
Density = Annotated[Value, Quantity("a density", "ng/um^3", "2330 kg/m^3", reads="kg/m^3")]
Rate = Annotated[Value, Quantity("a damping rate", "1/us", "4e-4 /us", "[0, inf)")]
Mass = Annotated[Value, Quantity("a mass", "ng", "1e-8 kg", "(0, inf)", (("none", 0.0),), "ug")]
Stiffness = Annotated[Value, Quantity("a stiffness", "uN/um", "5.5 N/m", reads="N/m")]
Clamp = Annotated[Value, Quantity("a stiffness", "uN/um", "20 kN/m", "(0, inf]", reads="N/m")]
Contact = Annotated[Value, Quantity("a stiffness", "uN/um", "40 N/m", "(0, inf]", (("hard", np.inf),), "N/m")]
Acceleration = Annotated[Value, Quantity("an acceleration", "um/us^2", "9.81 m/s^2", reads="m/s^2")]
Force = Annotated[Value, Quantity("a force", "uN", "1 uN", "[0, inf)")]
Temperature = Annotated[Value, Quantity("a temperature", "degC", "85 degC", "(-273.15, inf)")]
Expansion = Annotated[Value, Quantity("a change per kelvin", "1/K", "-63e-6 /K", "(-inf, inf)")]
Part = Annotated[Number, Quantity("a plain number", "", "0.1", "(-inf, inf)")]
Exponent = Annotated[Number, Quantity("a plain number", "", "0.7", "(-inf, inf)")]
WeibullModulus = Annotated[Number, Quantity("a plain number", "", "10", "(0, inf]")]
Restitution = Annotated[Number, Quantity("a plain number", "", "0.5", "[0, 1]")]
Quality = Annotated[Number, single("a plain number", "", "250")]

Share = Annotated[Value, single("a share", "%", "10 %", "(0, 1)")]
Duration = Annotated[Value, single("a duration", "us", "1500 us", "[0, inf)")]
PulseTime = Annotated[Value, single("a duration", "us", "0.5 ms")]
Height = Annotated[Value, single("a length", "um", "1 m")]
Fraction = Annotated[float, single("a plain number", "", "1e-3", "(0, 1)")]
Refinement = Annotated[float, single("a plain number", "", "1e-4", "[1e-9, 0.01]")]
Positive = Annotated[float, single("a plain number")]

_N = single("a multiple of gravity without a unit", "", "1000", "[0, inf)")
_F0 = single("a frequency", "Hz", "1500 Hz")
_C = OfDamper("a damper constant", OF_DAMPER, f"25 {OF_DAMPER}", "[0, inf)", is_single=True)
Amplitude = Annotated[float, _N]
Frequency = Annotated[Value, _F0]
Damper = Annotated[Value, _C]
Amplitudes = Annotated[float | Sequence[float] | np.ndarray, Several(replace(_N, is_single=False))]
Frequencies = Annotated[Value, Several(replace(_F0, is_single=False))]
Dampers = Annotated[Value, Several(replace(_C, is_single=False))]
PulseTimes = Annotated[Value, Several(Quantity("a duration", "us", "0.5 ms"))]

Truth = Annotated[bool, Word((True, False))]
Count = Annotated[int, Whole(1, 100)]
Modes = Annotated[int, Whole(1, 200)]
Threads = Annotated[int, Whole(1, 1024)]
Seed = Annotated[int, Whole(0, 2**32 - 1)]

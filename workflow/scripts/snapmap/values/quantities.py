"""The physical kinds of values: the only place that says what a length is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from typing_extensions import TypeAliasType

from . import damper
from .kinds import Flag, Number, Quantity, Several, Single, Whole

Value = Any
"""A number, an array, or text with a unit; a record has made numbers of it."""
if TYPE_CHECKING:
    LeftOut = Any
else:
    LeftOut = None
"""None, in place of which a record puts what follows from its other values."""


# fmt: off
# ruff: noqa: E501, as a kind is one line
Length = TypeAliasType("Length", Annotated[Value, Quantity("a length", "um", "600 um")])
Distance = TypeAliasType("Distance", Annotated[Value, Quantity("a length", "um", "0.5 um", "[0, inf)")])
Gap = TypeAliasType("Gap", Annotated[Value, Quantity("a length", "um", "1 um", "[0, inf]")])
Position = TypeAliasType("Position", Annotated[Value, Quantity("a length", "um", "-5 um", "[-inf, inf)")])
Travel = TypeAliasType("Travel", Annotated[Value, Quantity("a length", "um", "14 um", "(0, inf]")])
Modulus = TypeAliasType("Modulus", Annotated[Value, Quantity("a modulus", "MPa", "150 GPa", reads="GPa")])
Stress = TypeAliasType("Stress", Annotated[Value, Quantity("a stress", "MPa", "-11 MPa", "(-inf, inf)")])
Strength = TypeAliasType("Strength", Annotated[Value, Quantity("a stress", "MPa", "1.5 GPa", "(0, inf]")])
LeastStrength = TypeAliasType("LeastStrength", Annotated[Value, Quantity("a stress", "MPa", "1.446 GPa", "[0, inf)")])
Density = TypeAliasType("Density", Annotated[Value, Quantity("a density", "ng/um^3", "2330 kg/m^3", reads="kg/m^3")])
Rate = TypeAliasType("Rate", Annotated[Value, Quantity("a damping rate", "1/us", "4e-4 /us", "[0, inf)")])
Mass = TypeAliasType("Mass", Annotated[Value, Quantity("a mass", "ng", "1e-8 kg", "(0, inf)", (("none", 0.0),), "ug")])
Stiffness = TypeAliasType("Stiffness", Annotated[Value, Quantity("a stiffness", "uN/um", "5.5 N/m", reads="N/m")])
Clamp = TypeAliasType("Clamp", Annotated[Value, Quantity("a stiffness", "uN/um", "20 kN/m", "(0, inf]", reads="N/m")])
Contact = TypeAliasType("Contact", Annotated[Value, Quantity("a stiffness", "uN/um", "40 N/m", "(0, inf]", (("hard", np.inf),), "N/m")])
Acceleration = TypeAliasType("Acceleration", Annotated[Value, Quantity("an acceleration", "um/us^2", "9.81 m/s^2", reads="m/s^2")])
Force = TypeAliasType("Force", Annotated[Value, Quantity("a force", "uN", "1 uN", "[0, inf)")])
Temperature = TypeAliasType("Temperature", Annotated[Value, Quantity("a temperature", "degC", "85 degC", "(-273.15, inf)")])
Expansion = TypeAliasType("Expansion", Annotated[Value, Quantity("a change per kelvin", "1/K", "-63e-6 /K", "(-inf, inf)")])
Part = TypeAliasType("Part", Annotated[Number, Quantity("a plain number", "", "0.1", "(-inf, inf)")])
Exponent = TypeAliasType("Exponent", Annotated[Number, Quantity("a plain number", "", "0.7", "(-inf, inf)")])
WeibullModulus = TypeAliasType("WeibullModulus", Annotated[Number, Quantity("a plain number", "", "10", "(0, inf]")])
Restitution = TypeAliasType("Restitution", Annotated[Number, Quantity("a plain number", "", "0.5", "[0, 1]")])
Quality = TypeAliasType("Quality", Annotated[Number, Single("a plain number", "", "250")])

Share = TypeAliasType("Share", Annotated[Value, Single("a share", "%", "10 %", "(0, 1)")])
Duration = TypeAliasType("Duration", Annotated[Value, Single("a duration", "us", "1500 us", "[0, inf)")])
PulseTime = TypeAliasType("PulseTime", Annotated[Value, Single("a duration", "us", "0.5 ms")])
Height = TypeAliasType("Height", Annotated[Value, Single("a length", "um", "1 m")])
Fraction = TypeAliasType("Fraction", Annotated[float, Single("a plain number", "", "1e-3", "(0, 1)")])
Refinement = TypeAliasType("Refinement", Annotated[float, Single("a plain number", "", "1e-4", "[1e-9, 0.01]")])
Positive = TypeAliasType("Positive", Annotated[float, Single("a plain number")])

_N = Single("a multiple of gravity without a unit", "", "1000", "[0, inf)")
_F0 = Single("a frequency", "Hz", "1500 Hz")
Amplitude = TypeAliasType("Amplitude", Annotated[float, _N])
Frequency = TypeAliasType("Frequency", Annotated[Value, _F0])
Damper = TypeAliasType("Damper", Annotated[Value, damper.SingleDamper()])
Amplitudes = TypeAliasType("Amplitudes", Annotated[float | Sequence[float] | np.ndarray, Several(Quantity(**vars(_N)))])
Frequencies = TypeAliasType("Frequencies", Annotated[Value, Several(Quantity(**vars(_F0)))])
Dampers = TypeAliasType("Dampers", Annotated[Value, Several(damper.Damper())])
PulseTimes = TypeAliasType("PulseTimes", Annotated[Value, Several(Quantity("a duration", "us", "0.5 ms"))])

Truth = TypeAliasType("Truth", Annotated[bool, Flag()])
Count = TypeAliasType("Count", Annotated[int, Whole(1, 100)])
Modes = TypeAliasType("Modes", Annotated[int, Whole(1, 200)])
Threads = TypeAliasType("Threads", Annotated[int, Whole(1, 1024)])
Seed = TypeAliasType("Seed", Annotated[int, Whole(0, 2**32 - 1)])

"""Quantities of a device and its shock, and their units.

To add a value of the device, add a line to quantities.csv, a field to `device.py` or
`curved_beam.py`, and its physics. Units, attributes in files, words in figures and on the page, and
keys of the config follow.
"""

import csv
from collections.abc import Iterator, Mapping
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Bounds(NamedTuple):
    """An interval of numbers; low_fits, high_fits: whether its ends belong to it."""

    low: float
    high: float
    low_fits: bool
    high_fits: bool

    def holds(self, values: np.ndarray) -> np.ndarray:
        """Return whether each value is in the interval; NaN is not."""
        above = np.greater(values, self.low) | (self.low_fits & np.equal(values, self.low))
        return above & (np.less(values, self.high) | (self.high_fits & np.equal(values, self.high)))

    def __str__(self):
        """Write the interval in words that follow a noun."""
        ends = []
        if self.low_fits and self.high_fits:
            return f"from {self.low:.10g} to {self.high:.10g}"
        if self.low > -inf:
            ends.append(f"{'from' if self.low_fits else 'above'} {self.low:.10g}")
        if self.high < inf:
            ends.append(f"{'up to' if self.high_fits else 'below'} {self.high:.10g}")
        return " and ".join(ends)


def bounds_of(text: str) -> Bounds:
    """Read an interval such as "[0, inf)"."""
    low, high = (float(end) for end in text[1:-1].split(","))
    return Bounds(low, high, text[0] == "[", text[-1] == "]")


def plain(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits, without an exponent if it is not extreme."""
    return f"{float(f'{value:.{digits}g}'):.12g}"


class Dimension(NamedTuple):
    """A kind of value: its name with article, internal unit, an example, and an interval."""

    name: str
    unit: str
    example: str
    interval: str = "(0, inf)"


KINDS = {
    "number": Dimension("a multiple of gravity without a unit", "", "1000", "[0, inf)"),
    "quality": Dimension("a plain number", "", "250"),
    "length": Dimension("a length", "um", "'600 um'"),
    "modulus": Dimension("a modulus", "MPa", "'150 GPa'"),
    "distance": Dimension("a length", "um", "'0.5 um'", "[0, inf)"),
    "position": Dimension("a length", "um", "'-5 um'", "(-inf, inf)"),
    "strength": Dimension("a stress", "MPa", "'1.5 GPa'"),
    "stress": Dimension("a stress", "MPa", "'-11 MPa'", "(-inf, inf)"),
    "density": Dimension("a density", "ng/um^3", "'2330 kg/m^3'"),
    "rate": Dimension("a damping rate", "1/us", "'4e-4 /us'", "[0, inf)"),
    "mass": Dimension("a mass", "ng", "'1e-8 kg'"),
    "body": Dimension("a mass", "ng", "'1e-8 kg', or the word none"),
    "stiffness": Dimension("a stiffness", "uN/um", "'5.5 N/m'"),
    "contact": Dimension("a stiffness", "uN/um", "'40 N/m', or the word hard", "(0, inf]"),
    "acceleration": Dimension("an acceleration", "um/us^2", "'9.81 m/s^2'"),
    "force": Dimension("a force", "uN", "'1 uN'"),
    "frequency": Dimension("a frequency", "Hz", "'1500 Hz'"),
    "damper": Dimension("a damper constant", "uN*us/um", "'25 uN*us/um'", "[0, inf)"),
    "temperature": Dimension("a temperature", "degC", "'85 degC'", "(-273.15, inf)"),
    "expansion": Dimension("a change per kelvin", "1/K", "'-63e-6 /K'", "(-inf, inf)"),
    "part": Dimension("a plain number", "", "0.1", "(-inf, inf)"),
    "exponent": Dimension("a plain number", "", "0.7", "(-inf, inf)"),
    "restitution": Dimension("a plain number", "", "0.5", "[0, 1]"),
    "share": Dimension("a share", "%", "'0.1 %'", "(0, 1)"),
    "duration": Dimension("a duration", "us", "'1500 us'", "[0, inf)"),
    "pulse": Dimension("a duration", "us", "'0.5 ms'"),
}


class Unit(NamedTuple):
    """How an internal unit is spelt in files, in figures and on the page."""

    files: str
    figures: str
    page: str


SPELT = {
    "": Unit("1", "", ""),
    "Hz": Unit("Hz", "Hz", "Hz"),
    "MPa": Unit("MPa", "MPa", "MPa"),
    "ng": Unit("ng", "ng", "ng"),
    "um": Unit("um", "µm", "µm"),
    "uN": Unit("uN", "µN", "µN"),
    "us": Unit("us", "µs", "µs"),
    "degC": Unit("degC", "°C", "°C"),
    "1/K": Unit("K-1", "K$^{-1}$", "1/K"),
    "ng/um^3": Unit("ng um-3", "ng µm$^{-3}$", "ng/µm³"),
    "1/us": Unit("us-1", "µs$^{-1}$", "1/µs"),
    "uN/um": Unit("uN um-1", "N/m", "N/m"),
    "uN*us/um": Unit("uN us um-1", "µN µs µm$^{-1}$", "µN\u00a0µs/µm"),
}
"""Units by their spelling in a config."""
USED = {
    "youngs_modulus": (1e-3, "GPa", "GPa"),
    "density": (1e6, "kg/m^3", "kg/m³"),
    "mass": (1e-3, "ug", "µg"),
    "gravity": (1e6, "m/s^2", "m/s²"),
    **dict.fromkeys(("spring", "contact", "clamp_axial"), (1.0, "N/m", "N/m")),
}
"""Factor, unit, and spelling on the page, of quantities that users read in another unit."""


class Quantity(NamedTuple):
    """A value of the device or of its shock, or another axis of a study.

    kind: a key of KINDS; "" if the values are names
    left_out: value that a written config omits; NaN for none; a quantity with it is listed last
    long_name: in files; "" if the quantity cannot be an axis
    words: short name in figures; label: name along an axis, if it differs
    symbol: in the drawing of the device
    usual: range, in internal units, beyond which a value is probably a slip
    key: in the config, below `device`; what, example, default: its line in docs/config.md; a key
        without a default is required
    """

    name: str
    kind: str = ""
    left_out: float | None = None
    long_name: str = ""
    words: str = ""
    label: str = ""
    symbol: str = ""
    usual: tuple[float, float] = (-inf, inf)
    key: str = ""
    what: str = ""
    example: str = ""
    default: str = ""

    @property
    def range(self) -> Bounds:
        """Range of the values, with the one that a written config omits."""
        low, high, low_fits, high_fits = bounds_of(KINDS[self.kind].interval)
        silent = self.left_out
        return Bounds(low, high, low_fits or silent == low, high_fits or silent == high)

    @property
    def unit(self) -> str:
        """The internal unit, as a config spells it."""
        return KINDS[self.kind].unit if self.kind else ""

    @property
    def spelt(self) -> Unit:
        """The internal unit, as files, figures and the page spell it."""
        return SPELT[self.unit]

    def used(self, text: str, typeset: bool = False) -> str:
        """Convert text such as "2 um" to the unit that users read; typeset: as on the page."""
        number, _, unit = text.partition(" ")
        if not self.unit or unit != self.unit:
            return text
        factor, *spelt = USED.get(self.name) or (1.0, unit, self.spelt.page)
        return f"{plain(factor * float(number), 9)}{chr(160) if typeset else ' '}{spelt[typeset]}"

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the coordinate in a file."""
        units = {"units": self.spelt.files} if self.kind else {}
        return {"long_name": self.long_name} | units


def _quantity(left_out, usual, **words):
    between = tuple(map(float, usual.split(" to "))) if usual else (-inf, inf)
    return Quantity(left_out=float(left_out) if left_out else None, usual=between, **words)


with open(Path(__file__).with_suffix(".csv"), encoding="utf-8") as _file:
    QUANTITIES = {row["name"]: _quantity(**row) for row in csv.DictReader(_file)}
"""Quantities by name, in the order in which figures name them."""


def keys_of(section: str) -> dict[str, str]:
    """Return the names of values, by their keys in a section of the device such as beam.clamp."""
    places = {quantity.key: name for name, quantity in QUANTITIES.items() if quantity.key}
    parts = {place.rpartition("."): name for place, name in places.items()}
    return {key: name for (path, _, key), name in parts.items() if path == section}


def leaves(section: Mapping, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the path of each key in a section of a config, and its value as text."""
    for key, value in section.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", str(value)

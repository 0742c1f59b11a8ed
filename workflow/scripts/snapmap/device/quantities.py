"""What a device and its shock are described by: one line for each quantity, and their units.

A value of the device is a line in QUANTITIES, a field in `device.py`, and its physics: units,
attributes in files, words in figures and on the page, and the keys of the config follow.
"""

from math import inf
from typing import NamedTuple

import numpy as np


class Bounds(NamedTuple):
    """Numbers between two ends; low_fits, high_fits: whether these are among them."""

    low: float
    high: float
    low_fits: bool
    high_fits: bool

    def holds(self, values: np.ndarray) -> np.ndarray:
        """Whether values are in it; NaN is not."""
        above = np.greater(values, self.low) | (self.low_fits & np.equal(values, self.low))
        return above & (np.less(values, self.high) | (self.high_fits & np.equal(values, self.high)))

    def __str__(self):
        """In words that follow a noun."""
        ends = []
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
    """A number to so many digits, without an exponent where it is an ordinary one."""
    return f"{float(f'{value:.{digits}g}'):.12g}"


class Dimension(NamedTuple):
    """What a key expects: its name with article, internal unit, an example, and an interval."""

    name: str
    unit: str
    example: str
    interval: str = "(0, inf)"


KINDS = {
    "number": Dimension("a multiple of gravity without a unit", "", "1000", "(-inf, inf)"),
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
"""By their spelling in a config."""
USED = {
    "youngs_modulus": (1e-3, "GPa", "GPa"),
    "density": (1e6, "kg/m^3", "kg/m³"),
    "mass": (1e-3, "ug", "µg"),
    "gravity": (1e6, "m/s^2", "m/s²"),
    **dict.fromkeys(("spring", "contact", "clamp_axial"), (1.0, "N/m", "N/m")),
}
"""Factor and unit, and its spelling on the page, of what is read in other units than internal."""


class Quantity(NamedTuple):
    """A value of the device, or of its shock, or what else an axis may have.

    kind: a key of KINDS, none if its values are names; long_name: in files, of what can be an axis
    words: in figures, in short; label: there along an axis, if not the words
    symbol: in the drawing of the device
    left_out: of which value a recipe is silent, NaN for none; the config then lists it last
    usual: beyond these, internal units, it is hardly meant
    """

    name: str
    kind: str = ""
    left_out: float | None = None
    long_name: str = ""
    words: str = ""
    label: str = ""
    symbol: str = ""
    usual: tuple[float, float] = (-inf, inf)

    @property
    def range(self) -> Bounds:
        """Of its values, with that of which a recipe is silent."""
        low, high, low_fits, high_fits = bounds_of(KINDS[self.kind].interval)
        silent = self.left_out
        return Bounds(low, high, low_fits or silent == low, high_fits or silent == high)

    @property
    def unit(self) -> str:
        """The internal unit, as a config spells it."""
        return KINDS[self.kind].unit if self.kind else ""

    @property
    def spelt(self) -> Unit:
        """The internal unit elsewhere."""
        return SPELT[self.unit]

    def used(self, text: str, typeset: bool = False) -> str:
        """A value of a config in its internal unit as users read it; other text as it is.

        typeset: as on the page
        """
        number, _, unit = text.partition(" ")
        if not self.unit or unit != self.unit:
            return text
        factor, *spelt = USED.get(self.name) or (1.0, unit, self.spelt.page)
        return f"{plain(factor * float(number), 9)}{chr(160) if typeset else ' '}{spelt[typeset]}"

    @property
    def attributes(self) -> dict[str, str]:
        """Of a coordinate in a file."""
        units = {"units": self.spelt.files} if self.kind else {}
        return {"long_name": self.long_name} | units


def _quantity(line):
    cells = [cell.strip() for cell in line.split("|")]
    name, kind, left_out, *words, usual = cells + [""] * (8 - len(cells))
    silent = float(left_out) if left_out else None
    return Quantity(name, kind, silent, *words, bounds_of(f"[{usual or '-inf, inf'}]")[:2])


_LINES = """\
device | | | device | device
span | length | | span of the beam | span | | L
rise | length | | rise of the beam | rise | | δ
thickness | length | | thickness of the beam | thickness | | t
depth | length | | depth of the beam | depth
youngs_modulus | modulus | | Young's modulus | Young's modulus | | | 1e3, 1.3e6
density | density | | density of the beam | density | | | 1e-4, 0.025
damping | rate | | damping rate of the beam itself | damping of the beam
residual_stress | stress | 0 | residual stress of the beam, tension > 0 | residual stress
imperfection | distance | 0 | antisymmetric imperfection of the beam | imperfection
clamp_axial | stiffness | inf | stiffness of each clamp along the beam | stiffness of the clamps
cosine_2 | part | 0 | cosine 2 in the beam's shape as made, over the rise | cosine 2 of the shape
cosine_3 | part | 0 | cosine 3 in the beam's shape as made, over the rise | cosine 3 of the shape
cosine_4 | part | 0 | cosine 4 in the beam's shape as made, over the rise | cosine 4 of the shape
cosine_5 | part | 0 | cosine 5 in the beam's shape as made, over the rise | cosine 5 of the shape
mass | mass | | mass that strikes the beam | mass | | M | 0, 1e9
spring | stiffness | | stiffness of the mass's spring | spring | | K
contact | contact | | stiffness of the contact | contact
gap | distance | 0 | gap between mass and beam at rest | gap
stop_toward | length | inf | travel to the stop towards the beam | stop towards the beam
stop_away | length | inf | travel to the stop away from the beam | stop away from the beam
restitution | restitution | nan | share of speed that a stop leaves it | restitution of the stops
temperature | temperature | 20 | temperature of the device | temperature
reference_temperature | temperature | nan
modulus_slope | expansion | 0
expansion_mismatch | expansion | 0
damper_exponent | exponent | 0
strength | strength | inf
strength_modulus | quality | inf
strength_threshold | strength | 0
contact_at | position | -inf
gravity | acceleration | | | | | | 1e-7, 1e-3
force | force | 0
shape | | | shape of the pulse | | shape of the pulse
direction | | | direction of the frame; +z presses the mass down | along | direction of the shock
C | damper | | damping coefficient of the mass | $C$ | damping of the mass $C$
f0 | frequency | | frequency of the pulse | $f_0$ | pulse frequency $f_0$
duration | pulse | | | pulse duration $1/f_0$
N | number | | amplitude of the pulse, multiples of g | $N$ | pulse amplitude $N$
"""
QUANTITIES = {quantity.name: quantity for quantity in map(_quantity, _LINES.splitlines())}
"""By their names, in the order in which figures name them; the fields of each by its line."""

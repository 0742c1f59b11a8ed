"""The points of a spectrum: pairs of a frequency and a level."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...files.text import describe
from ...pulse.pulse import G
from ...values.arguments import Reading
from ...values.faults import Faults, few
from ...values.kinds import Kind, kind_of
from ...values.quantities import Frequency, single
from ...values.units import is_plain

LEAST = 2
"""Least number of points."""
MS2 = 1e-6 / G
LEVELS = {"g": 1.0, "gn": 1.0, "m/s^2": MS2}
DENSITIES = {"g^2/Hz": 1.0, "g2/Hz": 1.0, "gn^2/Hz": 1.0}
DENSITIES |= dict.fromkeys(("(m/s^2)^2/Hz", "m^2/s^4/Hz", "m^2/s^3"), MS2 * MS2)
"""Factors to multiples of standard gravity, and to their squares in 1 Hz, by unit."""
_LEVEL = re.compile(r"(\S*[\d.]) *([gm(].*)")


@dataclass(frozen=True)
class Points(Kind):
    """Points of a spectrum, which ascend; levels are numbers in the first of the units, or text."""

    noun: str
    units: Mapping[str, float]
    example: str
    type = list[tuple[float, float]]

    @property
    def need(self) -> str:  # type: ignore[override]
        """What is right in Python, in words that follow "is not"."""
        of = "Hz and multiples of g" if "g" in self.units else "Hz and g^2/Hz"
        return f"two pairs or more of {of}, above 0 and ascending, such as {self.example}"

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a list of two pairs or more of a frequency and a {self.noun}, above 0, ascending"

    def convert(self, value: object, reading: Reading) -> np.ndarray:
        """Convert pairs to an array, (points, 2); of Python also an array."""
        pairs = value.tolist() if isinstance(value, np.ndarray) else value
        if not isinstance(pairs, list | tuple) or len(pairs) < LEAST:
            raise self.refuse(value, reading)
        points, faults = [], []
        for place, item in enumerate(pairs):
            if not (isinstance(item, list | tuple) and len(item) == 2):
                faults.append(f"[{place}]: {describe(item)} is not a pair")
                continue
            for inner, convert in enumerate((kind_of(Frequency).convert, self._level)):
                try:
                    points.append(convert(item[inner], reading))
                except ValueError as error:
                    faults.append(f"[{place}][{inner}]: {error}")
        if faults:
            raise Faults(*few(faults))
        made: np.ndarray = np.reshape(points, (-1, 2))
        if not ((made > 0).all() and (np.diff(made[:, 0]) > 0).all()):
            raise ValueError(f"frequencies and levels are not {self.wants(reading)}")
        return made

    def schema(self) -> dict:
        """Describe a list of pairs."""
        pair = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": pair, "minItems": LEAST}

    def _level(self, value, reading):
        """Convert text with a unit, or a number of Python."""
        if not (reading.written or isinstance(value, str)):
            return single(f"a {self.noun}").take(value)
        match = _LEVEL.fullmatch(value.strip()) if isinstance(value, str) else None
        number, unit = match.groups() if match else ("", "")
        unit = unit.replace("**", "^").replace("²", "^2").replace(" ", "")
        if not is_plain(number) or unit not in self.units:
            lacks = "has no unit" if is_plain(value) else "is not a number with a unit"
            such = ", ".join(self.units)
            raise ValueError(f"{describe(value)} {lacks}; write a {self.noun} in one of {such}")
        return float(number) * self.units[unit]

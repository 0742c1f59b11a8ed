"""The points of a spectrum: pairs of a frequency and a level."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...files.text import describe
from ...pulse.pulse import G
from ...values.faults import Faults, few
from ...values.kinds import CONFIG, Kind, kind_of
from ...values.quantities import Frequency, single
from ...values.units import is_plain, plain_numbers

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
        return f"a list of two pairs or more of a frequency and a {self.noun}, ascending"

    def take(self, value: object) -> np.ndarray:
        """Convert pairs to an array, (points, 2)."""
        if isinstance(value, list | tuple) and all(_is_pair(item) for item in value):
            value = [[kind_of(Frequency).take(f), self._taken(level)] for f, level in value]
        points = plain_numbers(value)
        if points is None or points.ndim != 2 or points.shape[1] != 2 or len(points) < LEAST:
            raise self.refuse(value)
        if not (np.isfinite(points).all() and (points > 0).all() and _ascends(points)):
            raise self.refuse(value)
        return points

    def read(self, value: object) -> np.ndarray:
        """Read a list of pairs."""
        if not isinstance(value, list) or len(value) < LEAST:
            raise self.refuse(value, CONFIG)
        points, faults = [], []
        for place, item in enumerate(value):
            if not _is_pair(item):
                faults.append(f"[{place}]: {describe(item)} is not a pair")
                continue
            for inner, read in enumerate((kind_of(Frequency).read, self._level)):
                try:
                    points.append(read(item[inner]))
                except ValueError as error:
                    faults.append(f"[{place}][{inner}]: {error}")
        if faults:
            raise Faults(*few(faults))
        pairs: np.ndarray = np.reshape(points, (-1, 2))
        if not ((pairs > 0).all() and _ascends(pairs)):
            raise ValueError(f"frequencies and levels are not {self.asks} above 0")
        return pairs

    def schema(self) -> dict:
        """Describe a list of pairs."""
        pair = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": pair, "minItems": LEAST}

    def _taken(self, level):
        """Take a number, or text with a unit."""
        kind = single(f"a {self.noun}")
        return self._level(level) if isinstance(level, str) else kind.take(level)

    def _level(self, value):
        """Convert text with a unit."""
        match = _LEVEL.fullmatch(value.strip()) if isinstance(value, str) else None
        number, unit = match.groups() if match else ("", "")
        unit = unit.replace("**", "^").replace("²", "^2").replace(" ", "")
        if not is_plain(number) or unit not in self.units:
            lacks = "has no unit" if is_plain(value) else "is not a number with a unit"
            such = ", ".join(self.units)
            raise ValueError(f"{describe(value)} {lacks}; write a {self.noun} in one of {such}")
        return float(number) * self.units[unit]


def _is_pair(item):
    return isinstance(item, list | tuple) and len(item) == 2


def _ascends(points):
    return (np.diff(points[:, 0]) > 0).all()

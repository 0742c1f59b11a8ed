"""The points of a spectrum: pairs of a frequency and a level."""

from dataclasses import dataclass

import numpy as np

from ...files.text import describe, show
from ...values.faults import Faults, few
from ...values.kinds import CONFIG, Kind, kind_of
from ...values.quantities import Frequency, single
from ...values.units import is_plain, plain_numbers

LEAST = 2
"""Least number of points."""


@dataclass(frozen=True)
class Points(Kind):
    """Points of a spectrum, which ascend; levels have a unit that only text has."""

    noun: str
    unit: str
    example: str
    type = list[tuple[float, float]]

    @property
    def need(self) -> str:  # type: ignore[override]
        """What is right in Python, in words that follow "is not"."""
        of = f"Hz and {'multiples of g' if self.unit == 'g' else self.unit}"
        return f"two pairs or more of {of}, above 0 and ascending, such as {self.example}"

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a list of two pairs or more of a frequency and a {self.noun}, ascending"

    def take(self, value: object) -> np.ndarray:
        """Convert pairs to an array, (points, 2)."""
        if isinstance(value, list | tuple) and all(_is_pair(item) for item in value):
            value = [[kind_of(Frequency).take(f), self._level(level)] for f, level in value]
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

    def _level(self, value):
        """Convert a level, a number or text with the unit."""
        number, _, written = str(value).strip().partition(" ")
        is_text = isinstance(value, str)
        if is_text and (written.replace("²", "^2").replace("**", "^") != self.unit):
            raise ValueError(
                f"{show(value)} is not a {self.noun}; write one such as '1 {self.unit}'"
            )
        if is_text and not is_plain(number):
            raise ValueError(f"{show(value)} is not a {self.noun}")
        return single(f"a {self.noun}").take(float(number) if is_text else value)


def _is_pair(item):
    return isinstance(item, list | tuple) and len(item) == 2


def _ascends(points):
    return (np.diff(points[:, 0]) > 0).all()

"""Kinds of the arguments that several public functions share."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated

import numpy as np
from typing_extensions import TypeAliasType

from ..device.device import VALUES, Device
from ..files.text import show
from ..pulse.shocks import Directions, Pulses
from ..solver.settings import STARTS
from ..values.faults import at_key
from ..values.kinds import Fitting, Kind, Quantity, Several, Word, kind_of
from ..values.quantities import Frequency, Positive, Share, Truth
from .axes import KIND_OF
from .study import ANY, ARRIVES, DevicesKind, Study


class StudyKind(Kind):
    """A study; a device, or several by name, are taken as a study of them."""

    need = f"a Study, or {DevicesKind.need}"

    def take(self, value: object) -> Study:
        """Give the study."""
        if isinstance(value, Study):
            return value
        if not isinstance(value, Device | Mapping):
            raise ValueError(f"{show(value)} is not {self.need}")
        return Study(DevicesKind().take(value))


class SingleKind(StudyKind):
    """A study of a single device, under a single shape and direction."""

    need = "a Study of a single Device, or a Device; load_device reads one"

    def take(self, value: object) -> Study:
        """Give the study."""
        study = super().take(value)
        if isinstance(study.device, Mapping):
            raise ValueError(f"{show(study.device)} is not {self.need}")
        if len(study.shocks.pulses) > 1:
            raise ValueError(".pulse: has several shapes or directions; write one of each")
        return study


class AxesKind(Kind):
    """Values of the device, or several, by name."""

    need = 'a mapping of values of the device, such as {"thickness": [1.9, 2.0]}'

    def take(self, value: object) -> dict[str, np.ndarray]:
        """Give a row, (n,), by name."""
        if not isinstance(value, Mapping):
            raise ValueError(f"{show(value)} is not {self.need}")
        axes = {}
        for key, row in value.items():
            with at_key(key):
                if key not in VALUES:
                    near = get_close_matches(str(key), VALUES, 1)
                    hint = f"; did you mean {near[0]}?" if near else ""
                    raise ValueError(f"is not a value of the device that can vary{hint}")
                axes[key] = Several(KIND_OF[key]).take(row)
        return axes


def pair_of(key: str, ends: object) -> tuple[float, float]:
    """Convert low and high end of a value of the device, or of C; ValueError, in one line."""
    row = Quantity.take(KIND_OF[key], ends)  # of C, too, whose kind is single
    if np.shape(row) != (2,):
        raise ValueError(f"{show(ends)} is not a pair of numbers, low and high")
    return tuple(row.tolist())


class SnapsKind(Kind):
    """Whether a device must trip: true, false, or one of two words."""

    need = 'True, False, "arrives" or "any"'

    def take(self, value: object) -> bool | str:
        """Give true, false or the word."""
        if isinstance(value, bool | np.bool_):
            return bool(value)
        if not isinstance(value, str) or value not in (ANY, ARRIVES):
            raise ValueError(f"{show(value)} is not {self.need}")
        return value


OF_REQUIREMENT = {
    "name": Fitting("text", lambda value: isinstance(value, str)),
    "N": kind_of(Positive),
    "f0": kind_of(Frequency),
    "snaps": SnapsKind(),
    "pulse": kind_of(Pulses),
    "direction": kind_of(Directions),
    "start": Word(STARTS),
    "survives": kind_of(Truth),
    "share": kind_of(Share),
    "confidence": kind_of(Share),
}
"""Kind of each value of a requirement."""


class RequirementsKind(Kind):
    """Required shocks, as mappings."""

    need = 'a list of mappings of name, N, f0 (Hz) and snaps (True, False, "arrives" or "any")'

    def take(self, value: object) -> list[dict]:
        """Convert N, f0 and the words of each mapping."""
        if not isinstance(value, list | tuple):
            raise ValueError(f"{show(value)} is not {self.need}")
        taken = []
        for place, item in enumerate(value):
            with at_key(place):
                taken.append(self._one(item))
        return taken

    def _one(self, item):
        if not isinstance(item, Mapping) or not {"name", "N", "f0", "snaps"} <= item.keys():
            raise ValueError(f"{show(item)} is not {self.need}")
        taken = {}
        for key, given in item.items():
            with at_key(key):
                if key not in OF_REQUIREMENT:
                    raise ValueError(f"unknown key; known are {', '.join(OF_REQUIREMENT)}")
                taken[key] = OF_REQUIREMENT[key].take(given)
        return taken


AnyStudy = TypeAliasType("AnyStudy", Annotated[Study | Device | Mapping[str, Device], StudyKind()])
SingleStudy = TypeAliasType("SingleStudy", Annotated[Study | Device, SingleKind()])
Axes = TypeAliasType("Axes", Annotated[Mapping[str, float | str | Sequence], AxesKind()])
Requirements = TypeAliasType("Requirements", Annotated[Sequence[Mapping], RequirementsKind()])

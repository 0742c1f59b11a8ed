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
from ..values.faults import line_at
from ..values.kinds import Kind, Quantity, Several, Word, kind_of
from ..values.quantities import Frequency, Positive, Truth
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
            if key not in VALUES:
                near = get_close_matches(str(key), VALUES, 1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise ValueError(f".{key}: is not a value of the device that can vary{hint}")
            try:
                axes[key] = Several(KIND_OF[key]).take(row)
            except ValueError as error:
                raise ValueError(f".{key}: {error}") from None
        return axes


def pair_of(key: str, ends: object) -> tuple[float, float]:
    """Convert low and high end of a value of the device, or of C; ValueError, in one line."""
    row = Quantity.take(KIND_OF[key], ends)  # of C, too, whose kind is single
    if np.shape(row) != (2,):
        raise ValueError(f"{show(ends)} is not a pair of numbers, low and high")
    return tuple(row.tolist())


OF_REQUIREMENT = {
    "N": kind_of(Positive),
    "f0": kind_of(Frequency),
    "pulse": kind_of(Pulses),
    "direction": kind_of(Directions),
    "start": Word(STARTS),
    "survives": kind_of(Truth),
}
"""Kinds of the values of a requirement, but for `name` and `snaps`."""


class RequirementsKind(Kind):
    """Required shocks, as mappings."""

    need = 'a list of mappings of name, N, f0 (Hz) and snaps (True, False, "arrives" or "any")'

    def take(self, value: object) -> list[dict]:
        """Convert N, f0 and the words of each mapping."""
        if not isinstance(value, list | tuple):
            raise ValueError(f"{show(value)} is not {self.need}")
        return [self._one(place, item) for place, item in enumerate(value)]

    def _one(self, place, item):
        if not isinstance(item, Mapping) or not {"name", "N", "f0", "snaps"} <= item.keys():
            raise ValueError(f"[{place}]: {show(item)} is not {self.need}")
        item, name = dict(item), item["name"]
        if not isinstance(name, str):
            raise ValueError(f"[{place}].name: {show(name)} is not text")
        for key in item:
            if key not in ("name", "snaps", *OF_REQUIREMENT):
                known = ", ".join(OF_REQUIREMENT)
                raise ValueError(f"[{place}].{key}: unknown key; known are name, snaps, {known}")
        for key in OF_REQUIREMENT.keys() & item.keys():
            try:
                item[key] = OF_REQUIREMENT[key].take(item[key])
            except ValueError as error:
                raise ValueError(line_at((place, key), str(error))) from None
        snaps = item["snaps"]
        if not isinstance(snaps, bool | np.bool_) and snaps not in (ANY, ARRIVES):
            raise ValueError(
                f'[{place}].snaps: {show(snaps)} is not True, False, "arrives" or "any"'
            )
        return item | {"snaps": snaps if isinstance(snaps, str) else bool(snaps)}


AnyStudy = TypeAliasType("AnyStudy", Annotated[Study | Device | Mapping[str, Device], StudyKind()])
SingleStudy = TypeAliasType("SingleStudy", Annotated[Study | Device, SingleKind()])
Axes = TypeAliasType("Axes", Annotated[Mapping[str, float | str | Sequence], AxesKind()])
Requirements = TypeAliasType("Requirements", Annotated[Sequence[Mapping], RequirementsKind()])

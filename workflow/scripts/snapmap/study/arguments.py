"""Kinds of the arguments that several public functions share."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated

import numpy as np
from typing_extensions import TypeAliasType

from ..device.device import VALUES, Device
from ..files.text import show
from ..values.kinds import Kind, Several
from .axes import KIND_OF
from .study import DevicesKind, Study


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


AnyStudy = TypeAliasType("AnyStudy", Annotated[Study | Device | Mapping[str, Device], StudyKind()])
SingleStudy = TypeAliasType("SingleStudy", Annotated[Study | Device, SingleKind()])
Axes = TypeAliasType("Axes", Annotated[Mapping[str, float | str | Sequence], AxesKind()])

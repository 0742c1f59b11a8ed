"""What must, or must not, trip a device: an object that checks itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ...study.study import ANY, CLOSING, Study


class Required(Protocol):
    """A requirement: a shock, a vibration, a spectrum.

    values: `name`, `snaps`, and what else its kind has
    """

    values: Mapping

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts on each device at each temperature and C (uN us/um), with what stands beside."""

    def require(self, study: Study) -> None:
        """Raise ValueError, one line, where a study cannot have it."""

    def plain(self) -> dict:
        """It in plain values, on which its verdicts depend."""


@dataclass(frozen=True, eq=False)
class RequiredShock:
    """A required shock; values: as `check.check` takes them, with survives and closing demands."""

    values: dict

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts, with strength and electrode, as `verdicts_of` has them."""
        from .verdicts import verdicts_of

        temperatures, tolerance = study.temperatures, study.threshold_tolerance
        return verdicts_of(study, [self.values], C, temperatures, tolerance)

    def require(self, study: Study) -> None:
        """Raise ValueError where a device lacks the electrode, strength or frame that it needs."""
        devices = study.devices().values()
        closing = next((key for key in CLOSING if key in self.values), None)
        if closing and not any(device.has_electrode for device in devices):
            need = "write the place of the electrode, such as '-5 um'"
            raise ValueError(f"device.contact_at: missing, for {closing}; {need}")
        unbreakable = any(np.isinf(device.strength) for device in devices)
        if self.values["snaps"] == ANY and not closing and unbreakable:
            need = "write one such as '1.2 GPa', or closes_within in the requirement"
            name = self.values["name"]
            raise ValueError(f"device.strength: missing, for snaps: any of {name}; {need}")
        replace(study, shocks=self.values["shocks"])  # a force shakes no frame

    def plain(self) -> dict:
        """All but the shocks themselves, which follow from `pulse`."""
        return {key: value for key, value in self.values.items() if key != "shocks"}

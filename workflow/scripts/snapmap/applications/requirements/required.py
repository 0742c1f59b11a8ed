"""What must, or must not, trip a device: an object that checks itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from ...study.study import ANY, Study
from .corners import at_corner


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
    """A required shock.

    values: as `check.check` takes them, with survives
    more: what it demands beside the trip and the strength, in a word
    """

    values: dict
    more: ClassVar = ""

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts by thresholds and strength, with what else is seen of each shock."""
        from ..histories.history import observed_of
        from .check import check, judge

        required, judged = self.values, []
        how = study.threshold_tolerance, study.temperatures
        for verdict in check(study, [required], C, *how):
            shaken = at_corner(study, required, verdict._asdict())
            seen = observed_of(shaken, verdict.N, verdict.f0, verdict.C)
            stress, must_survive = seen["stress_max"], required["survives"]
            verdict, survival = judge(verdict, shaken.device, stress, must_survive)
            judged.append((verdict, seen | survival._asdict()))
        return judged

    def require(self, study: Study) -> None:
        """Raise ValueError where a device lacks the strength or frame that it needs."""
        unbreakable = any(np.isinf(device.strength) for device in study.devices().values())
        if self.values["snaps"] == ANY and not self.more and unbreakable:
            what = f"snaps: any of {self.values['name']}"
            raise ValueError(f"device.strength: missing, for {what}; write one such as '1.2 GPa'")
        replace(study, shocks=self.values["shocks"])  # a force shakes no frame

    def plain(self) -> dict:
        """All but the shocks themselves, which follow from `pulse`."""
        return {key: value for key, value in self.values.items() if key != "shocks"}

"""Requirements of a study, objects that check themselves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from ...study.study import ANY, Study
from .corners import at_corner


class Required(Protocol):
    """A requirement: a shock, a vibration, or a spectrum.

    values: `name`, `snaps`, and further values of its kind
    """

    values: Mapping

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Judge each device at each temperature and C (uN us/um).

        Returns pairs of a Verdict and a mapping of further columns of its row.
        """

    def require(self, study: Study) -> None:
        """Raise ValueError, one line, if the study cannot have this requirement."""

    def plain(self) -> dict:
        """Plain values on which the verdicts depend."""


@dataclass(frozen=True, eq=False)
class RequiredShock:
    """A required shock.

    values: as `check.check` takes them, with survives
    more: a word for what its kind demands beside trip and survival; empty for nothing
    """

    values: dict
    more: ClassVar = ""

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Judge by threshold and strength; the further columns are extremes and survival."""
        from ..histories.history import free_travel, observed_of
        from .check import check, judge

        required, judged = self.values, []
        how = study.threshold_tolerance, study.temperatures
        for verdict in check(study, [required], C, *how):
            shaken = at_corner(study, required, verdict._asdict())
            columns = observed_of(shaken, verdict.N, verdict.f0, verdict.C)
            moved = columns["toward_max"], columns["away_max"]
            columns["travel_over_rise"] = free_travel(shaken.device, *moved)
            stress, must_survive = columns["stress_max"], required["survives"]
            verdict, survival = judge(verdict, shaken.device, stress, must_survive)
            judged.append((verdict, columns | survival._asdict()))
        return judged

    def require(self, study: Study) -> None:
        """Raise ValueError if a device lacks a strength or frame that the requirement needs."""
        unbreakable = any(np.isinf(device.strength) for device in study.devices().values())
        if self.values["snaps"] == ANY and not self.more and unbreakable:
            what = f"snaps: any of {self.values['name']}"
            raise ValueError(f"device.strength: missing, for {what}; write one such as '1.2 GPa'")
        replace(study, shocks=self.values["shocks"])  # a force shakes no frame

    def plain(self) -> dict:
        """All values but the shocks, which follow from `pulse`."""
        return {key: value for key, value in self.values.items() if key != "shocks"}

"""Requirements of a study, objects that check themselves."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from ...study.shock import Shock
from ...study.study import ANY
from ..application import Config
from .verdict import Verdict, at_corner


class Required(Protocol):
    """A requirement: a shock, a vibration, or a spectrum; start: as in `Run`."""

    @property
    def name(self) -> str: ...

    @property
    def start(self) -> str: ...

    def check(self, study: Config, C: Sequence[float]) -> list[Verdict]:
        """Judge each device at each temperature and C (uN us/um)."""

    def require(self, study: Config) -> None:
        """Raise ValueError, one line, if the study cannot have this requirement."""

    def plain(self) -> dict[str, Any]:
        """Plain values on which the verdicts depend."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RequiredShock(Shock):
    """A required shock of a config.

    more: a word for what its kind demands beside trip and survival; empty for nothing
    """

    more: ClassVar[str] = ""

    def check(self, study: Config, C: Sequence[float]) -> list[Verdict]:
        """Judge by threshold and strength."""
        from ..histories.history import free_travel, observed_of
        from .check import check, judge

        judged, how = [], (study.threshold_tolerance, study.temperatures)
        for verdict in check(study, [self], C, *how):
            shaken = at_corner(study, self, verdict)
            extremes, more = observed_of(shaken, verdict.N, verdict.f0, verdict.C)
            moved = extremes.toward_max, extremes.away_max
            travel = free_travel(shaken.device, *moved)
            found = replace(verdict, **extremes._asdict(), travel_over_rise=travel, more=more)
            judged.append(judge(found, shaken.device, self.survives))
        return judged

    def require(self, study: Config) -> None:
        """Raise ValueError if a device lacks what the requirement needs, or a batch its scatter."""
        if self.share and not study.requests.get("tolerances"):
            need = "write what scatters, such as tolerances: {thickness: 3 %}"
            raise ValueError(f"share of {self.name}: needs devices as made; {need}")
        unbreakable = any(np.isinf(device.strength) for device in study.devices().values())
        if self.snaps == ANY and not self.more and unbreakable:
            what = f"snaps: any of {self.name}"
            raise ValueError(f"device.strength: missing, for {what}; write one such as '1.2 GPa'")
        study.under(self.shocks)  # a force shakes no frame

    def plain(self) -> dict[str, Any]:
        """All values, the shocks as they are written."""
        return asdict(self) | {"shocks": self.shocks.values()}

"""The section `requirements`: shocks that must, or must not, trip the device."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, asdict, dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from ...config.shocks import TIMED, PulseSection, Push, SeveralShapes
from ...config.study import require_start
from ...files.text import show
from ...pulse.shocks import each_form
from ...study.shock import Demand, Shock
from ...study.study import ANY
from ...values.arguments import Reading, one_time
from ...values.faults import at_key
from ...values.kinds import Kind, kind_of
from ...values.quantities import Positive
from ...values.records import build, record, told
from ..application import Config
from .verdict import Verdict, at_corner


class Required(Protocol):
    """A requirement: a shock, a vibration, or a spectrum; start: as in `Run`.

    It must be met under each pulse of `shocks`.
    """

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


@record
class ShockSection(PulseSection, Demand):
    """A shock that must, or must not, trip the device.

    A requirement holds at every temperature of the sweep. Its shape and direction are those of
    `pulse` unless it has its own; of several it holds under each.
    """

    kind: ClassVar[type[RequiredShock]] = RequiredShock
    _: KW_ONLY
    shape: SeveralShapes | None = None  # type: ignore[assignment]
    """how the acceleration goes over time; several all count; that of `pulse` if left out"""
    direction: Push | None = None
    """+z presses the mass on the beam; that of `pulse` if left out"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find keys that are missing, or that exclude each other."""
        return super().beside(written) | one_time(written, any(name in written for name in TIMED))

    def __post_init__(self):
        """Raise ValueError for what cannot be in any study."""
        if self.snaps == ANY and not (self.survives or self.kind.more):
            need = "true or false, or survives"
            raise ValueError(f"snaps: any leaves nothing to check; write {need}")

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredShock:
        """Make the requirement of a study.

        pulse: section of the study, whose shape and direction hold unless this section has its own
        gravity: of its devices, um/us^2, the unit of N
        """
        shocks = self.shocks_from(self._inheriting(pulse))
        if self.N is None and self.drop is None:
            raise ValueError(f".N: missing; write {kind_of(Positive).asks}")
        return self.shock(self.kind, shocks, shocks.pulse.peak / gravity if self.drop else 0.0)

    def _inheriting(self, pulse):
        """Values of its pulse; shape, shares and direction that it lacks are those of the study's.

        So are those of a drop, and of the blows of a train.
        """
        own, of_study = self.of_pulse(), pulse.of_pulse() if pulse else {}
        direction = {"direction": own.pop("direction", of_study.get("direction", "+z"))}
        timed = next((name for name in TIMED if name in of_study), "")
        if self.drop or self.train:
            forms = each_form(told(of_study["drop"]) if timed == "drop" else of_study)
            return self._of_blows(forms) | direction
        if "shape" in own or "file" in own:
            return own | direction
        if timed:
            raise ValueError(
                f".shape: missing, as the study's {timed} sets its own duration; write a "
                f"shape such as half sine, or the {timed}"
            )
        return of_study | own | direction

    def _of_blows(self, forms):
        """Drop or train, whose blows without a shape have the one of the study; forms: all."""
        key, blows = ("drop", [self.drop]) if self.drop else ("train", self.train)
        lack = [blow.duration is not None and blow.shape is None for blow in blows]
        if any(lack) and len(forms) > 1:
            raise ValueError(f".{key}: shape missing, as the study has several; write one of them")
        whole = [
            (forms[0] if lacks else {}) | told(blow)
            for blow, lacks in zip(blows, lack, strict=True)
        ]
        return {key: whole[0] if self.drop else whole}


class RequirementKind(Kind):
    """A requirement of one of several kinds."""

    need = "a mapping: a shock that must, or must not, trip the device"

    def __init__(self, kinds: Mapping[str, type]):
        """Take the records, by a key that only they have."""
        self.kinds = kinds
        self.records = (ShockSection, *dict.fromkeys(kinds.values()))

    def convert(self, value: object, reading: Reading) -> Any:
        """Make a requirement by its kind."""
        if not isinstance(value, Mapping):
            raise self.refuse(value, reading)
        found = (self.kinds[key] for key in self.kinds if key in value)
        return build(next(found, ShockSection), value, reading)


def read_requirements(
    sections: Sequence[Any], study: Config, pulse: PulseSection | None
) -> list[Required]:
    """Take the requirements of a config; raises ValueError, one line, for an invalid one.

    pulse: the study's section `pulse`, or None
    """
    names = [section.name for section in sections]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"{show(twice)} comes twice; write another name")
    gravity, requirements = float(next(iter(study.devices().values())).gravity), []
    for place, section in enumerate(sections):
        with at_key(place):
            required = section.under(pulse, gravity)
            for device in study.devices().values():
                require_start(required.start, device)
        requirements.append(required)
    if requirements:
        temperatures = study.temperatures
        study.set_out({"temperature": temperatures} if temperatures else {})
    for required in requirements:
        required.require(study)
    return requirements

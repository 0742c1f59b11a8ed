"""A shock under which a device must, or must not, snap."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, TypeVar

from ..numerics.statistics import CONFIDENCE
from ..pulse.shocks import Directions, Pulses, Shocks
from ..solver.settings import FIRST, STARTS
from ..values.arguments import Reading, one_time
from ..values.kinds import Kind, Word, kind_of
from ..values.quantities import Frequency, Positive, PulseTime, Share, Title
from ..values.records import record
from .axes import frequency_of
from .study import ANY, ARRIVES, Study

# ASSUME: of devices whose strengths scatter all but one in a thousand must survive.
SURVIVES = 0.999
Start = Annotated[str, Word(STARTS)]
Snaps = Annotated[bool | str, Word((True, False, ARRIVES, ANY))]
SnapsOrArrives = Annotated[bool | str, Word((True, False, ARRIVES))]


@dataclass(frozen=True, eq=False, kw_only=True)
class Shock:
    """A required shock.

    N: multiples of g; f0: Hz; shocks: shapes and directions, under each of which it counts
    snaps: true (the beam must arrive and stay), false, ARRIVES, or ANY
    survives: least probability that the beam must not break; start: as in `Run`
    share: least share of a batch that must meet it, with this confidence; 0 if none is asked
    """

    name: str
    N: float
    f0: float
    shocks: Shocks
    snaps: bool | str
    survives: float = 1.0
    start: str = FIRST
    share: float = 0.0
    confidence: float = CONFIDENCE

    def shaken(self, study: Study) -> Study:
        """Give a study under this shock, with its own pulses and start."""
        return study.but(start=self.start).under(self.shocks)


class SurvivesKind(Kind):
    """True, false or a share: whether, or how probably, the beam must not break."""

    need = "true, false or a share such as 99.99 %"

    def convert(self, value: object, reading: Reading) -> float:
        """Give the least probability with which the beam must not break; 0 if it may."""
        if isinstance(value, bool):
            return SURVIVES * value
        return kind_of(Share).convert(value, reading)

    def write(self, value: float) -> object:
        """Write a share."""
        return kind_of(Share).write(value)

    def schema(self) -> dict:
        """Describe the choice."""
        return {"anyOf": [{"type": "boolean"}, kind_of(Share).schema()]}


Made = TypeVar("Made", bound=Shock)


@record
class Demand:
    """What a required shock demands, in Python and in a config."""

    _: KW_ONLY
    name: Title
    """unique name"""
    N: Positive | None = None
    """peak of the shock over gravity; required, except for a drop"""
    snaps: Snaps
    """whether the device must trip and stay tripped; `arrives`: it must reach its other shape, if
    only for a moment; `any`: either is right"""
    survives: Annotated[float, SurvivesKind()] = SURVIVES
    """least probability that the beam does not break; true is 99.9 %, false is 0"""
    share: Share | None = None
    """least share of the devices as made (`tolerances`) that must meet it, such as 99.9 %"""
    confidence: Share = CONFIDENCE
    """confidence that the share must be known with"""
    f0: Frequency | None = None
    """1/duration of the shock; required, or `duration`, or a shock with its own"""
    duration: PulseTime | None = None
    """duration of the shock; replaces f0"""
    start: Start | None = None
    """shape in which the beam rests at first; the first if left out"""

    def shock(self, made: type[Made], shocks: Shocks, peak: float, start: str = FIRST) -> Made:
        """Make a required shock; peak, start: N and start that count if none is written."""
        f0 = self.f0 if self.duration is None else frequency_of(self.duration)
        return made(
            name=self.name,
            N=self.N or peak,
            f0=f0 or shocks.own_frequency(),
            shocks=shocks,
            snaps=self.snaps,
            survives=self.survives,
            start=self.start or start,
            share=self.share or 0.0,
            confidence=self.confidence,
        )


@record
class Requirement(Demand):
    """a shock under which the device must, or must not, snap."""

    pulse: Pulses | None = None
    """the shock; that of the study if left out"""
    direction: Directions | None = None
    """direction of the frame; that of the study if left out"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find N missing, and f0 and duration missing, or beside each other."""
        needs = {} if "N" in written else {"N": f"missing; write {kind_of(Positive).need}"}
        return needs | one_time(written)

    def under(self, shocks: Shocks, start: str = FIRST) -> Shock:
        """Make the shock, by default with shocks and start of its study."""
        if self.pulse is None and any(pulse.duration for pulse in shocks.shapes.values()):
            raise ValueError(
                f"requirements: {self.name}: pulse: missing, as the study's pulse sets its own "
                "duration; write a shape such as 'half sine'"
            )
        own = Shocks(self.pulse or shocks.pulse, self.direction or shocks.direction)
        return self.shock(Shock, own, 0.0, start)

"""A shock under which a device must, or must not, snap."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from ..numerics.statistics import CONFIDENCE
from ..pulse.shocks import Directions, Pulses, Shocks
from ..solver.settings import FIRST, STARTS
from ..values.kinds import Word
from ..values.quantities import Frequency, Positive, PulseTime, Share, Truth
from ..values.records import record
from .axes import frequency_of, one_time
from .study import ANY, ARRIVES, Study

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


@record
class Requirement:
    """a shock under which the device must, or must not, snap."""

    name: str
    """unique name"""
    N: Positive
    """peak of the shock over gravity"""
    snaps: Snaps
    """whether the device must trip and stay tripped; `arrives`, `any`: as in a config"""
    f0: Frequency | None = None
    """1/duration of the shock, Hz"""
    duration: PulseTime | None = None
    """duration of the shock, us; replaces f0"""
    pulse: Pulses | None = None
    """the shock; that of the study if left out"""
    direction: Directions | None = None
    """direction of the frame; that of the study if left out"""
    start: Start | None = None
    """shape in which the beam rests at first"""
    survives: Truth = True
    """whether the beam must not break"""
    share: Share | None = None
    """least share of devices that must meet it"""
    confidence: Share = CONFIDENCE
    """how sure that share must be"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find f0 and duration missing, or beside each other."""
        return one_time(written)


def take_shock(asked: Requirement, shocks: Shocks, start: str = FIRST) -> Shock:
    """Take a requirement, by default with shocks and start of its study."""
    if asked.pulse is None and any(pulse.duration for pulse in shocks.shapes.values()):
        raise ValueError(
            f"requirements: {asked.name}: pulse: missing, as the study's pulse sets its own "
            "duration; write a shape such as 'half sine'"
        )
    return Shock(
        name=asked.name,
        N=asked.N,
        f0=asked.f0 or frequency_of(asked.duration),
        shocks=Shocks(asked.pulse or shocks.pulse, asked.direction or shocks.direction),
        snaps=asked.snaps,
        survives=float(asked.survives),
        start=asked.start or start,
        share=asked.share or 0.0,
        confidence=asked.confidence,
    )

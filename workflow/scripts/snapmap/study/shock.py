"""A shock under which a device must, or must not, snap."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..numerics.statistics import CONFIDENCE
from ..pulse.shocks import Shocks, make_shocks
from ..solver.settings import FIRST
from .study import Study


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
        return replace(study, run=study.run.but(start=self.start)).under(self.shocks)


def take_shock(requirement: Mapping, shocks: Shocks, start: str = FIRST) -> Shock:
    """Take a requirement as Python gives it, by default with shocks and start of its study."""
    given = {"pulse": shocks.pulse, "direction": shocks.direction, "start": start} | requirement
    if "pulse" not in requirement and any(pulse.duration for pulse in shocks.shapes.values()):
        raise ValueError(
            f"requirements: {given['name']}: pulse: missing, as the study's pulse sets its own "
            "duration; write a shape such as 'half sine'"
        )
    return Shock(shocks=make_shocks(given.pop("pulse"), given.pop("direction")), **given)

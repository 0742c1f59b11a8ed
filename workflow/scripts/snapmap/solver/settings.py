"""Settings of the runs of a study."""

from dataclasses import KW_ONLY, fields
from functools import lru_cache
from typing import Literal, Self

from ..values.quantities import Duration, Fraction, Threads, Truth
from ..values.records import assemble, record

SNAP, EDGE, STAY, CALM, MOVE = QUESTIONS = ("snap", "edge", "stay", "calm", "move")
"""Questions to a run, by which its time step is chosen: does the beam snap, from which N on, where
does it stay, and once it has lost its energy, how does it move."""
SHOWN = "shown"
QUESTION = dict(settled=SNAP, snap=SNAP, edge=EDGE, end=EDGE, moved=MOVE, shown=MOVE)
"""The question of a run, by `until`. The solver knows four words beside those of `Run`: "edge" and
"end" are "snap" and "settled" in the steps that a threshold needs, "moved" is "settled" in the
steps that the motion needs, and "shown" is "moved" with all quiet time."""
TO_THE_END = ("settled", "end")
"""Values of `until` of runs that go on in the steps of STAY once they have snapped."""
FIRST, SECOND = STARTS = ("first", "second")
"""The shape in which the beam rests at first; it snaps when it arrives at the other."""
THRESHOLD_TOLERANCE = 1e-4
"""Default relative width to which thresholds in N are refined."""


@record
class Run:
    """How each cell is followed."""

    _: KW_ONLY
    horizon: Duration = 1500.0
    """time followed after the pulse's end"""
    until: Literal["settled", "snap"] = "settled"
    """when a run ends: once it has settled, or, with `snap`, already at its snap"""
    repeat: Truth | None = None
    """whether each cell runs again with another time step, to see if it ends alike; by default, if
    `until` is `settled`"""
    energy_tolerance: Fraction = 1e-3
    """largest residual of the energy ledger over the pulse's gross work; above it a run is repeated
    in half its step, and counts as failed in the end"""
    start: Literal["first", "second"] = "first"
    """shape in which the beam rests at first"""
    threads: Threads = 1
    """number of threads, which change no result"""

    @property
    def repeats(self) -> bool:
        """Whether cells run again."""
        return self.until == "settled" if self.repeat is None else self.repeat

    @property
    def question(self) -> str:
        """The one of QUESTIONS that the runs answer."""
        return QUESTION[self.until]

    def but(self, **values: object) -> Self:
        """Return the same with other values; `until` may be any word of QUESTION."""
        if type(self) is Run:
            return _with(self, tuple(values.items()))
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        return assemble(type(self), own | values)

    @property
    def run(self) -> "Run":
        """These values alone."""
        return assemble(Run, {key: getattr(self, key) for key in OF_RUN})

    def section(self) -> dict:
        """Return the section of a config, in a unique spelling, without threads."""
        values = {key: getattr(self, key) for key in OF_RUN if key != "threads"}
        if self.start == FIRST:
            del values["start"]
        return values | {"repeat": self.repeats, "horizon": f"{self.horizon:.15g} us"}


@lru_cache(maxsize=64)
def _with(run, changes):
    """Assemble settings with other values once, as each call of a search asks for the same."""
    return assemble(Run, vars(run) | dict(changes))


OF_RUN = tuple(field.name for field in fields(Run))
"""Names of the values of a run."""

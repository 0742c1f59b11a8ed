"""How every cell of a study is followed."""

from collections.abc import Mapping
from typing import NamedTuple

UNTIL = ("settled", "snap")
SNAP, EDGE, STAY, MOVE = QUESTIONS = ("snap", "edge", "stay", "move")
"""Does it snap, from which N on, where does it stay, how does it move: each has its time step."""
QUESTION = {"settled": STAY, "snap": SNAP, "edge": EDGE, "pulse": SNAP, "moved": MOVE}
"""By how long a cell is followed, which question that answers.

Beside UNTIL, within the solver: "edge" is "snap" in the steps that a threshold needs, "pulse" ends
a run with its pulse or its snap, and "moved" is "settled" in the steps that the motion needs.
"""
FIRST, SECOND = STARTS = ("first", "second")
"""The shape in which the beam rests at the start of a run; a snap is its arrival at the other."""
THRESHOLD_TOLERANCE = 1e-4
"""How closely thresholds in N are refined by default, relative."""


class Settings(NamedTuple):
    """How each cell is followed, and how many threads work at it.

    horizon: time followed after the pulse's end, us
    until: "settled" follows a cell until its well is proven, "snap" ends it at its snap too
    repeat: whether each cell is run again with another step, to see if its outcome is reproduced
    energy_tolerance: a run is believed if its energy ledger closes within this share of the
        pulse's gross work
    start: the one of STARTS in which the beam rests at first
    """

    horizon: float = 1500.0
    until: str = "settled"
    repeat: bool = True
    energy_tolerance: float = 1e-3
    threads: int = 1
    start: str = FIRST

    @property
    def question(self) -> str:
        """The one of QUESTIONS that the cells answer."""
        return QUESTION[self.until]

    def without_threads(self) -> dict:
        """Give all but the threads, on which no result depends, and a start in the first shape."""
        usual = "threads", *(["start"] if self.start == FIRST else [])
        return {key: value for key, value in self._asdict().items() if key not in usual}


def settings_of(values: Mapping) -> Settings:
    """Give the settings of those by name; unless they say so, only settled cells are repeated."""
    return Settings(**{"repeat": values.get("until", "settled") == "settled", **values})

"""Settings of the runs of a study."""

from collections.abc import Mapping
from typing import NamedTuple

UNTIL = ("settled", "snap")
SNAP, EDGE, STAY, MOVE = QUESTIONS = ("snap", "edge", "stay", "move")
"""Questions to a run, by which its time step is chosen: does the beam snap, from which N on, where
does it stay, how does it move."""
QUESTION = {"settled": STAY, "snap": SNAP, "edge": EDGE, "pulse": SNAP, "moved": MOVE}
"""The question of a run, by `until`. The solver knows three words beside UNTIL: "edge" is "snap" in
the steps that a threshold needs, "pulse" ends a run with its pulse or its snap, and "moved" is
"settled" in the steps that the motion needs."""
FIRST, SECOND = STARTS = ("first", "second")
"""The shape in which the beam rests at first; it snaps when it arrives at the other."""
THRESHOLD_TOLERANCE = 1e-4
"""Default relative width to which thresholds in N are refined."""


class Settings(NamedTuple):
    """Settings of runs.

    horizon: time followed after the pulse's end, us
    until: "settled" ends a run when it has settled in a well, "snap" also at its snap
    repeat: whether each cell runs again with another step, to see if its outcome is reproduced
    energy_tolerance: largest residual of the energy ledger of a believed run, over the pulse's
        gross work
    threads: number of threads, on which no result depends
    start: one of STARTS
    """

    horizon: float = 1500.0
    until: str = "settled"
    repeat: bool = True
    energy_tolerance: float = 1e-3
    threads: int = 1
    start: str = FIRST

    @property
    def question(self) -> str:
        """The one of QUESTIONS that the runs answer."""
        return QUESTION[self.until]

    def without_threads(self) -> dict:
        """Return the settings by name, without threads, and without a start in the first shape."""
        usual = "threads", *(["start"] if self.start == FIRST else [])
        return {key: value for key, value in self._asdict().items() if key not in usual}


def settings_of(values: Mapping) -> Settings:
    """Make settings of values by name; by default only cells followed until settled repeat."""
    return Settings(**{"repeat": values.get("until", "settled") == "settled", **values})

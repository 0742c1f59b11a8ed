"""How every cell of a study is followed."""

from numbers import Real
from typing import NamedTuple

from ..pulse import Pulse, make_pulse

UNTIL = ("settled", "snap")
SNAP, EDGE, STAY, MOVE = QUESTIONS = ("snap", "edge", "stay", "move")
"""Does it snap, from which N on, where does it stay, how does it move: each has its time step."""
QUESTION = {"settled": STAY, "snap": SNAP, "edge": EDGE, "pulse": SNAP, "moved": MOVE}
"""What is asked by how long a cell is followed.

Beside UNTIL, within the solver: "edge" is "snap" in the steps that a threshold needs, "pulse" ends
a run with its pulse or its snap, and "moved" is "settled" in the steps that the motion needs.
"""
MOST = {"threads": 1024, "records": 10_000, "seed": 2**32 - 1}
THRESHOLD_TOLERANCE = 1e-4
"""How closely thresholds in N are refined by default, relative."""


class Settings(NamedTuple):
    """How each cell is followed, and how many threads work at it.

    horizon: time followed after the pulse's end, us
    until: "settled" follows a cell until its well is proven, "snap" ends it at its snap too
    repeat: whether each cell is run again with another step, to see if its outcome is reproduced
    energy_tolerance: a run is believed if its energy ledger closes within this share of the
        pulse's gross work
    pulses: what the cells' indices of pulses refer to
    """

    horizon: float = 1500.0
    until: str = "settled"
    repeat: bool = True
    energy_tolerance: float = 1e-3
    threads: int = 1
    pulses: tuple[Pulse, ...] = (make_pulse(),)

    @property
    def question(self) -> str:
        """The one of QUESTIONS that is asked."""
        return QUESTION[self.until]

    def asked(self) -> dict:
        """All but the threads, on which no result depends, and the pulses."""
        left_out = "threads", "pulses"
        return {key: value for key, value in self._asdict().items() if key not in left_out}


def check_number(key: str, value: object) -> None:
    """Raise ValueError, one line, for a value that is no real number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{key}: {value!r} is not a number")


def check_count(key: str, value: object) -> None:
    """Raise ValueError, one line, for what is no whole number from 1 to its bound in MOST."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST[key]:
        raise ValueError(f"{key}: {value!r} is not a whole number from 1 to {MOST[key]}")


def check_settings(settings: Settings) -> None:
    """Raise ValueError, one line, for a value that cannot be."""
    check_number("sweep.horizon", settings.horizon)
    check_number("sweep.energy_tolerance", settings.energy_tolerance)
    if settings.until not in UNTIL:
        raise ValueError(f"sweep.until: {settings.until!r} is not one of {', '.join(UNTIL)}")
    if not 0 <= settings.horizon < float("inf"):
        raise ValueError(f"sweep.horizon: {settings.horizon} is not a finite time from 0")
    if not 0 < settings.energy_tolerance < 1:
        raise ValueError(f"sweep.energy_tolerance: {settings.energy_tolerance} is not in (0, 1)")
    check_count("threads", settings.threads)

"""How every cell of a sweep is followed."""

from numbers import Real
from typing import NamedTuple

UNTIL = ("settled", "snap")
THRESHOLD_TOLERANCE = 1e-4
"""How closely thresholds in N are refined, relative, unless told."""


class Protocol(NamedTuple):
    """What is asked of each cell.

    horizon: time followed after the pulse's end, us
    until: "settled" follows a cell until its well is proven, "snap" ends it at its snap too
    repeat: whether each cell is run again with another step, to see if its outcome is reproduced
    energy_tolerance: a run is believed if its energy ledger closes within this share of the
        pulse's gross work
    """

    horizon: float = 1500.0
    until: str = "settled"
    repeat: bool = True
    energy_tolerance: float = 1e-3


def check_number(key: str, value: object) -> None:
    """Raise ValueError, one line, for a value that is no real number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{key}: {value!r} is not a number")


def check_protocol(protocol: Protocol) -> None:
    """Raise ValueError, one line, for a value that cannot be."""
    check_number("sweep.horizon", protocol.horizon)
    check_number("sweep.energy_tolerance", protocol.energy_tolerance)
    if protocol.until not in UNTIL:
        raise ValueError(f"sweep.until: {protocol.until!r} is not one of {', '.join(UNTIL)}")
    if not 0 <= protocol.horizon < float("inf"):
        raise ValueError(f"sweep.horizon: {protocol.horizon} is not a finite time from 0")
    if not 0 < protocol.energy_tolerance < 1:
        raise ValueError(f"sweep.energy_tolerance: {protocol.energy_tolerance} is not in (0, 1)")

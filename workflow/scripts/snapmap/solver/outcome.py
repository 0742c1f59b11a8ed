"""What a cell's facts prove: the labels of the map; and by how much a second run differs."""

from collections.abc import Mapping
from enum import IntEnum

import numpy as np

from .cells import Observations


class Outcome(IntEnum):
    """What became of a cell; `ABSENT` is one whose device has no second stable shape."""

    UNSNAPPED = 0
    NEVER = 1
    SNAPPED = 2
    LATCHED = 3
    RETURNED = 4
    FAILED = 5
    ABSENT = 6


UNSNAPPED, NEVER, SNAPPED, LATCHED, RETURNED, FAILED, ABSENT = Outcome
OUTCOMES = tuple(outcome.name.lower() for outcome in Outcome)
REPEATED_STEP = 0.75
"""The second run of a cell takes this fraction of the first one's step."""
WHOLE_SWING = 0.999
"""Share of the last swing above which the beam has kept to one side."""


def label(
    t_snap: np.ndarray,
    t_settled: np.ndarray,
    well: np.ndarray,
    energy_error: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Outcome of each cell as an index into OUTCOMES, int8; the arguments are `Observations`.

    Proven for ever: `never` left the well of its start, 1, `latched` in the other, 2, `returned` to
    1 after a snap. Open at the horizon: `unsnapped`, `snapped`. A run whose ledger does not close
    within the tolerance has `failed`, whatever else it seems to show.
    """
    snapped, settled = ~np.isnan(t_snap), ~np.isnan(t_settled)
    outcome = np.select(
        [~(energy_error <= tolerance), snapped & settled, snapped, settled],
        [FAILED, np.where(well == 2, LATCHED, RETURNED), SNAPPED, NEVER],
        UNSNAPPED,
    )
    return outcome.astype(np.int8)


def count(outcome: np.ndarray) -> dict[str, int]:
    """How many cells have which outcome, by name; no outcome has a count of 0."""
    numbers = np.bincount(np.ravel(outcome), minlength=len(OUTCOMES))
    return {name: int(n) for name, n in zip(OUTCOMES, numbers, strict=True) if n}


def ended_elsewhere(well_reproduced: np.ndarray, well_share: np.ndarray) -> np.ndarray:
    """Whether a run with another step ended on the other side of the saddle, as in a cube.

    A cell that still goes back and forth over it ends on neither.
    """
    return (well_reproduced == 0) & ~(well_share < WHOLE_SWING)


def shares(counts: Mapping[str, int]) -> dict[str, float]:
    """Shares of the cells that are proven, open and failed; those without a device do not count.

    counts: as from `count`
    """
    total = max(1, sum(counts.values()) - counts.get("absent", 0))
    groups = {
        "proven": ("never", "latched", "returned"),
        "open": ("unsnapped", "snapped"),
        "failed": ("failed",),
    }
    return {
        f"share_{group}": round(sum(counts.get(name, 0) for name in names) / total, 6)
        for group, names in groups.items()
    }


def work_error(observed: Observations, again: Observations) -> np.ndarray:
    """Difference of the pulse's work over the larger of both, from 0 to 2; 0 where both are.

    NaN where one of them is not known.
    """
    apart = abs(again.pulse_work - observed.pulse_work)
    larger = np.maximum(abs(again.pulse_work), abs(observed.pulse_work))
    return np.divide(apart, larger, out=apart, where=larger > 0)


def t_snap_error(observed: Observations, again: Observations) -> np.ndarray:
    """Difference of the times of snap, us; NaN where one of them did not snap."""
    return abs(again.t_snap - observed.t_snap)

"""Outcomes, the labels of cells, from observations; and differences between two runs."""

import numpy as np

from .cells import Observations

OUTCOMES = "unsnapped", "never", "snapped", "latched", "returned", "failed", "absent"
"""Outcomes of a cell, by their codes; absent is that of a device without a second stable shape."""
UNSNAPPED, NEVER, SNAPPED, LATCHED, RETURNED, FAILED, ABSENT = range(len(OUTCOMES))
REPEATED_STEP = 0.75
"""Step of the second run of a cell over that of the first."""
WHOLE_SWING = 0.999
"""Share of the last swing from which on the beam counts as having kept to one side."""


def label(observed: Observations, tolerance: float) -> np.ndarray:
    """Label each cell by an index into OUTCOMES, int8.

    Settled are `never` (it never left well 1, of its start), `latched` (in well 2) and `returned`
    (to well 1 after a snap): by its energy this run stays in its well for ever, which proves
    nothing of a run with another step. Open at the horizon are `unsnapped` and `snapped`. A run
    whose energy_error exceeds the tolerance has `failed`, whatever else it shows.
    """
    snapped, settled = ~np.isnan(observed.t_snap), ~np.isnan(observed.t_settled)
    outcome = np.select(
        [~(observed.energy_error <= tolerance), snapped & settled, snapped, settled],
        [FAILED, np.where(observed.well == 2, LATCHED, RETURNED), SNAPPED, NEVER],
        UNSNAPPED,
    )
    return outcome.astype(np.int8)


def count(outcome: np.ndarray) -> dict[str, int]:
    """Count the cells of each outcome, by its name; outcomes without cells are left out."""
    numbers = np.bincount(np.ravel(outcome), minlength=len(OUTCOMES))
    return {name: int(n) for name, n in zip(OUTCOMES, numbers, strict=True) if n}


def ended_elsewhere(well_reproduced: np.ndarray, well_share: np.ndarray) -> np.ndarray:
    """Return which cells ended on the other side of the saddle in a run with another step.

    A cell that still swings over the saddle ends on no side. Arguments are variables of a cube.
    """
    return (well_reproduced == 0) & ~(well_share < WHOLE_SWING)


def side_at_end(observed: Observations, tolerance: float) -> np.ndarray:
    """Return the side of the saddle on which runs end: 1 of the start, 2 the other.

    It is 0 if the beam still swings over the saddle, or if the run has failed or ended before.
    """
    known = (observed.energy_error <= tolerance) & ~(observed.well_share < WHOLE_SWING)
    return np.where(known, observed.well, 0)


def work_error(observed: Observations, again: Observations) -> np.ndarray:
    """Return how much `pulse_work` of two runs differs, over the larger; NaN where one is NaN."""
    apart = abs(again.pulse_work - observed.pulse_work)
    larger = np.maximum(abs(again.pulse_work), abs(observed.pulse_work))
    return np.divide(apart, larger, out=apart, where=larger > 0)


def t_snap_error(observed: Observations, again: Observations) -> np.ndarray:
    """Return the difference of `t_snap` in two runs, us; NaN where either did not snap."""
    return abs(again.t_snap - observed.t_snap)

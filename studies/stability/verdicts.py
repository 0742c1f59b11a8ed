"""Verdicts on runs, by comparison with runs of the same cell in fine steps."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from snapmap.solver.outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED


class Verdict(IntEnum):
    """Verdicts, ascending in severity up to UNSEEN; the highest counts for several cells."""

    SOUND = 0
    SENSITIVE = 1
    SHIFTED = 2
    UNCHECKED = 3
    CAUGHT = 4
    UNSEEN = 5
    REFUSED = 6
    LEFT_OUT = 7


SOUND, SENSITIVE, SHIFTED, UNCHECKED, CAUGHT, UNSEEN, REFUSED, LEFT_OUT = Verdict
VERDICTS = tuple(verdict.name.lower() for verdict in Verdict)
SAME_SNAP = 0.02
"""Largest relative difference between the snap times of runs that snap alike."""
SAME_SETTLED = 0.05
"""Largest relative difference between the times at which fine runs settle that are not chaotic; it
is not 0, as the solver looks only every 128 steps."""


class Runs(NamedTuple):
    """Runs of one case: outcome, t_snap, t_settled (us), energy_error; arrays of one length."""

    outcome: np.ndarray
    t_snap: np.ndarray
    t_settled: np.ndarray
    energy_error: np.ndarray


NO_RUNS = Runs(*np.empty((4, 0)))


def judge(runs: Runs, fine: Runs) -> np.ndarray:
    """Judge each run of one case by runs with fine steps; returns int8, (runs,).

    - `caught`: the run failed, and says so
    - `unseen`: it is believed, but the fine runs agree on another snap or another well for ever
    - `shifted`: the fine runs agree on another snap time
    - `sensitive`: the fine runs disagree among themselves
    - `unchecked`: there are no fine runs
    """
    fine = Runs(*(values[fine.outcome != FAILED] for values in fine))
    if fine.outcome.size == 0:
        return np.where(runs.outcome == FAILED, CAUGHT, UNCHECKED).astype(np.int8)
    snap_known = np.ptp(_has_snapped(fine).astype(int)) == 0
    time_known = snap_known and _spread(fine.t_snap) < SAME_SNAP
    well_known = time_known and np.ptp(fine.outcome) == 0 and _spread(fine.t_settled) < SAME_SETTLED
    wrong = snap_known & (_has_snapped(runs) != _has_snapped(fine)[0])
    both_settled = _is_settled(runs) & _is_settled(fine)[0]
    wrong |= well_known & both_settled & (runs.outcome != fine.outcome[0])
    shifted = time_known & (snap_shift(runs, fine) > SAME_SNAP)
    believed = SOUND if well_known else SENSITIVE
    verdict = np.select(
        [runs.outcome == FAILED, wrong, shifted], [CAUGHT, UNSEEN, SHIFTED], believed
    )
    return verdict.astype(np.int8)


def snap_shift(runs: Runs, fine: Runs) -> np.ndarray:
    """Return each run's relative difference to the fine runs' median snap time, or NaN; (runs,)."""
    known = fine.t_snap[np.isfinite(fine.t_snap) & (fine.outcome != FAILED)]
    median = np.median(known) if known.size else np.nan
    return np.where(runs.outcome == FAILED, np.nan, np.abs(runs.t_snap / median - 1))


def _spread(times):
    """Largest difference of times over the largest time; 0 without times."""
    times = times[np.isfinite(times)]
    return np.ptp(times) / times.max() if times.size else 0.0


def _has_snapped(runs):
    return np.isin(runs.outcome, (SNAPPED, LATCHED, RETURNED))


def _is_settled(runs):
    return np.isin(runs.outcome, (NEVER, LATCHED, RETURNED))

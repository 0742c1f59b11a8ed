"""A second run with another step: by how much the motion differs."""

import numpy as np

from .cells import Observations

REPEATED_STEP = 0.75
"""The second run of a cell takes this fraction of the first one's step."""


def work_error(seen: Observations, again: Observations) -> np.ndarray:
    """Difference of the pulse's work over the larger of both, from 0 to 2; 0 where both are.

    NaN where one of them is not known.
    """
    apart = abs(again.pulse_work - seen.pulse_work)
    larger = np.maximum(abs(again.pulse_work), abs(seen.pulse_work))
    return np.divide(apart, larger, out=apart, where=larger > 0)


def t_snap_error(seen: Observations, again: Observations) -> np.ndarray:
    """Difference of the times of snap, us; NaN where one of them did not snap."""
    return abs(again.t_snap - seen.t_snap)

"""How many runs a search may spend on a row."""

from typing import NamedTuple

SCAN_STEP, ISLAND_STEP, RAGGED_STEP = 0.03, 0.005, 0.001
"""Relative steps of N: in a first scan, in the scan for islands, and in ragged rows."""
PARTS = 4
"""Number of parts into which each round of a search cuts an interval; more parts cost more runs."""
TOGETHER = 8
"""Most places of one row that are tried at once."""
CLOSE_STEP = 0.00025
"""Relative step of N close to a threshold."""
CLOSE_PLACES = 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80
"""Distances from a threshold at which runs are compared, in CLOSE_STEP; the last is CLEAN_REACH."""


class Effort(NamedTuple):
    """How densely a search looks; the default is that of models whose runs cost next to nothing.

    scan, islands, ragged: relative steps of N: of the first scan, of the scan for islands, and
        around the changes of ragged rows
    together: most N of a row that the first scan tries at once
    parts: number of parts into which each round of a refinement cuts an interval
    close: places beside the threshold of a ringing device, as CLOSE_PLACES
    thorough: whether it looks on between and above these places, halves other models' distances
        until they are known to an eighth, seeks N_latched and the limits of slow and short pulses,
        and looks for islands as far as it is asked to
    """

    scan: float = SCAN_STEP
    islands: float = ISLAND_STEP
    ragged: float = RAGGED_STEP
    together: int = TOGETHER
    parts: int = PARTS
    close: tuple[int, ...] = CLOSE_PLACES
    thorough: bool = True


THOROUGH = Effort()
FRUGAL = Effort(0.25, 0.1, 0.01, 1, 2, (2, 4, 8, 24, 64), thorough=False)
"""The effort for a user's own solver: at most 60 runs for a clean row."""

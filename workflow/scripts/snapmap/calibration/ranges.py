"""Ranges in which unknown values of a device are looked for."""

import math
from collections.abc import Mapping

from ..checks import show
from ..device import FROM_ZERO, SIGNED

MOST = 4
"""Unknowns: the grid of thresholds grows with the power of their number."""


def check_ranges(unknowns: Mapping, C: float | None) -> None:
    """Raise ValueError, one line, for ranges of unknowns, or a C beside them, that cannot be."""
    if not 1 <= len(unknowns) <= MOST:
        raise ValueError(f"unknowns: {len(unknowns)} of them; name 1 to {MOST}")
    for key, ends in unknowns.items():
        _check_range(key, ends)
    if ("C" in unknowns) != (C is None):
        what = "missing; write it, or its range" if C is None else "is unknown; leave it out"
        raise ValueError(f"C: {what}")


def _check_range(key, ends):
    try:
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError):
        raise ValueError(f"unknowns: {key}: {show(ends)} is no pair of low and high") from None
    from_zero = key in (*FROM_ZERO, "C")
    above = low >= 0 if from_zero else low > 0
    if not ((above or key in SIGNED) and -math.inf < low < high < math.inf):
        need = "" if key in SIGNED else " from 0" if from_zero else " above 0"
        raise ValueError(f"unknowns: {key}: {low:g} to {high:g} is no ascending range{need}")

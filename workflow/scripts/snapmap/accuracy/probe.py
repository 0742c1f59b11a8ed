"""What every case is asked: thresholds at a few (C, f0), and a map."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..portable import geometric, linear


class Probe(NamedTuple):
    """What every case is asked.

    C (uN us/um), f0 (Hz): of the thresholds; bracket: multiples of g between which they lie
    axes: of the map, in the order of `grid.AXES`
    """

    C: np.ndarray
    f0: np.ndarray
    bracket: tuple[float, float]
    axes: tuple[np.ndarray, ...]


def make_probe(axes: Sequence[Sequence[float]], side: int) -> Probe:
    """Choose what to ask: thresholds at both ends of C and the quarter points of f0, and a map.

    axes: of the sweep, in the order of `grid.AXES`; side: cells of the map along f0 and N
    The bracket reaches from half the least |N| to twice the largest.
    """
    C, f0, N = (np.sort(np.asarray(values, float)) for values in axes)
    ends = np.unique(C[[0, -1]])
    quarters = np.round(np.array([0.25, 0.5, 0.75]) * (f0.size - 1)).astype(int)
    sizes = np.abs(N[N != 0]) if N.any() else np.ones(1)
    wide = np.unique(geometric(f0[0], f0[-1], side)), np.unique(linear(N[0], N[-1], side))
    bracket = float(sizes.min() / 2), float(2 * sizes.max())
    return Probe(ends, f0[np.unique(quarters)], bracket, (ends, *wide))

"""What every case is asked: thresholds at a few (C, f0), and a map."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from snapmap.numerics.portable import geometric, linear


class Probe(NamedTuple):
    """What every case is asked.

    C (uN us/um), f0 (Hz): of the thresholds; bracket: multiples of g between which they lie
    axes: C, f0 and N of the map
    """

    C: np.ndarray
    f0: np.ndarray
    bracket: tuple[float, float]
    axes: dict[str, np.ndarray]


def make_probe(axes: Mapping[str, Sequence[float]], side: int) -> Probe:
    """Choose what to ask: thresholds at both ends of C and the quarter points of f0, and a map.

    axes: C, f0 and N of the sweep; side: cells of the map along f0 and N
    The bracket reaches from half the least |N| to twice the largest.
    """
    C, f0, N = (np.sort(np.asarray(axes[key], float)) for key in ("C", "f0", "N"))
    ends = np.unique(C[[0, -1]])
    quarters = np.round(np.array([0.25, 0.5, 0.75]) * (f0.size - 1)).astype(int)
    sizes = np.abs(N[N != 0]) if N.any() else np.ones(1)
    wide = geometric(f0[0], f0[-1], side), linear(N[0], N[-1], side)
    of_map = {"C": ends, "f0": np.unique(wide[0]), "N": np.unique(wide[1])}
    bracket = float(sizes.min() / 2), float(2 * sizes.max())
    return Probe(ends, f0[np.unique(quarters)], bracket, of_map)

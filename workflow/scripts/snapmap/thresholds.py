"""The lowest amplitude that snaps, bracketed and refined by the lane kernel."""

from collections.abc import Callable, Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .device import Device
from .models import Model
from .protocol import Protocol

SCAN_STEP = 0.03
"""Relative distance of the amplitudes that are tried before any is refined."""
SECTIONS = 16
"""Parts into which each round of refinement cuts an interval."""


def lowest_snap(
    device: Device,
    model: Model,
    f0: Sequence[float],
    C: Sequence[float],
    bracket: tuple[float, float],
    protocol: Protocol,
    tolerance: float = 1e-4,
    threads: int = 1,
) -> np.ndarray:
    """Find the lowest N that snaps, (rows,), for rows of f0 (Hz) and C (uN us/um).

    bracket: multiples of g between which to look
    tolerance: of N, relative; the result is the upper end of an interval that narrow
    NaN where nothing in the bracket snaps, or its lower end does.
    """
    snaps = asker(device, model, f0, C, protocol, threads)
    count = 2 + int(np.log(bracket[1] / bracket[0]) / SCAN_STEP)
    N = np.tile(np.geomspace(*bracket, count), (len(f0), 1))
    return refine(snaps, *first_snap(N, snaps(N)), tolerance)[1]


def asker(
    device: Device,
    model: Model,
    f0: Sequence[float],
    C: Sequence[float],
    protocol: Protocol,
    threads: int = 1,
) -> Callable[[np.ndarray], np.ndarray]:
    """Make a function that tells which of N, (rows, n), snap; rows of f0 (Hz) and C (uN us/um)."""
    f0, C = (np.asarray(values, float)[:, np.newaxis] for values in (f0, C))
    asked = protocol._replace(until="snap", repeat=False)

    def snaps(N):
        rows = (np.broadcast_to(values, N.shape).ravel() for values in (N, f0, C))
        cells = to_cells(device, *rows, asked.horizon)
        return np.isfinite(follow_cells(device, model, cells, asked, threads).t_snap).reshape(
            N.shape
        )

    return snaps


def first_snap(N: np.ndarray, snapped: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the interval below the first of ascending N, (rows, n), that snaps; NaN if none."""
    first = np.argmax(snapped, axis=1)
    rows = np.arange(len(N))
    found = snapped[rows, first] & (first > 0)
    return tuple(np.where(found, N[rows, end], np.nan) for end in (first - 1, first))


def refine(
    snaps: Callable, low: np.ndarray, high: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Narrow intervals, (rows,), whose upper ends snap and lower ends do not, to the tolerance."""
    while np.nanmax(high / low, initial=1.0) > 1 + tolerance:
        N = np.linspace(low, high, SECTIONS + 1, axis=1)
        snapped = snaps(np.nan_to_num(N[:, 1:-1]))
        ends = np.zeros((len(N), 1), bool)
        low, high = first_snap(N, np.hstack([ends, snapped, ~ends & np.isfinite(high)[:, None]]))
    return low, high

"""The lowest amplitude that snaps, bracketed and refined by the lane kernel."""

from collections.abc import Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .device import Device
from .models import Model
from .protocol import Protocol

SECTIONS = 16
"""Parts into which each round cuts the bracket: as many cells as the kernel has lanes, less one."""


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
    """Refine the lowest N that snaps, (rows,), for rows of f0 (Hz) and C (uN us/um).

    bracket: multiples of g between which to look, scanned first in steps of 3 %
    tolerance: of N, relative; the result is the upper end of an interval that narrow
    NaN where nothing in the bracket snaps, or its lower end does.
    """
    f0, C = (np.asarray(values, float) for values in (f0, C))
    snaps = _asker(device, model, f0, C, protocol._replace(until="snap", repeat=False), threads)
    scan = np.geomspace(*bracket, 2 + int(np.log(bracket[1] / bracket[0]) / 0.03))
    low, high = _first_interval(np.tile(scan, (f0.size, 1)), snaps)
    while np.nanmax(high / low, initial=1.0) > 1 + tolerance:
        inner = np.linspace(low, high, SECTIONS + 1, axis=1)
        low, high = _first_interval(inner, snaps, known_ends=True)
    return high


def _asker(device, model, f0, C, protocol, threads):
    """A function that tells which of N, (rows, n), snap."""

    def snaps(N):
        shape = N.shape
        rows = np.broadcast_to(f0[:, None], shape), np.broadcast_to(C[:, None], shape)
        cells = to_cells(device, N.ravel(), *(values.ravel() for values in rows), protocol.horizon)
        t_snap = follow_cells(device, model, cells, protocol, threads).t_snap
        return np.isfinite(t_snap).reshape(shape)

    return snaps


def _first_interval(N, snaps, known_ends=False):
    """The interval of each row of ascending N above which lies the first that snaps."""
    snapped = np.zeros(N.shape, bool)
    if known_ends:
        snapped[:, 1:-1] = snaps(np.nan_to_num(N[:, 1:-1]))
        snapped[:, -1] = True
    else:
        snapped[:] = snaps(N)
    first = np.argmax(snapped, axis=1)
    rows = np.arange(len(N))
    found = snapped.any(axis=1) & (first > 0)
    low, high = N[rows, first - 1], N[rows, first]
    return np.where(found, low, np.nan), np.where(found, high, np.nan)

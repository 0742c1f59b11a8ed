"""The lowest amplitude that snaps, bracketed and refined by the lane kernel."""

from collections.abc import Callable, Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .models import Model
from .protocol import THRESHOLD_TOLERANCE, Protocol

SCAN_STEP = 0.03
"""Relative distance of the amplitudes that are tried before any is refined."""
SECTIONS = 4
"""Parts into which each round of refinement cuts an interval; more cost more runs a digit."""


def lowest_snap(
    model: Model,
    f0: Sequence[float],
    C: Sequence[float],
    bracket: tuple[float, float],
    protocol: Protocol,
    tolerance: float = THRESHOLD_TOLERANCE,
    threads: int = 1,
) -> np.ndarray:
    """Find the lowest N that snaps, (rows,), for rows of f0 (Hz) and C (uN us/um).

    bracket: multiples of g between which to look
    tolerance: of N, relative; the result is the upper end of an interval that narrow
    NaN where nothing in the bracket snaps, or its lower end does.
    """
    ask = asker(model, f0, C, protocol, threads)
    N = amplitudes(*(np.full(len(f0), end) for end in bracket), SCAN_STEP)
    return refine(ask, *first_snap(N, np.isfinite(ask(N))), tolerance)[1]


def asker(
    model: Model,
    f0: Sequence[float],
    C: Sequence[float],
    protocol: Protocol,
    threads: int = 1,
) -> Callable[[np.ndarray], np.ndarray]:
    """Make a function that tells when cells snap, for rows of f0 (Hz) and C (uN us/um).

    It takes N, (rows, n), and returns t_snap, us; NaN where a cell does not snap, or N is NaN.
    """
    f0, C = (np.asarray(values, float)[:, np.newaxis] for values in (f0, C))
    asked = protocol._replace(until="snap", repeat=False)

    def ask(N):
        given = np.isfinite(N)
        rows = (np.broadcast_to(values, N.shape)[given] for values in (N, f0, C))
        cells = to_cells(model.device, *rows, asked.horizon)
        t_snap = np.full(N.shape, np.nan)
        t_snap[given] = follow_cells(model, cells, asked, threads).t_snap
        return t_snap

    return ask


def amplitudes(low: np.ndarray, high: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    """Amplitudes from low to high in relative steps, each (rows,): (rows, n), NaN beyond high."""
    factor = np.broadcast_to(1 + np.asarray(step), low.shape)
    count = 2 + int(np.nanmax(np.log(high / low) / np.log(factor), initial=0.0))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.column_stack([low, *[factor] * (count - 1)]), axis=1)
    N = np.minimum(N, high[:, np.newaxis])
    N[:, 1:][N[:, 1:] == N[:, :-1]] = np.nan
    return N


def first_snap(N: np.ndarray, snapped: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the interval below the first of ascending N, (rows, n), that snaps; NaN if none."""
    first = np.argmax(snapped, axis=1)
    rows = np.arange(len(N))
    found = snapped[rows, first] & (first > 0)
    return tuple(np.where(found, N[rows, end], np.nan) for end in (first - 1, first))


def refine(
    ask: Callable, low: np.ndarray, high: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Narrow intervals, (rows,), between what snaps and what does not, to a relative tolerance.

    ask: gives t_snap of N, (rows, n), finite where a cell snaps at `high` and NaN at `low`
    """
    while np.nanmax(high / low, initial=1.0) > 1 + tolerance:
        N = np.linspace(low, high, SECTIONS + 1, axis=1)
        snapped = np.isfinite(ask(N[:, 1:-1]))
        ends = np.zeros((len(N), 1), bool)
        low, high = first_snap(N, np.hstack([ends, snapped, ~ends & np.isfinite(high)[:, None]]))
    return low, high

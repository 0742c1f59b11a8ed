"""The lowest amplitude that snaps, bracketed and refined by any model."""

from collections.abc import Callable

import numpy as np

from .cells import Rows, to_cells
from .model import Follows
from .settings import THRESHOLD_TOLERANCE, Settings

SCAN_STEP = 0.03
"""Relative distance of the amplitudes that are tried before any is refined."""
SECTIONS = 4
"""Parts into which each round of refinement cuts an interval; more cost more runs a digit."""


def lowest_snap(
    model: Follows,
    rows: Rows,
    bracket: tuple[np.ndarray, np.ndarray],
    settings: Settings,
    tolerance: float = THRESHOLD_TOLERANCE,
    step: float = SCAN_STEP,
) -> np.ndarray:
    """Find the lowest N that snaps, (rows,).

    bracket: multiples of g between which to look, numbers or (rows,)
    step: relative distance of the amplitudes that are tried first
    tolerance: of N, relative; the result is the upper end of an interval that narrow
    NaN where nothing in the bracket snaps, or its lower end does.
    """
    ask = asker(model, rows, settings)
    low, high = (np.broadcast_to(end, rows.f0.shape) for end in bracket)
    N = amplitudes(low, high, step)
    return refine(ask, *first_snap(N, np.isfinite(ask(N))), tolerance)[1]


def asker(
    model: Follows, rows: Rows, settings: Settings, until: str = "edge"
) -> Callable[[np.ndarray], np.ndarray]:
    """Make a function that tells when the cells of rows snap.

    until: "edge" or "snap", as in `settings.QUESTION`
    It takes N, (rows, n), and returns t_snap, us; NaN where a cell does not snap, or N is NaN, and
    -inf where no run of it can be believed.
    """
    asked = settings._replace(until=until, repeat=False)

    def ask(N):
        given = np.isfinite(N)
        columns = (np.broadcast_to(column[:, np.newaxis], N.shape)[given] for column in rows)
        device, f0, C, pulse = columns
        cells = to_cells(model.device, device, N[given], f0, C, asked.horizon, pulse)
        t_snap = np.full(N.shape, np.nan)
        seen = model.follow(cells, asked)
        lost = np.isnan(seen.t_snap) & ~(seen.energy_error <= asked.energy_tolerance)
        t_snap[given] = np.where(lost, -np.inf, seen.t_snap)
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
    low, high = (np.where(found, N[rows, end], np.nan) for end in (first - 1, first))
    return low, high


def refine(
    ask: Callable, low: np.ndarray, high: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Narrow intervals, (rows,), between what snaps and what does not, to a relative tolerance.

    ask: gives t_snap of N, (rows, n), finite where a cell snaps, as at `high` and not at `low`
    """
    low, high = np.array(low), np.array(high)
    while (wide := np.flatnonzero(high / low > 1 + tolerance)).size:
        N = np.full((low.size, SECTIONS + 1), np.nan)
        N[wide] = np.linspace(low[wide], high[wide], SECTIONS + 1, axis=1)
        snapped = np.isfinite(ask(N[:, 1:-1]))[wide]
        ends = np.zeros((wide.size, 1), bool)
        low[wide], high[wide] = first_snap(N[wide], np.hstack([ends, snapped, ~ends]))
    return low, high

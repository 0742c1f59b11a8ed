"""How far answers lie apart, and which of them no other beats."""

import numpy as np


def largest_errors(errors: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Largest |error| where it is known, (model, 2); NaN if nowhere, or where a case found none.

    errors, known: (model, 2, rows), relative, and whether its reference can fault others
    """
    worst = np.where(known, np.abs(errors), -np.inf).max(axis=2, initial=-np.inf)
    return np.where(np.isneginf(worst), np.nan, worst)


def disagreement(t_snap: np.ndarray, reference: np.ndarray, f0: np.ndarray) -> tuple[float, float]:
    """Share of cells labelled otherwise (snaps or not), of all and of those that snap in the pulse.

    t_snap, reference: us, (..., f0, N), NaN for no snap; the reference tells which cells snap in
    the pulse; NaN where none does. f0: Hz
    """
    other = np.isnan(t_snap) != np.isnan(reference)
    in_pulse = reference < 1e6 / f0[:, np.newaxis]
    return other.mean(), other[in_pulse].mean() if in_pulse.any() else np.nan


def pareto_front(time: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Whether no other is as fast and accurate, and better in one of them; never for NaN; (n,)."""
    as_good = (time[:, None] <= time) & (error[:, None] <= error)
    better = (time[:, None] < time) | (error[:, None] < error)
    return ~(as_good & better).any(axis=0) & np.isfinite(time + error)

"""What a cell's facts prove: the labels of the map."""

import numpy as np

OUTCOMES = ("unsnapped", "never", "snapped", "latched", "returned", "failed")
UNSNAPPED, NEVER, SNAPPED, LATCHED, RETURNED, FAILED = range(len(OUTCOMES))

# ASSUME: a run is believed when its energy ledger closes within this share of the pulse's work.
ENERGY_TOLERANCE = 1e-2


def is_believed(energy_error: np.ndarray) -> np.ndarray:
    """Whether a run's energy ledger closes; False after a blow-up, whatever it left behind."""
    return energy_error <= ENERGY_TOLERANCE


def label(t_snap: np.ndarray, energy_error: np.ndarray) -> np.ndarray:
    """Outcome of each cell as an index into OUTCOMES, int8.

    t_snap: us, NaN where w2 was not reached
    energy_error: residual of the energy ledger over the gross work of the pulse
    """
    outcome = np.where(np.isnan(t_snap), UNSNAPPED, SNAPPED)
    return np.where(is_believed(energy_error), outcome, FAILED).astype(np.int8)


def count(outcome: np.ndarray) -> dict[str, int]:
    """How many cells have which outcome, by name, without the absent ones."""
    numbers = np.bincount(np.ravel(outcome), minlength=len(OUTCOMES))
    return {name: int(n) for name, n in zip(OUTCOMES, numbers, strict=True) if n}

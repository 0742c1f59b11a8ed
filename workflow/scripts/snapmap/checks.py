"""Checks of a value, or of those of a batch; a complaint names the first that is wrong."""

import numpy as np


def require_positive(key: str, value: np.ndarray) -> None:
    """Raise ValueError unless values are above 0 and finite."""
    holds = np.greater(value, 0) & np.less(value, np.inf)
    require(holds, f"{key}: {{}} is not a positive, finite number", value)


def require_from_zero(key: str, value: np.ndarray) -> None:
    """Raise ValueError unless values are 0 or above, and finite."""
    holds = np.greater_equal(value, 0) & np.less(value, np.inf)
    require(holds, f"{key}: {{}} is not 0 or a positive number", value)


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError with the first values for which it does not hold."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

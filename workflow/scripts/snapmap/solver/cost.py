"""What runs cost, before they are paid."""

import numpy as np

from .model import Follows

MOST_SECONDS = 3.6e7
"""What takes longer, 10 000 core hours, is taken for a slip."""


def steps_and_costs(built: Follows, plain: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Time step of each device, us, and the expected time to follow a cell of it for 1 us, s.

    plain: whether by the plain loop
    """
    dt, seconds = np.empty((2, len(built.device)))
    for mine, part, row in built.split(np.arange(dt.size)):
        nanoseconds = 80 if plain else 1 + part.modes**2 / 20
        dt[mine], seconds[mine] = part.dt[row], nanoseconds * 1e-9 / part.dt[row]
    return dt, seconds

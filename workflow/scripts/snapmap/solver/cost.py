"""What runs cost, before they are paid."""

import warnings

import numpy as np

from .model import Follows

MOST_SECONDS = 3.6e7
"""What takes longer, 10 000 core hours, is taken for a slip."""
WORTH_SAYING = 30.0
"""What takes longer, s, is told before it begins."""


def tell(what: str, seconds: float, where: str, cure: str, stacklevel: int) -> None:
    """Warn of what takes long before it begins, in one line; a ValueError refuses it without end.

    where: what takes longest; cure: what to write instead; stacklevel: as of `warnings.warn`
    """
    if seconds <= WORTH_SAYING:
        return
    told = f"{what}: about {_spoken(seconds)}; {where} takes longest"
    if seconds > MOST_SECONDS:
        raise ValueError(f"{told}; {cure}")
    warnings.warn(told, stacklevel=stacklevel + 1)


def _spoken(seconds):
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds > 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.2g} s"


def steps_and_costs(built: Follows, plain: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Time step of each device, us, and the expected time to follow a cell of it for 1 us, s.

    plain: whether by the plain loop
    """
    dt, seconds = np.empty((2, len(built.device)))
    for mine, part, row in built.split(np.arange(dt.size)):
        nanoseconds = 80 if plain else 1 + part.modes**2 / 20
        dt[mine], seconds[mine] = part.dt[row], nanoseconds * 1e-9 / part.dt[row]
    return dt, seconds

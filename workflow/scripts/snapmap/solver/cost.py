"""What runs cost, before they are paid."""

import warnings

import numpy as np

from ..device.quantities import plain
from .cells import Cells
from .models import Follows
from .settings import Settings

MOST_SECONDS = 3.6e7
"""What takes longer, 10 000 core hours, is taken for a slip."""
WORTH_SAYING = 30.0
"""What takes longer, s, is reported before it begins."""


def tell(what: str, seconds: float, where: str, cure: str, stacklevel: int) -> None:
    """Warn of what takes long before it begins, in one line; a ValueError refuses it without end.

    where: what takes longest; cure: what to write instead; stacklevel: as of `warnings.warn`
    """
    line = f"{what}: will take about {spoken(seconds)}, most of it at {where}"
    if seconds > MOST_SECONDS:
        raise ValueError(f"{line}; {cure}")
    if seconds > WORTH_SAYING:
        warnings.warn(line, stacklevel=stacklevel + 1)


def spoken(seconds: float) -> str:
    """A time in the unit that suits it."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds > 2 * length:
            return f"{plain(seconds / length, 2)} {unit}"
    return f"{plain(seconds, 2)} s"


def steps_and_seconds(
    built: Follows, cells: Cells, settings: Settings, plain: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Time step of each cell, us, and the time it takes to follow it to its horizon, s, about.

    plain: whether by the plain loop; both results in the cells' shape
    """
    dt, seconds = np.empty((2, *cells.f0.shape))
    for mine, part in built.split(cells.device):
        dt[mine] = part.time_steps(cells.take(mine), settings)
        nanoseconds = 80 if plain else 1 + part.modes**2 / 20
        seconds[mine] = nanoseconds * 1e-9 * cells.t_end[mine] / dt[mine]
    return dt, seconds

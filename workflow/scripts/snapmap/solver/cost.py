"""Forecasts of the time that runs take."""

import warnings

import numpy as np

from ..files.text import plain
from .cells import Cells
from .models import Follows
from .settings import Run

MOST_SECONDS = 3.6e7
"""Longest time, s, 10 000 core hours; more is refused as a slip."""
WORTH_SAYING = 30.0
"""Time, s, above which a forecast is reported."""


def tell(what: str, seconds: float, where: str, cure: str, stacklevel: int) -> None:
    """Warn, in one line, of a task longer than WORTH_SAYING; ValueError beyond MOST_SECONDS.

    what: the task; where: its longest part; cure: what to write instead
    stacklevel: as in `warnings.warn`
    """
    line = f"{what}: will take about {spoken(seconds)}, most of it at {where}"
    if seconds > MOST_SECONDS:
        raise ValueError(f"{line}; {cure}")
    if seconds > WORTH_SAYING:
        warnings.warn(line, stacklevel=stacklevel + 1)


def spoken(seconds: float) -> str:
    """Write a time in h, min or s."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds > 2 * length:
            return f"{plain(seconds / length, 2)} {unit}"
    return f"{plain(seconds, 2)} s"


def steps_and_seconds(built: Follows, cells: Cells, settings: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return the step of each cell, us, and about the time to follow it to its horizon, s.

    Both have the cells' shape.
    """
    dt, seconds = np.empty((2, *cells.f0.shape))
    for mine, part in built.split(cells.device):
        dt[mine] = part.time_steps(cells.take(mine), settings)
        nanoseconds = 80 if part.name == "reference" else 1 + part.modes**2 / 20
        seconds[mine] = nanoseconds * 1e-9 * cells.t_end[mine] / dt[mine]
    return dt, seconds

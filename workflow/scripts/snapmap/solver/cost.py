"""Forecasts of the time that runs take."""

import numpy as np

from ..files.text import plain
from ..values.faults import warn
from .cells import Cells
from .models import Follows, Model
from .settings import SHOWN, Run

MOST_SECONDS = 3.6e7
"""Longest time, s, 10 000 core hours; more is refused as a slip."""
WORTH_SAYING = 30.0
"""Time, s, above which a forecast is reported."""
OF_THRESHOLD = 700
"""Runs, each as long as the mean run of a cell to its horizon, that a threshold takes."""
JUMPS, DIES = 7.0, 46.0
"""Time in which a ring decays so far that a run may jump over a wait, and least sum of this time
and the wait, over the time in which its energy falls to 1/e."""


def tell(what: str, seconds: float, where: str, cure: str) -> None:
    """Warn, in one line, of a task longer than WORTH_SAYING; ValueError beyond MOST_SECONDS.

    what: the task; where: its longest part; cure: what to write instead
    """
    line = f"{what}: will take about {spoken(seconds)}, most of it at {where}"
    if seconds > MOST_SECONDS:
        raise ValueError(f"{line}; {cure}")
    if seconds > WORTH_SAYING:
        warn(line)


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
        # When a cell snaps, and then calms down, is not known.
        counted = part.steps_after_snap(cells.take(mine), dt[mine], settings)[0]
        nanoseconds = 80 if part.name == "reference" else 1 + part.modes**2 / 20
        followed = cells.t_end[mine]
        if not (part.laws or part.name == "reference" or settings.until == SHOWN):
            followed = followed - quiet_time(part, cells.take(mine))
        seconds[mine] = nanoseconds * 1e-9 * followed / counted
    return dt, seconds


def quiet_time(model: Model, cells: Cells) -> np.ndarray:
    """Estimate how much time between blows runs leave out, us, (cells,); see `kernel.quiet`."""
    mass, beam = (np.atleast_1d(a) for a in (model.device.mass, model.device.beam.damping))
    quiet = np.zeros(cells.f0.shape)
    with np.errstate(divide="ignore"):
        ring = 1 / np.minimum(cells.damping / mass[cells.device], beam[cells.device])
    for place, pulse in enumerate(cells.pulses):
        which = cells.pulse == place
        wait, of_ring = pulse.waits / cells.f0[which, np.newaxis], ring[which, np.newaxis]
        rings = np.maximum(JUMPS * of_ring, DIES * of_ring - wait)
        quiet[which] = np.maximum(0.0, wait - rings).sum(axis=-1)
    return quiet

"""Ask a case everything: its thresholds, the time of the snap above them, its map, and how fast.

All arithmetic is in double precision; single precision is not offered.
"""

from collections.abc import Sequence
from time import perf_counter
from typing import NamedTuple

import numpy as np

from snapmap.axes import make_grid
from snapmap.solver.cells import to_cells
from snapmap.solver.model import Model
from snapmap.solver.search import SCAN_STEP, lowest_snap
from snapmap.solver.settings import EDGE, Settings
from snapmap.sweeps.grid import follow_grid

from .cases import Case
from .probe import Probe

TOLERANCE = 1e-6
"""To which thresholds are refined, relative."""
REACHES = (1.02, 1.5, 4.0)
"""Within these factors of where the judges saw a threshold it is looked for, in turn."""
ABOVE = 1.05
"""The time of the snap is taken at this multiple of the case's own threshold."""
ROUNDS, SLOW = 3, 0.5
"""Maps that take less than SLOW seconds are timed again, in so many rounds over all of them."""


class Answer(NamedTuple):
    """What was found.

    values: threshold, in multiples of g, and time of the snap, us, (2, rows)
    t_snap: of the map, us, (..., C, f0, N)
    seconds: per simulation of the map, on one thread
    """

    values: np.ndarray
    t_snap: np.ndarray
    seconds: float


def ask_all(cases: Sequence[Case], probe: Probe) -> dict[str, Answer]:
    """Ask every case everything, by name; the map is timed on one thread.

    Cases of several families that are the same are asked once.
    """
    distinct = {_identity(case): case for case in cases}
    answers = {key: _ask_case(case, probe) for key, case in distinct.items()}
    # In rounds, so that whatever else the machine does for a while slows no case alone.
    for key, case in [*distinct.items()] * ROUNDS:
        answers[key] = _least_seconds(case, answers[key], probe)
    return {case.name: answers[_identity(case)] for case in cases}


def _identity(case):
    """What tells cases apart; equal for those that differ in name and family alone."""
    model = case.model
    numbers = model.steps.longest[EDGE].item(), model.device.contact, model.modal.residual
    return model.name, model.modes, *map(float, numbers), case.settings.horizon


def _ask_case(case, probe):
    """The thresholds come first, so that the map finds compiled code."""
    values = ask(case.model, probe, case.settings)
    return Answer(values, *follow_map(case.model, probe, case.settings))


def _least_seconds(case, found, probe):
    """Take the time of another run of the map if that is less; a slow map is not run again."""
    if found.seconds * found.t_snap.size > SLOW:
        return found
    _, seconds = follow_map(case.model, probe, case.settings)
    return found._replace(seconds=min(seconds, found.seconds))


def ask(model: Model, probe: Probe, settings: Settings) -> np.ndarray:
    """Lowest N that snaps, in multiples of g, and t_snap at ABOVE times that, us; (2, rows)."""
    rows, lowest = probe.rows, np.full(probe.N.size, np.nan)
    for reach in REACHES:
        left = np.flatnonzero(np.isnan(lowest))
        bracket = probe.N[left] / reach, probe.N[left] * reach
        step = min(SCAN_STEP, (reach - 1) / 2)
        lowest[left] = lowest_snap(model, rows.some(left), bracket, settings, TOLERANCE, step)
    N = np.nan_to_num(ABOVE * lowest)
    cells = to_cells(model.device, 0, N, rows.f0, rows.C, settings.horizon, *rows[3:])
    return np.array([lowest, model.follow(cells, settings).t_snap])


def follow_map(model: Model, probe: Probe, settings: Settings) -> tuple[np.ndarray, float]:
    """t_snap of the map's cells, us, (..., C, f0, N), and the seconds that each took on one thread.

    In front stand the axes of the shocks.
    """
    grid = make_grid(model.device, probe.axes, shocks=probe.shocks)
    start = perf_counter()
    t_snap = follow_grid(model, grid, settings._replace(threads=1))["t_snap"]
    return t_snap, (perf_counter() - start) / t_snap.size

"""Closures of an electrode by the midpoint of the beam."""

from collections.abc import Sequence
from math import fsum, nan
from typing import NamedTuple

import numpy as np

from ...files.text import plain, table
from ...numerics.linalg import dot
from ...solver import simd_loop
from ...solver.cells import Cells, Observations
from ...solver.models import Follows, deciders
from ...solver.outcome import REPEATED_STEP
from ...solver.settings import FIRST, Run
from ...study.study import Study
from ..requirements.verdict import Verdict

APART = 4.0
"""Error over the difference to another step. Second order gives 1/(1 - 0.75^2) = 2.3; this factor
adds a margin."""


class Closures(NamedTuple):
    """Closures of an electrode; numbers, or arrays (cells,); NaN if it never closes.

    t_closed: time of the first closure, us after the start of the pulse
    closed_for: duration of that closure, us, at most to the end of the run
    openings: number of openings in the run
    closed_share: closed share of the time from t_closed to the end of the run
    """

    t_closed: float | np.ndarray
    closed_for: float | np.ndarray
    openings: float | np.ndarray
    closed_share: float | np.ndarray


CLOSING = *Closures._fields, *(f"{key}_error" for key in Closures._fields)
"""Names of the variables of each cell: the closures and their errors."""


def closures_of(instants: Sequence[float], is_closed: bool, end: float) -> Closures:
    """Sum up the closures of an electrode from the instants of its changes.

    instants: times at which it closes and opens in turn, ascending, us
    is_closed: whether it is closed at 0; end: of the run, us
    """
    turns = [0.0, *instants] if is_closed else [*instants]
    if not turns:
        return Closures(nan, nan, nan, nan)
    ends = [*turns[1::2], end]
    closed = [opens - closes for closes, opens in zip(turns[::2], ends, strict=False)]
    return Closures(turns[0], closed[0], len(turns) // 2, fsum(closed) / (end - turns[0]))


def passages(w: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find where columns of samples, (samples, columns), cross their level, (columns,), either way.

    Returns column and place of each crossing, in samples, ascending; interpolated linearly.
    """
    closed = w <= level
    sample, column = np.nonzero(closed[1:] != closed[:-1])
    before, after = w[sample, column], w[sample + 1, column]
    return column, sample + (before - level[column]) / (before - after)


# ASSUME: the electrode neither stops nor holds the beam, so it bounces as the free beam rings.
def follow_closures(
    model: Follows, cells: Cells, window: np.ndarray, settings: Run
) -> dict[str, np.ndarray]:
    """Follow cells, (cells,), in the time steps of histories, each for its window, us.

    Returns CLOSING by name, to the horizon: the electrode does not change after the window. Errors
    are APART times the difference to a run with another step.
    """
    closures = _follow(model, cells, window, settings)
    again = _follow(model.with_step(REPEATED_STEP), cells, window, settings)
    return dict(zip(CLOSING, [*closures, *(APART * abs(again - closures))], strict=True))


def _follow(model, cells, window, settings):
    start, size = settings.start, len(model.device)
    at_start = np.broadcast_to(dot(model.modal.midpoint, model.rest(start)), size)[cells.device]
    dt = model.time_steps(cells, settings.but(until="moved"))
    ways = np.broadcast_to(model.device.contact_at - model.barrier.first, size)[cells.device]
    steps = np.ceil(window / dt).astype(np.int64) + 1
    closures = np.empty((len(Closures._fields), dt.size))

    def follow(these):
        level, instants = ways[these], [[] for _ in these]
        last = at_start[these][np.newaxis]  # half a step before the start
        group = cells.take(these), dt[these], steps[these], start
        for first, (w, _) in simd_loop.watch(model, *group):
            w = np.concatenate([last, w])
            for column, place in zip(*passages(w, level), strict=True):
                instants[column].append(float((first[column] + place - 0.5) * dt[these[column]]))
            last = w[-1:]
        for i, cell in enumerate(these):
            # A lane runs on beside a longer one.
            within = [instant for instant in instants[i] if instant < window[cell]]
            is_closed = bool(level[i] >= at_start[cell])
            closures[:, cell] = closures_of(within, is_closed, float(cells.t_end[cell]))

    simd_loop.in_lanes(follow, -steps, settings.threads)
    return closures


def closures_again(
    model: Follows, cells: Cells, observed: Observations, settings: Run
) -> dict[str, np.ndarray]:
    """Follow cells of any shape again: those that snap at the finest level, others at their own.

    Returns CLOSING as `follow_closures` does, in the shape of the cells; NaN for failed cells.
    """
    flat, size, shape = cells.flat(), len(model.device), np.shape(cells.f0)
    level = np.zeros(shape, np.int8) if observed.level is None else observed.level
    level = np.where(np.isfinite(observed.t_snap), len(model.levels) - 1, level)
    decided = np.stack([level.ravel(), observed.halvings.ravel()])
    observed = observed.shaped((flat.f0.size,))
    place = np.broadcast_to(model.device.contact_at, size)[flat.device]
    which = (observed.energy_error <= settings.energy_tolerance) & np.isfinite(place)
    columns = {key: np.full(flat.f0.size, nan, np.float32) for key in CLOSING}
    for at, part in deciders(model.levels, flat.device, decided, np.flatnonzero(which)):
        saddle = np.broadcast_to(part.barrier.first + part.barrier.midpoint, size)[flat.device[at]]
        # A cell that has settled on its side of the saddle never reaches beyond it.
        over = (observed.well[at] == 1) & (place[at] < saddle) & (settings.start == FIRST)
        window = np.fmin(np.where(over, observed.t_settled[at], np.inf), flat.t_end[at])
        for key, values in follow_closures(part, flat.take(at), window, settings).items():
            columns[key][at] = values
    return {key: values.reshape(shape) for key, values in columns.items()}


CLOSURES = {
    "t_closed": ("first closure", " us"),
    "closed_for": ("then closed, to the end if it never opens", " us"),
    "openings": ("openings", ""),
    "closed_share": ("share of the time since then closed", ""),
}
"""Words and unit of each of `Closures`."""


def sections(study: Study, verdicts: Sequence[Verdict]) -> list[str]:
    """Write a line and a table in Markdown; none if nothing closes."""
    closed = [verdict for verdict in verdicts if np.isfinite(verdict.more.get("t_closed", np.nan))]
    if not closed:
        return []
    horizon = plain(study.horizon / 1e3)
    cells = []
    for verdict in closed:
        where, more = f"{verdict.requirement}, {verdict.corner}", verdict.more
        for key, (words, unit) in CLOSURES.items():
            value, error = plain(more[key]), plain(more[f"{key}_error"], 1)
            cells.append([words, value + unit, error + unit, where])
    words = f"The electrode, to {horizon} ms after a shock:\n"
    return [words, table(["what", "value", "error", "under"], cells)]

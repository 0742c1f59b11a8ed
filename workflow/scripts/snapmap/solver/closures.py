"""When the midpoint of the beam touches an electrode on its way, and for how long."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import fsum, nan
from typing import NamedTuple

import numpy as np

from . import simd_loop
from .cells import Cells, Observations
from .kernel.rows import LANES
from .models import Follows, Model, deciders
from .outcome import REPEATED_STEP
from .settings import MOVE, Settings


class Closures(NamedTuple):
    """What an electrode sees; numbers, or arrays (cells,); NaN where it never closes.

    t_closed: when it first closes, us after the start of the pulse
    closed_for: how long it then stays closed, us; to the end of the time followed, if it never
        opens
    openings: how often it opens in that time
    closed_share: share closed of the time from t_closed to that end
    """

    t_closed: float | np.ndarray
    closed_for: float | np.ndarray
    openings: float | np.ndarray
    closed_share: float | np.ndarray


def closures_of(instants: Sequence[float], is_closed: bool, end: float) -> Closures:
    """What an electrode sees of a beam that touches it and leaves it by turns.

    instants: when it does, ascending, us; is_closed: whether it touches at 0
    end: of the time followed, us
    """
    turns = [0.0] * is_closed + [instant for instant in instants if instant < end]
    if not turns:
        return Closures(nan, nan, nan, nan)
    openings = len(turns) // 2
    turns += [end] * (len(turns) % 2)
    closed = [opens - closes for closes, opens in zip(turns[::2], turns[1::2], strict=True)]
    return Closures(turns[0], closed[0], openings, fsum(closed) / (end - turns[0]))


def passages(w: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where columns of samples, (samples, columns), pass their level, (columns,), either way.

    Returns column and place of each, in samples, ascending: linear between two.
    """
    closed = w <= level
    sample, column = np.nonzero(closed[1:] != closed[:-1])
    before, after = w[sample, column], w[sample + 1, column]
    return column, sample + (before - level[column]) / (before - after)


# ASSUME: the electrode is an observer: it neither stops the beam nor holds it, so that bounces are
# those of the ringing beam.
def follow_closures(
    model: Model, cells: Cells, window: np.ndarray, threads: int = 1, repeat: bool = True
) -> dict[str, np.ndarray]:
    """Follow cells, (cells,), in the steps that motions need, each for its window, us.

    repeat: whether in another step, too
    Returns the fields of `Closures` up to t_end and, each with `_error` at the end of its name, by
    how much they differ in the other step.
    """
    found = _follow(model, cells, window, threads)._asdict()
    if repeat:
        again = _follow(model.with_step(REPEATED_STEP), cells, window, threads)._asdict()
        found |= {f"{key}_error": abs(again[key] - found[key]) for key in again}
    return found


def _follow(model, cells, window, threads):
    dt, size = model.steps.of(cells, MOVE), len(model.device)
    ways = np.broadcast_to(model.device.contact_at - model.barrier.first, size)[cells.device]
    steps = np.ceil(window / dt).astype(np.int64) + 1
    found = Closures(*np.empty((len(Closures._fields), dt.size)))

    def follow(these):
        level, instants = ways[these], [[] for _ in these]
        last = np.zeros((1, these.size))  # at rest, half a step before the start
        group = cells.take(these), dt[these], steps[these].max()
        for first, w in simd_loop.midpoints(model, *group):
            w = np.concatenate([last, w])
            for column, place in zip(*passages(w, level), strict=True):
                instants[column].append(float((first + place - 0.5) * dt[these[column]]))
            last = w[-1:]
        for i, cell in enumerate(these):
            facts = closures_of(instants[i], bool(level[i] >= 0), float(cells.t_end[cell]))
            for values, fact in zip(found, facts, strict=True):
                values[cell] = fact

    # Lanes run together to the end of the longest: those of one call should be of one length.
    order = np.argsort(-steps, kind="stable")
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(LANES, order.size, LANES))))
    return found


def closures_again(
    model: Follows, cells: Cells, seen: Observations, settings: Settings
) -> dict[str, np.ndarray]:
    """Follow cells of any shape again, each as it was decided.

    seen: what was observed of them
    Returns what `follow_closures` does, in that shape; NaN, too, of cells whose runs failed.
    """
    flat, size = cells.flat(), len(model.device)
    level, t_settled = (
        np.zeros_like(seen.well) if seen.level is None else seen.level,
        seen.t_settled,
    )
    place = np.broadcast_to(model.device.contact_at, size)[flat.device]
    believed = seen.energy_error.ravel() <= settings.energy_tolerance
    which = np.flatnonzero(believed & np.isfinite(place))
    made: dict[str, np.ndarray] = {}
    for at, part in deciders(
        model.levels, flat.device, level.ravel(), seen.halvings.ravel(), which
    ):
        saddle = np.broadcast_to(part.barrier.first + part.barrier.midpoint, size)[flat.device[at]]
        # What is proven to stay on this side of the saddle reaches nothing beyond it.
        over = (seen.well.ravel()[at] == 1) & (place[at] < saddle)
        window = np.where(over, np.fmin(t_settled.ravel()[at], flat.t_end[at]), flat.t_end[at])
        found = follow_closures(part, flat.take(at), window, settings.threads, settings.repeat)
        for key, values in found.items():
            made.setdefault(key, np.full(flat.f0.size, nan, np.float32))[at] = values
    return {key: values.reshape(np.shape(cells.f0)) for key, values in made.items()}

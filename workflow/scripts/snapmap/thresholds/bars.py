"""Error bars of thresholds: what other levels, other steps and the refinement leave open."""

from typing import NamedTuple

import numpy as np

from ..solver.adaptive import Survey
from ..solver.cells import Rows
from ..solver.settings import Settings
from ..solver.steps import stiffness_share
from .search import Ask, Edges, asker, scan
from .transitions import BESIDE, CLOSEST_STEP, Window, chosen, outermost
from .witness import BELOW, NEAREST, close_edges

LOOKS = 4
"""At so many distances another level must agree that a threshold lies between."""
OTHER_STEP = 2.0**0.5
"""Times the own step, of the runs by which the error of time is seen: of second order, it changes
by itself."""
CHATTERS = 0.5
"""On a contact so near a hard one, or under a pulse with corners, the mass may chatter, which takes
short steps to see."""
OTHERS_STEP, JUDGED_STEP = 2.0, 4.0
"""Steps of other models' scans of a ragged row, and of the judge's, over its own."""
FARTHEST = 0.25
"""Relative distance up to which another level's threshold is looked for; beyond, a row is ragged.
"""


class Scan(NamedTuple):
    """What the scan of the deciding level shows of rows, (rows,).

    edges: refined; window: its scan; limits: where islands are looked for at all
    """

    edges: Edges
    N_first: np.ndarray
    ragged: np.ndarray
    window: Window
    limits: Window


def error_bars(
    models: Survey, rows: Rows, settings: Settings, tolerance: float, done: Scan, rings: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compare the deciding level with others: errors of N_first, and ragged rows, (rows,).

    rings: rows in which the device rings after its pulse, (rows,)
    """
    decides, doubts, better, judge = models.decides, models.doubts, models.better, models.judge
    edges, N_first, ragged, window, limits = done

    def ask(model, until="edge"):
        return asker(model, rows, settings, until)

    others = [m for m in (decides.with_step(OTHER_STEP), doubts, better) if m is not None]
    clean = np.where(ragged, np.nan, N_first)
    in_time, *in_space = (distance(ask(other), clean, tolerance) for other in others)
    share = stiffness_share(decides.device)[rows.device]
    smooth = np.array([pulse.is_smooth for pulse in rows.pulses])[rows.pulse]
    chatters, fine = (share > CHATTERS) | ((share > 0) & ~smooth), models.finest
    in_fine = distance(ask(fine), np.where(chatters, clean, np.nan), tolerance)
    # The better level may itself be off by as much.
    near = np.fmax(in_time, in_fine) + np.max(in_space, axis=0) + (in_space[1] if better else 0.0)
    # An island below that finer steps open belongs to the bar.
    if models.looks is decides:
        alone = np.where(~ragged & rings, N_first, np.nan)
        ends = (1 - tolerance) * alone, alone
        close, *_ = close_edges(fine, rows, settings, *ends, [BELOW], NEAREST)
        near = np.fmax(near, N_first - outermost(close.row, close.high, alone.size)[0])
    apart = np.isinf(near)
    ragged = ragged | apart
    window = chosen(apart, limits, window)
    wide, wider = (window._replace(step=by * window.step) for by in (OTHERS_STEP, JUDGED_STEP))
    if models.looks is not decides:
        others[0] = models.looks.with_step(1 / OTHER_STEP)
    # The longer steps of a label tell where to look.
    firsts = [_elsewhere(ask(other, "snap"), wide, ragged) for other in others]
    if judge is not None:
        firsts.append(_elsewhere(ask(judge, "snap"), wider, ragged))
    finest = _elsewhere(ask(fine, "snap"), wider, ragged & chatters)
    firsts.append(np.where(chatters, finest, N_first))
    far = np.fmax(_spread(edges, N_first), np.max(abs(N_first - np.array(firsts)), axis=0))
    closest = np.where(rings, CLOSEST_STEP, 0.0)
    open_by = np.where(ragged, window.step, closest) + tolerance
    return np.where(ragged, far, near) + open_by * N_first, ragged


def _spread(edges, N_first):
    """How far above N_first the last change lies that is close to it, (rows,)."""
    spread = np.zeros(N_first.size)
    above = edges.high - N_first[edges.row]
    close = edges.high <= BESIDE * N_first[edges.row]
    np.fmax.at(spread, edges.row[close], above[close])
    return spread


def _elsewhere(ask, window, ragged):
    """N_first of ragged rows, (rows,), as another level sees it on the same scan.

    The end of the window stands for an N_first that lies beyond it.
    """
    N = window._replace(low=np.where(ragged, window.low, np.nan)).N
    edges, begins, _ = scan(ask, N)
    first, _ = outermost(edges.row[edges.rising], edges.high[edges.rising], ragged.size)
    return np.where(begins, window.low, np.where(np.isnan(first), window.high, first))


def distance(ask: Ask, N_first: np.ndarray, tolerance: float) -> np.ndarray:
    """Find how far from N_first, at most, another level changes from quiet to snap, (rows,).

    There and at each of the next LOOKS - 1 doublings it is quiet below and snaps above: where
    labels change back and forth closely, a single look is luck.
    """
    distances = np.where(np.isnan(N_first), np.nan, np.inf)
    reach = np.full(N_first.size, tolerance / 4)
    while (left := np.flatnonzero(np.isinf(distances) & (reach < FARTHEST))).size:
        reaches = np.minimum(np.multiply.outer(reach[left], 2.0 ** np.arange(LOOKS)), FARTHEST)
        N = np.full((N_first.size, 2 * LOOKS), np.nan)
        N[left] = N_first[left, np.newaxis] * np.hstack([1 - reaches, 1 + reaches])
        below, above = np.hsplit(np.isfinite(ask(N))[left], 2)
        differ = below | ~above
        passed = np.where(differ.any(axis=1), LOOKS - np.argmax(differ[:, ::-1], axis=1), 0)
        distances[left[passed == 0]] = (reach * N_first)[left[passed == 0]]
        reach[left] *= 2.0**passed
    return distances

"""The shock of each lane, tabulated block by block."""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from ...numerics import pieces as curve
from ...numerics.kernels import called, compiled, fma, sine, widen_vectors
from . import rows as R
from .access import numbers
from .rows import LANES

Pulses = tuple[np.ndarray, np.ndarray, np.ndarray]
BLOCK = 128
"""Steps in a block: lanes are checked after it, and pulses are tabulated for it."""


class PulseState(NamedTuple):
    """Progress of the pulse of each lane, (LANES,); modified in place.

    pulse: its number; piece: number of the last piece that was entered
    steps: number of steps done; lasts: number of samples until the pulse is over
    """

    pulse: np.ndarray
    piece: np.ndarray
    steps: np.ndarray
    lasts: np.ndarray


# No kernel of its own: one that returns arrays to Python must not be part of others. If it is
# compiled anew beside one that has it from the disk, numba mixes up what both of them refer to.
@register_jitable
def no_pulse() -> PulseState:
    """Make the state of lanes without a pulse."""
    pulse, piece, steps, lasts = np.zeros((4, LANES), np.int64)
    return PulseState(pulse, piece, steps, lasts)


@compiled
def begin_pulse(
    work: np.ndarray, l: int, state: PulseState, pulses: Pulses, pulse: int, x_step: float
) -> None:
    """Begin a pulse, by its number, in lane l; pulses: as in `Task`; x_step: f0 dt."""
    bounds, jumps = pulses[1:]
    state.pulse[l], state.piece[l], state.steps[l] = pulse, bounds[pulse] - 1, 0
    state.lasts[l] = curve.lasts(jumps[pulse, 1], x_step)
    numbers(work)[R.X_STEP, l] = x_step


@compiled
def set_out(work: np.ndarray, shocks: np.ndarray, state: PulseState, pulses: Pulses) -> None:
    """Set shocks, (BLOCK LANES,), to a dt^2 of each lane in each step of the next block."""
    pieces, bounds, jumps = pulses
    X, joined = numbers(work), 0
    for l in range(LANES):
        steps, pulse, step = state.steps[l], state.pulse[l], X[R.X_STEP, l]
        left = state.lasts[l] - steps
        X[R.PULSE_LEFT, l] = left
        if left <= 0:
            # A finished lane goes on with zeros: denormal numbers would slow down all lanes.
            for name in range(R.PIECE, R.PULSE_LEFT):
                X[name, l] = 0.0
            continue
        end, x = bounds[pulse + 1], step * steps
        k = curve.at(pieces, max(state.piece[l], bounds[pulse]), end, x)
        if k != state.piece[l]:
            state.piece[l] = k
            for column in range(curve.COLUMNS):
                X[R.PIECE + column, l] = pieces[k, column]
            X[R.TURN, l] = 4 * sine(X[R.TURNS, l] * step / 2) ** 2
        X[R.PULSE, l] = x
        joins = k + 1 < end and pieces[k + 1, curve.BEGIN] < x + BLOCK * step
        joins |= steps == 0 and jumps[pulse, 0] != 0
        joins |= left <= BLOCK + 1 and jumps[pulse, 1] != 0
        joined |= joins << l
    go_on(work, shocks)
    # Lanes whose pieces join in this block, or whose pulse jumps, are sampled step by step.
    for l in range(LANES):
        if joined >> l & 1:
            sample_lane(work, shocks, l, state, pulses)


@called
def sample_lane(
    work: np.ndarray, shocks: np.ndarray, l: int, state: PulseState, pulses: Pulses
) -> None:
    """Sample the pieces of lane l in a block; lines of a record have no joint but at their ends."""
    (pieces, bounds, jumps), X = pulses, numbers(work)
    pulse, k, step, a = state.pulse[l], state.piece[l], X[R.X_STEP, l], X[R.AMPLITUDE, l]
    ends, end = (jumps[pulse, 0], jumps[pulse, 1]), bounds[pulse + 1]
    i, first = 0, state.steps[l]
    while i < BLOCK:
        x = step * (first + i)
        k = curve.at(pieces, k, end, x)
        shocks[i * LANES + l] = a * curve.sample(pieces, k, ends, x, step)
        i += 1
        if pieces[k, curve.TURNS] != 0.0:
            continue
        start, slope, begin = pieces[k, curve.VALUE], pieces[k, curve.SLOPE], pieces[k, curve.BEGIN]
        over = min(pieces[k + 1, curve.BEGIN], 1 - step) if k + 1 < end else 1 - step
        while i < BLOCK and step * (first + i) < over:
            line = start + slope * (step * (first + i) - begin)
            shocks[i * LANES + l] = a * line
            i += 1


@compiled
def go_on(work: np.ndarray, shocks: np.ndarray) -> None:
    """Tabulate each lane's piece in a block, from x = PULSE on, also beyond the end of the piece.

    A wave v of phase p per step follows v+ - 2 v + v- = 4 sin^2(p/2) (centre - v).
    """
    widen_vectors()
    X = numbers(work)
    for l in range(LANES):
        s, turns = X[R.PULSE, l] - X[R.BEGIN, l], X[R.TURNS, l]
        slope, lift, swing = X[R.SLOPE, l], X[R.LIFT, l], X[R.SWING, l]
        X[R.PULSE, l] = curve.form(X[R.START, l], slope, turns, lift, swing, s)
        last = curve.increment(slope, turns, lift, swing, s, X[R.X_STEP, l])
        X[R.PULSE_STEP, l] = last
    for step in range(BLOCK):
        for l in range(LANES):
            pulse, left = X[R.PULSE, l], X[R.PULSE_LEFT, l]
            bend = X[R.START, l] + X[R.LIFT, l] - pulse
            pulse_step = fma(X[R.TURN, l], bend, X[R.PULSE_STEP, l])
            X[R.PULSE_STEP, l] = pulse_step
            X[R.PULSE, l] = pulse + pulse_step
            X[R.PULSE_LEFT, l] = left - 1.0
            a = X[R.AMPLITUDE, l] * pulse if left > 0.0 else 0.0
            shocks[step * LANES + l] = a

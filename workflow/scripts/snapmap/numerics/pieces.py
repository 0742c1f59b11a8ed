"""A curve in pieces, over x from 0 to 1, as kernels evaluate it; zero before and beyond.

A piece is a row BEGIN, VALUE, SLOPE, TURNS, LIFT, SWING: with s = x - BEGIN and p = 2 pi TURNS s,

    VALUE + SLOPE s + LIFT (1 - cos p) + SWING sin p

It is straight or it turns: SLOPE or TURNS is 0. Pieces join without a jump; only at its two ends a
curve may jump, and these jumps are given as `ends`, what it begins and ends with.
"""

from numba import njit

from .arithmetic import sine

COLUMNS = BEGIN, VALUE, SLOPE, TURNS, LIFT, SWING = range(6)
_JIT = {"error_model": "numpy", "cache": True}


@njit(**_JIT)
def value(piece, x):
    """The piece at x."""
    s = x - piece[BEGIN]
    turned, found = piece[TURNS] * s, piece[VALUE] + piece[SLOPE] * s
    if piece[LIFT] != 0:
        found += piece[LIFT] * (2 * sine(turned / 2) ** 2)
    if piece[SWING] != 0:
        found += piece[SWING] * sine(turned)
    return found


@njit(**_JIT)
def recurrence(piece, x, step):
    """t, c and d with which the piece goes on: d+ = d + t (c - v), v+ = v + d+, and v at x."""
    turned, half = piece[TURNS] * (x - piece[BEGIN]), piece[TURNS] * step / 2
    twice = 2 * sine(half)
    last = piece[SLOPE] * step
    if piece[LIFT] != 0:
        last += piece[LIFT] * (twice * sine(turned - half))
    if piece[SWING] != 0:
        last += piece[SWING] * (twice * sine(turned - half + 0.25))
    return twice * twice, piece[VALUE] + piece[LIFT], last, value(piece, x)


@njit(**_JIT)
def at(pieces, k, x):
    """Number of the piece that x is in; k: of one that does not begin beyond x."""
    while k + 1 < len(pieces) and pieces[k + 1, BEGIN] <= x:
        k += 1
    return k


@njit(**_JIT)
def sample(pieces, ends, k, x, step):
    """The curve at x; at a jump its mean over a step about x, so that a sum over steps is exact.

    k: as in `at`
    """
    beyond = (x - 1) / step + 0.5
    if x >= 1:
        return ends[1] * (1 - beyond) if beyond < 1 else 0.0
    found = value(pieces[at(pieces, k, x)], x)
    if x == 0:
        found -= ends[0] / 2
    return found - ends[1] * beyond if beyond > 0 else found


@njit(**_JIT)
def lasts(ends, step):
    """Number of steps, the one at 0 among them, until the curve is over."""
    last = 1 / step
    return int(last + 0.5) + 1 if ends[1] != 0 else int(-(-last // 1))

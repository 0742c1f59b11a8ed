"""A curve made of pieces over x from 0 to 1, as kernels evaluate it; it is zero outside.

A piece is a row BEGIN, VALUE, SLOPE, TURNS, LIFT, SWING. With s = x - BEGIN and p = 2 pi TURNS s
its value is

    VALUE + SLOPE s + LIFT (1 - cos p) + SWING sin p

A piece is a line, with TURNS = 0, or a wave, with SLOPE = 0. A curve is continuous but for jumps at
its two ends.
"""

import numpy as np
from numba import njit

from .kernels import compiled, sine

BEGIN, VALUE, SLOPE, TURNS, LIFT, SWING = range(6)
COLUMNS = 6


@njit(inline="always")
def form(start: float, slope: float, turns: float, lift: float, swing: float, s: float) -> float:
    """Evaluate a piece at the distance s from its begin."""
    lifted, swung = 2 * sine(turns * s / 2) ** 2, sine(turns * s)
    return start + slope * s + lift * lifted + swing * swung


@njit(inline="always")
def increment(
    slope: float, turns: float, lift: float, swing: float, s: float, step: float
) -> float:
    """Return the piece at s minus the piece at s - step, without cancellation."""
    half = turns * step / 2
    twice, middle = 2 * sine(half), turns * s - half
    return slope * step + lift * (twice * sine(middle)) + swing * (twice * sine(middle + 0.25))


@compiled
def value(pieces: np.ndarray, k: int, x: float) -> float:
    """Evaluate piece k at x."""
    start, slope, turns = pieces[k, VALUE], pieces[k, SLOPE], pieces[k, TURNS]
    s = x - pieces[k, BEGIN]
    if turns == 0.0:  # a record is lines only, and the sines would take most of the time
        return start + slope * s
    return form(start, slope, turns, pieces[k, LIFT], pieces[k, SWING], s)


@compiled
def at(pieces: np.ndarray, k: int, end: int, x: float) -> int:
    """Find the piece that holds x, from number k, which begins before x, up to before `end`."""
    while k + 1 < end and pieces[k + 1, BEGIN] <= x:
        k += 1
    return k


@compiled
def sample(pieces: np.ndarray, k: int, jumps: tuple[float, float], x: float, step: float) -> float:
    """Sample the curve at x, in piece k, such that a sum over steps is exact at the jumps.

    At a jump the sample is the curve's mean over the step around x.

    jumps: values at the begin and the end of the curve
    """
    begin, end = jumps
    beyond = (x - 1) / step + 0.5
    if x >= 1:
        return end * (1 - beyond) if beyond < 1 else 0.0
    at_x = value(pieces, k, x)
    if x == 0:
        at_x -= begin / 2
    return at_x - end * beyond if beyond > 0 else at_x


@compiled
def lasts(end: float, step: float) -> int:
    """Count the samples from x = 0 until the curve is over; end: its value at x = 1."""
    last = 1 / step
    return int(last + 0.5) + 1 if end != 0 else int(-(-last // 1))

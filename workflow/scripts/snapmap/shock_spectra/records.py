"""Seeded records that meet a shock response spectrum."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..numerics.kernels import compiled, sine
from ..pulse import Pulse, straight
from .spectrum import PER_PERIOD, Q, frequencies, level, response

# ASSUME: a shock of a spectrum is a sum of wavelets, each beginning within its own length.
LOBES = (5, 7, 9, 11)
"""Half periods in a wavelet; odd, so that it leaves no velocity and no displacement."""
ROUNDS = 25
"""Of corrections of a record, of which the best is taken."""
BAND = 6.0
"""dB within which a record must meet its spectrum, as a laboratory must."""
DIGITS = 6
"""Of the amplitudes that are kept: the same on every machine."""


class Record(NamedTuple):
    """A record that meets a spectrum.

    pulse: with its own duration; peak: multiples of g
    deviation: of its spectrum from the one that was asked for, dB, (frequencies,)
    """

    pulse: Pulse
    peak: float
    deviation: np.ndarray


def record(points: Sequence[Sequence[float]], seed: Sequence[int]) -> Record:
    """Draw a record whose response spectrum is near one; wavelets, their amplitudes corrected.

    points: as from `check_points`; seed: of the wavelets' lengths, signs and begins
    Raises ValueError, one line, where it is not met within BAND.
    """
    f = frequencies(points[0][0], points[-1][0])
    asked, draw = level(points, f), np.random.default_rng(seed)
    lobes, sign = draw.choice(LOBES, f.size), draw.choice([-1.0, 1.0], f.size)
    lasts = lobes / (2 * f)
    begin = draw.random(f.size) * lasts
    step = 1 / (PER_PERIOD * f[-1])
    samples = 1 + math.ceil((begin + lasts).max() / step)
    amplitude, best = sign * asked / Q, None
    for _ in range(ROUNDS):
        amplitude = np.array([float(f"{one:.{DIGITS}g}") for one in amplitude])
        a = _sum(amplitude, f * step, begin / step, lasts / step, samples)
        deviation = 20 * np.log10(response(a, step, f) / asked)
        if best is None or abs(deviation).max() < abs(best[1]).max():
            best = a, deviation
        amplitude = amplitude * 10 ** (-deviation / 20)
    a, deviation = best
    if not abs(deviation).max() < BAND:
        raise ValueError(f"srs: no record meets it within {BAND:g} dB; write a smoother spectrum")
    peak = float(abs(a).max())
    pieces = straight(np.arange(samples) / (samples - 1), a / peak)
    return Record(Pulse("srs", pieces, 1e6 * step * (samples - 1)), peak, deviation)


@compiled
def _sum(amplitude, f, begin, lasts, samples):
    """The sum of wavelets, (samples,); f, begin, lasts: in samples."""
    total = np.zeros(samples)
    for i in range(f.size):
        for k in range(int(begin[i]) + 1, min(samples, int(begin[i] + lasts[i]) + 1)):
            s = k - begin[i]
            total[k] += amplitude[i] * sine(s / (2 * lasts[i])) * sine(f[i] * s)
    return total

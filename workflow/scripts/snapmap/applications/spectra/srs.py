"""Shock response spectra, and seeded records that meet one."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from ...numerics import portable
from ...pulse.pulse import Pulse, straight
from ...values.quantities import Value
from .psd import LEVELS, Points

Q = 10.0
"""Quality factor of the oscillators of a shock response spectrum; 10 is customary."""
PER_OCTAVE = 6
PER_PERIOD = 16
"""Samples in a period of the highest frequency; they miss the largest value by 2 % at most."""
MOST_SPAN = 10_000
"""Largest ratio of the frequencies of a spectrum, as a record must have periods of both ends."""
# ASSUME: a shock of a spectrum is a sum of wavelets; each begins within its own length.
LOBES = (5, 7, 9, 11)
"""Half periods in a wavelet; with an odd number no velocity or displacement remains."""
LONG_LOBES = (21, 31, 41)
"""The same where LOBES fail, as beside a notch: long wavelets need less acceleration for a level
and so disturb others less. None is longer than the longest one of the lowest frequency."""
ROUNDS = 25
"""Number of corrections of a draw; the best one counts."""
DRAWS, LONG_DRAWS = 4, 16
"""Most draws of wavelets with LOBES, and then with LONG_LOBES, until one meets the spectrum."""
BAND = 3.0
"""Largest deviation of a record from its spectrum, dB, both ways."""
DIGITS = 6
"""Significant digits of the wavelets' amplitudes, so that every machine has the same."""


def response(acceleration: np.ndarray, step: float, f: np.ndarray) -> np.ndarray:
    """Find the largest absolute accelerations of oscillators of Q = 10 on a frame, (frequencies,).

    acceleration: of the frame, from rest, linear between samples, 0 after them, (samples,)
    step: between samples, s; f: Hz, (frequencies,)
    The method is Smallwood's ramp-invariant recursion, up to one period of each oscillator after
    the end. The unit is that of `acceleration`.
    """
    from scipy.signal import lfilter  # half a second, for which nobody else has to wait

    largest = np.empty(len(f))
    for place, frequency in enumerate(f):
        turned = 2 * np.pi * frequency * step
        decay = math.exp(-turned / (2 * Q))
        phase = turned * math.sqrt(1 - 1 / (4 * Q * Q))
        cosine, swung = decay * math.cos(phase), decay * math.sin(phase)
        mean = swung / phase
        b = 1 - mean, 2 * (mean - cosine), decay**2 - mean
        after = np.zeros(math.ceil(1 / (frequency * step)))
        answer = lfilter(b, (1.0, -2 * cosine, decay**2), np.append(acceleration, after))
        largest[place] = abs(answer).max()
    return largest


def frequencies(points: Sequence[Sequence[float]]) -> np.ndarray:
    """Return sixth octaves from the lowest frequency of a spectrum, Hz, and its highest."""
    low, high = points[0][0], points[-1][0]
    octaves = math.ceil(math.log2(high / low))
    f = portable.geometric(low, low * 2.0**octaves, PER_OCTAVE * octaves + 1)
    return np.append(f[f < high * (1 - 1e-9)], high)


Levels = Annotated[Value, Points("level", LEVELS, "[(500, 700), (2000, 1500)]")]


def check_points(points: Sequence[Sequence[float]]) -> np.ndarray:
    """Return a spectrum's points as an array, (points, 2); raises ValueError for invalid ones."""
    pairs = np.asarray(points, float)
    if pairs[-1, 0] > MOST_SPAN * pairs[0, 0]:
        raise ValueError(f"srs: frequencies span more than 1:{MOST_SPAN}; write a narrower range")
    return pairs


def level(points: Sequence[Sequence[float]], f: np.ndarray) -> np.ndarray:
    """Interpolate a spectrum at frequencies, straight between its points on logarithmic scales."""
    known, values = np.log(np.array(points, float).T)
    return np.exp(np.interp(np.log(f), known, values))


class Record(NamedTuple):
    """A record that meets a spectrum.

    pulse: the record over its peak, with its own duration; peak: multiples of g
    deviation: of its spectrum from the required one, dB, (frequencies,)
    """

    pulse: Pulse
    peak: float
    deviation: np.ndarray


def record(points: Sequence[Sequence[float]], seed: Sequence[int]) -> Record:
    """Draw sums of wavelets until one meets a response spectrum within BAND.

    points: as `check_points` returns them; seed: of the wavelets' lengths, signs and begins
    Raises ValueError, one line, if none of DRAWS and LONG_DRAWS does.
    """
    for number in range(DRAWS + LONG_DRAWS):
        of_draw = [*seed, number] if number else seed
        drawn = _draw(points, of_draw, LOBES if number < DRAWS else LONG_LOBES)
        if abs(drawn.deviation).max() < BAND:
            return drawn
    raise ValueError(f"srs: no record meets it within {BAND:g} dB; write a smoother spectrum")


def _draw(points, seed, lobes):
    """Draw a sum of wavelets, and correct their amplitudes towards a response spectrum."""
    from .sums import wavelets  # numba, for which no config that is read has to wait

    f = frequencies(points)
    target, draw = level(points, f), np.random.default_rng(seed)
    lobes, sign = draw.choice(lobes, f.size), draw.choice([-1.0, 1.0], f.size)
    longest = np.floor(LOBES[-1] * (f / f[0]))
    lasts = np.minimum(lobes, longest - (longest + 1) % 2) / (2 * f)
    begin = draw.random(f.size) * lasts
    step = 1 / (PER_PERIOD * f[-1])
    samples = 1 + math.ceil((begin + lasts).max() / step)
    amplitude, best = sign * target / Q, None
    for _ in range(ROUNDS):
        amplitude = np.array([float(f"{a:.{DIGITS}g}") for a in amplitude])
        a = wavelets(amplitude, f * step, begin / step, lasts / step, samples)
        deviation = 20 * np.log10(response(a, step, f) / target)
        if best is None or abs(deviation).max() < abs(best[1]).max():
            best = a, deviation
        amplitude = amplitude * 10 ** (-deviation / 20)
    a, deviation = best
    peak = float(abs(a).max())
    pieces = straight(np.arange(samples) / (samples - 1), a / peak)
    return Record(Pulse("srs", pieces, 1e6 * step * (samples - 1)), peak, deviation)

"""Shock response spectra."""

import math
from collections.abc import Sequence

import numpy as np

from ..numerics import portable
from ..pulse import Pulse

Q = 10.0
"""Quality factor of the oscillators whose largest answers a spectrum tells, as is customary."""
PER_OCTAVE = 6
PER_PERIOD = 16
"""Samples in a period of the highest frequency; the largest is missed by 2 % at most."""
LEAST_SAMPLES = 1000
"""In a pulse whose spectrum is taken."""
MOST_SPAN = 10_000
"""Highest over lowest frequency of a spectrum, as a record must have periods of both."""


def response(acceleration: np.ndarray, step: float, f: np.ndarray) -> np.ndarray:
    """Largest absolute acceleration of oscillators of Q = 10 on a frame, in the frame's unit.

    acceleration: from rest, linear between samples, (samples,), which 0 follow; step: between them,
        s; f: Hz, (frequencies,)
    By the ramp-invariant recursion of Smallwood, to a period of each oscillator after the end.
    """
    from scipy.signal import lfilter  # half a second, for which nobody else has to wait

    largest = np.empty(len(f))
    for place, own in enumerate(f):
        turned = 2 * np.pi * own * step
        decay = math.exp(-turned / (2 * Q))
        phase = turned * math.sqrt(1 - 1 / (4 * Q * Q))
        cosine, swung = decay * math.cos(phase), decay * math.sin(phase)
        mean = swung / phase
        b = 1 - mean, 2 * (mean - cosine), decay**2 - mean
        after = np.zeros(math.ceil(1 / (own * step)))
        found = lfilter(b, (1.0, -2 * cosine, decay**2), np.append(acceleration, after))
        largest[place] = abs(found).max()
    return largest


def frequencies(low: float, high: float) -> np.ndarray:
    """Sixth octaves from low on, Hz, and high."""
    octaves = math.ceil(math.log2(high / low))
    f = portable.geometric(low, low * 2.0**octaves, PER_OCTAVE * octaves + 1)
    return np.append(f[f < high * (1 - 1e-9)], high)


def pulse_response(pulse: Pulse, lasts: float, f: Sequence[float]) -> np.ndarray:
    """The response spectrum of a pulse that lasts so many us, over its peak; f: Hz."""
    steps = math.ceil(max(LEAST_SAMPLES, 1e-6 * lasts * PER_PERIOD * np.max(f)))
    return response(pulse.at(np.linspace(0, 1, steps + 1)), 1e-6 * lasts / steps, f)


def check_points(points: Sequence[Sequence[float]]) -> np.ndarray:
    """A spectrum's points, (points, 2); a ValueError, one line, for what cannot be."""
    try:
        found = np.array(points, float).reshape(-1, 2)
    except (TypeError, ValueError):
        raise ValueError(f"srs: {points!r} is no list of pairs of Hz and multiples of g") from None
    if len(found) < 2 or not (np.diff(found[:, 0]) > 0).all():
        raise ValueError("srs: give two frequencies or more, ascending")
    if not (np.isfinite(found) & (found > 0)).all():
        raise ValueError("srs: a frequency or a level is no finite number above 0")
    if found[-1, 0] > MOST_SPAN * found[0, 0]:
        raise ValueError(f"srs: its frequencies span more than 1 : {MOST_SPAN}")
    return found


def level(points: Sequence[Sequence[float]], f: np.ndarray) -> np.ndarray:
    """A spectrum at frequencies, straight between its points on logarithmic scales."""
    known, values = np.log(np.array(points, float).T)
    return np.exp(np.interp(np.log(f), known, values))

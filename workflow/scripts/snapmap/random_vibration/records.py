"""Seeded records of random vibration."""

import math
from collections.abc import Sequence

import numpy as np

from ..numerics.kernels import compiled, sine
from ..pulse import Pulse, straight
from .spectrum import Spectrum

PER_PERIOD = 16
"""Samples in a period of the highest frequency; straight lines between them leave images of it of
0.4 % of its amplitude, and take 1.3 %, which is given back."""


def record(spectrum: Spectrum, length: float, seed: Sequence[int]) -> tuple[Pulse, float]:
    """Draw a stationary Gaussian record, linear between samples; and its peak, multiples of g.

    a = sum sqrt(2 S df) cos(2 pi f t + phase), over f = df, 2 df, ..., df = 1/length, each phase
    drawn evenly. It begins and ends at rest, as its first and last sample are set to 0.
    length: s; seed: of the phases
    """
    samples = 1 << math.ceil(math.log2(PER_PERIOD * spectrum.f[-1] * length))
    lines = np.arange(1, math.floor(spectrum.f[-1] * length) + 1)
    f = lines / length
    amplitude = np.sqrt(2 * spectrum.at(f) / length) / _kept(lines / samples)
    turns = np.random.default_rng(seed).random(f.size)
    cosine, swung = _waves(turns)
    bins = np.zeros(samples // 2 + 1, complex)
    bins[lines] = amplitude * (cosine + 1j * swung) * samples / 2
    acceleration = np.append(np.fft.irfft(bins, samples), 0.0)
    acceleration[0] = 0.0
    peak = float(abs(acceleration).max())
    x = np.arange(samples + 1) / samples
    return Pulse("vibration", straight(x, acceleration / peak), 1e6 * length), peak


@compiled
def _waves(turns):
    """Cosine and sine of phases, given in turns."""
    cosine, swung = np.empty(turns.size), np.empty(turns.size)
    for i in range(turns.size):
        cosine[i], swung[i] = sine(turns[i] + 0.25), sine(turns[i])
    return cosine, swung


@compiled
def _kept(share):
    """What straight lines between samples keep of an amplitude; share: f over their rate."""
    kept = np.empty(share.size)
    for i in range(share.size):
        turned = np.pi * share[i]
        kept[i] = (sine(share[i] / 2) / turned) ** 2
    return kept

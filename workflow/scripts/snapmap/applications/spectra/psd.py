"""Random vibration: its spectrum, and seeded records of it."""

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np

from ...numerics.portable import sines
from ...pulse.pulse import Pulse, straight
from ...values.kinds import Whole
from ...values.quantities import Value
from .pairs import DENSITIES, Points

REACH = 0.01
"""Default probability of a snap within the duration of the vibration."""
SECONDS, PERIODS = 1.0, 10.0
"""A record lasts SECONDS, s, or PERIODS of the lowest frequency if these are longer."""
PER_PERIOD = 16
"""Samples in a period of the highest frequency. Straight lines between them lower its amplitude by
1.3 %, which `record` corrects, and add images of 0.4 %."""
MOST_SAMPLES = 2**21
"""Most samples of a record, 100 MB; a record of 1 Hz to 10 kHz has as many."""

Density = Annotated[Value, Points("density", DENSITIES, "[(20, 0.04), (2000, 0.04)]")]
Records = Annotated[int, Whole(1, 10_000)]


class Spectrum:
    """One-sided density of the frame's acceleration, straight between points on logarithmic scales.

    points: pairs of frequency (Hz) and density (g^2/Hz), ascending; ValueError for invalid ones
    """

    def __init__(self, points: Sequence[Sequence[float]]):
        """Take the points."""
        self.f, self.density = np.asarray(points, float).T
        ratios = zip(self.density[1:] / self.density[:-1], self.f[1:] / self.f[:-1], strict=True)
        self._slopes = np.array([math.log(S) / math.log(f) for S, f in ratios])

    def at(self, f: np.ndarray) -> np.ndarray:
        """Density at frequencies, g^2/Hz; 0 outside the points."""
        k = np.clip(np.searchsorted(self.f, f, side="right") - 1, 0, self.f.size - 2)
        within = (f >= self.f[0]) & (f <= self.f[-1])
        # Of single numbers: numpy's powers of arrays round by the processor.
        powers = zip((f / self.f[k]).tolist(), self._slopes[k].tolist(), strict=True)
        rises = np.array([ratio**slope for ratio, slope in powers])
        return np.where(within, self.density[k] * rises, 0.0)

    @property
    def rms(self) -> float:
        """Root mean square of the acceleration, multiples of g."""
        total, ratios = 0.0, self.f[1:] / self.f[:-1]
        for f, S, ratio, slope in zip(self.f, self.density, ratios, self._slopes, strict=False):
            power = slope + 1
            share = math.log(ratio) if abs(power) < 1e-9 else (ratio**power - 1) / power
            total += f * S * share
        return math.sqrt(total)

    def record_length(self, duration: float) -> float:
        """Return the length of one record, s, of a vibration; duration: s."""
        return min(duration, max(SECONDS, PERIODS / self.f[0]))

    def require_record(self, duration: float) -> None:
        """Raise ValueError, one line, if a record is too long or has no sine; duration: s."""
        length, (low, high) = self.record_length(duration), self.f[[0, -1]]
        samples = PER_PERIOD * high * length
        if samples > MOST_SAMPLES:
            raise ValueError(
                f"psd: a record of {length:.4g} s, from {low:g} to {high:g} Hz, has {samples:.2g} "
                f"samples, more than {MOST_SAMPLES:.2g}; write a higher lowest frequency, or a "
                "lower highest"
            )
        if math.floor(high * length) / length < low:
            line = f"of {length:.4g} s has no sine between {low:g} and {high:g} Hz; write"
            if length < SECONDS:
                raise ValueError(f"duration: a record {line} a longer time")
            raise ValueError(f"psd: a record {line} frequencies that are farther apart")

    def record(self, length: float, seed: Sequence[int]) -> tuple[Pulse, float]:
        """Draw a stationary Gaussian record, linear between samples.

        a = sum sqrt(2 S df) cos(2 pi f t + phase), over f = df, 2 df, ..., with df = 1/length and
        uniformly distributed phases. The first and the last sample are set to 0.
        length: s; seed: of the phases
        Returns the record over its peak, and the peak, multiples of g.
        """
        samples = 1 << math.ceil(math.log2(PER_PERIOD * self.f[-1] * length))
        lines = np.arange(1, math.floor(self.f[-1] * length) + 1)
        f, share = lines / length, lines / samples
        # Straight lines between samples keep this share of an amplitude.
        kept = (sines(share / 2) / (np.pi * share)) ** 2
        amplitude = np.sqrt(2 * self.at(f) / length) / kept
        turns = np.random.default_rng(seed).random(f.size)
        bins = np.zeros(samples // 2 + 1, complex)
        bins[lines] = amplitude * (sines(turns + 0.25) + 1j * sines(turns)) * samples / 2
        acceleration = np.append(np.fft.irfft(bins, samples), 0.0)
        acceleration[0] = 0.0
        peak = float(abs(acceleration).max())
        x = np.arange(samples + 1) / samples
        return Pulse("vibration", straight(x, acceleration / peak), 1e6 * length), peak

"""Spectra of random vibration."""

import math
from collections.abc import Sequence

import numpy as np

REACH = 0.01
"""Probability of a snap within the duration that vibration may have, by default."""
SECONDS, PERIODS = 1.0, 10.0
"""Length of a record, at least so many periods of the lowest frequency; s."""


class Spectrum:
    """One-sided power spectral density of the frame's acceleration, straight between its points on
    logarithmic scales; a ValueError, one line, for what cannot be.

    points: frequency (Hz) and density (g^2/Hz), ascending
    """

    def __init__(self, points: Sequence[Sequence[float]]):
        """Take the points."""
        try:
            self.f, self.density = np.array(points, float).reshape(-1, 2).T
        except (TypeError, ValueError):
            raise ValueError(f"psd: {points!r} is no list of pairs of Hz and g^2/Hz") from None
        if self.f.size < 2 or not (np.diff(self.f) > 0).all() or not self.f[0] > 0:
            raise ValueError("psd: give two frequencies or more, ascending and above 0")
        if not (np.isfinite(self.density) & (self.density > 0)).all():
            raise ValueError("psd: a density is no finite number above 0")

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
        """Root of its integral, multiples of g."""
        total = 0.0
        for f, S, ratio, slope in zip(
            self.f, self.density, self.f[1:] / self.f[:-1], self._slopes, strict=False
        ):
            power = slope + 1
            share = math.log(ratio) if abs(power) < 1e-9 else (ratio**power - 1) / power
            total += f * S * share
        return math.sqrt(total)

    @property
    def _slopes(self):
        """Of each stretch, on logarithmic scales."""
        ratios = zip(self.density[1:] / self.density[:-1], self.f[1:] / self.f[:-1], strict=True)
        return np.array([math.log(S) / math.log(f) for S, f in ratios])

    def record_length(self, duration: float) -> float:
        """Of one record of a vibration of so many s."""
        return min(duration, max(SECONDS, PERIODS / self.f[0]))

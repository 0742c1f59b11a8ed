"""Sums of wavelets, compiled."""

import numpy as np

from ...numerics.kernels import compiled, sine


@compiled
def wavelets(amplitude, f, begin, lasts, samples: int) -> np.ndarray:
    """Add wavelets, (samples,); f: turns per sample; begin, lasts: numbers of samples."""
    total = np.zeros(samples)
    for i in range(f.size):
        for k in range(int(begin[i]) + 1, min(samples, int(begin[i] + lasts[i]) + 1)):
            s = k - begin[i]
            total[k] += amplitude[i] * sine(s / (2 * lasts[i])) * sine(f[i] * s)
    return total

"""How uncertain the label of a point is: basin entropy and uncertainty exponent of a map."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.signal import fftconvolve
from scipy.special import entr
from scipy.stats import linregress


def basin_entropy(labels: np.ndarray, box: int) -> tuple[float, float]:
    """Entropy of a box's labels, mean over all boxes and over those with several labels.

    labels: integers, any number of axes; box: its side, cells; what is left over at the ends of the
        axes does not count
    Daza et al. (2016), as basin_entropy of Attractors.jl; the second is NaN without a boundary.
    """
    inside = _boxes(labels, box)
    shares = np.array([(inside == label).mean(axis=1) for label in np.unique(labels)])
    return _means(entr(shares).sum(axis=0))


def disk_entropy(labels: np.ndarray, radius: int) -> float:
    """Boundary entropy by disks about every cell that lies so far from the edges, radius: cells.

    Of a smooth boundary between two labels 0.4395093 on two axes, 0.5 on one, and up to 0.224 /
    radius more owing to cells; higher where it is fractal at that scale: Puy et al. (2021).
    """
    if min(labels.shape) < 2 * radius + 1:
        return np.nan
    offsets = np.indices([2 * radius + 1] * labels.ndim) - radius
    disk = ((offsets**2).sum(axis=0) <= radius**2).astype(float)
    counts = [
        np.round(fftconvolve(labels == label, disk, mode="valid")) for label in np.unique(labels)
    ]
    return _means(entr(np.array(counts) / disk.sum()).sum(axis=0))[1]


def uncertain_shares(labels: np.ndarray, sizes: Sequence[int]) -> np.ndarray:
    """Share of the windows of each size, cells, that have several labels; (sizes,).

    A window stands about every cell, and ends at the edges of the map.
    """
    ends = ((maximum_filter(labels, size), minimum_filter(labels, size)) for size in sizes)
    return np.array([(most != least).mean() for most, least in ends])


def uncertainty_exponent(sizes: Sequence[int], uncertain: np.ndarray) -> tuple[float, float]:
    """Exponent of Grebogi et al. (1983), and its standard error, from `uncertain_shares`.

    1 where the boundary is smooth, less where it is fractal; NaN from fewer than two shares.
    """
    # The outer cells of a window of two are one width apart.
    seen = uncertain > 0
    if seen.sum() < 2:
        return np.nan, np.nan
    line = linregress(np.log(np.asarray(sizes)[seen] - 1), np.log(uncertain[seen]))
    return line.slope, line.stderr


def _boxes(labels, side):
    """The labels of each box, (boxes, cells)."""
    whole = labels[tuple(slice(size - size % side) for size in labels.shape)]
    split = whole.reshape([part for size in whole.shape for part in (size // side, side)])
    order = [*range(0, split.ndim, 2), *range(1, split.ndim, 2)]
    return split.transpose(order).reshape(-1, side**labels.ndim)


def _means(entropy):
    mixed = entropy > 1e-12
    return float(entropy.mean()), float(entropy[mixed].mean()) if mixed.any() else np.nan

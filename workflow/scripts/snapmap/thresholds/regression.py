"""Thresholds of similar devices: those of the first samples predict those of the next ones."""

import numpy as np

from ..beam.limit_loads import static_threshold
from ..solver.bounds import least_amplitudes
from ..solver.settings import SECOND
from .effort import ISLAND_STEP, TOGETHER
from .probe import Probe, amplitudes, first_snap, near, refine, walk
from .search import ISLANDS_FROM, scan_upwards

FIRST_SAMPLES, GROWTH = 64, 8
"""Size of the first block of samples, and of each further block over all before it."""
SCANNED_SAMPLES = 16
"""Number of samples that are scanned, to see in which rows labels change back and forth."""
SCANNED_TO = 1.3
"""End of these scans, as a multiple of the sample's threshold."""
NOMINAL_REACH = 30.0
"""Factor on the nominal threshold, up and down, within which a sample's threshold is sought."""


def nominal_thresholds(probe: Probe, tolerance: float) -> np.ndarray:
    """Find the lowest N that snaps in each row, without a first guess, (rows,); NaN for none."""
    start = probe.settings.start
    bound = least_amplitudes(probe.model, probe.rows, start)
    static = static_threshold(probe.model.device, back=start == SECOND)
    rough, *_ = scan_upwards(probe, static, bound)
    N = amplitudes(ISLANDS_FROM * rough, rough, ISLAND_STEP)
    begins = probe.snaps(N)
    begins[:, 1:] &= ~begins[:, :-1]
    begins[:, 0] = False
    return refine(probe, *first_snap(N, begins), tolerance)[1]


def thresholds_of_samples(
    probe: Probe, deviations: np.ndarray, nominal: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps in each sample's rows, (samples, rows), and the ragged rows.

    probe: of the rows of all samples, raveled from (samples, rows)
    deviations: of scattered values from their nominal ones, (samples, values)
    nominal: thresholds of the nominal device, multiples of g, (rows,)
    A threshold is the upper end of a relative step of `tolerance`. It is NaN where nothing snaps,
    or all does, within NOMINAL_REACH of the nominal one, or where that is NaN. A row is ragged,
    (rows,), where labels of the first samples change more than once; all its samples are then
    scanned from below in steps of ISLAND_STEP.
    """
    N_first = np.full((len(deviations), nominal.size), np.nan)
    ragged, known = np.zeros(nominal.size, bool), np.isfinite(nominal)
    if not known.any():
        return N_first, ragged
    # All samples share one lattice, so that a threshold does not depend on its prediction.
    low, high = nominal[known].min() / NOMINAL_REACH, nominal[known].max() * NOMINAL_REACH
    size = 2 + int(np.log(high / low) / np.log1p(tolerance))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.r_[low, np.full(size - 1, 1 + tolerance)])
    lattice = np.append(N, np.nan)
    stride = max(1, round(np.log1p(ISLAND_STEP) / np.log1p(tolerance)))

    def snaps(numbers, places):
        """Tell whether rows, by number (n,), snap at places of the lattice; no beyond its end."""
        N = lattice[np.minimum(places, size)]
        return probe.take(numbers).snaps(N)

    def place(N, shape):
        """Find the first place of the lattice that is not below N."""
        return np.minimum(np.searchsorted(lattice, np.broadcast_to(N, shape)), size - 1)

    numbers = np.arange(N_first.size).reshape(N_first.shape)
    expected, above, done = nominal[np.newaxis], np.zeros(nominal.size, int), 0
    while done < len(N_first):
        block = slice(done, FIRST_SAMPLES if done == 0 else done * (1 + GROWTH))
        if done:
            expected, lowest = _expected(deviations[block], deviations[:done], N_first[:done])
        here = numbers[block]
        first = np.full(here.shape, size)
        clean, back = (np.broadcast_to(known & a, here.shape) for a in (~ragged, ragged))
        first[clean] = near(snaps, here[clean], place(expected, here.shape)[clean], size)
        if not done:
            few = slice(SCANNED_SAMPLES), known
            ragged[known], above[known] = _scan_samples(snaps, here[few], first[few], stride)
            back = np.broadcast_to(ragged, here.shape)
        low = place(expected * lowest, here.shape) if done else first - above
        first[back] = _from_below(snaps, here[back], low[back], size, stride)
        N_first[block] = np.where(first > 0, lattice[first], np.nan)
        done = block.stop
    return N_first, ragged


def _from_below(snaps, numbers, start, size, step):
    """Find the first places that snap in ragged rows, (rows,), from `start` up or from below it."""
    # All samples try multiples of the step, whatever was predicted.
    start = np.maximum(start - start % step, 0)
    first, left = np.empty_like(start), np.arange(start.size)
    while left.size:
        first[left] = walk(snaps, numbers[left], start[left], size, step)
        left = left[(first[left] == start[left]) & (start[left] > 0)]
        start[left] = np.maximum(start[left] - TOGETHER * step, 0)
    inside = np.flatnonzero((first > start) & (first < size))
    low, high = first[inside] - step, first[inside]
    first[inside] = near(snaps, numbers[inside], (low + high) // 2 + 1, size, (low, high))
    return first


def _scan_samples(snaps, numbers, first, stride):
    """Find ragged rows, and the largest distance from `first` down to the lowest place that snaps.

    numbers, first: numbers of rows, and a place that snaps, (samples, rows)
    Returns bools and places, (rows,).
    """
    steps = round(np.log(SCANNED_TO / ISLANDS_FROM) / np.log1p(ISLAND_STEP))
    start = np.maximum(first - round(-np.log(ISLANDS_FROM) / np.log1p(ISLAND_STEP)) * stride, 0)
    places = start[..., np.newaxis] + stride * np.arange(steps)
    snapped = snaps(numbers.ravel(), places.reshape(-1, steps)).reshape(places.shape)
    changes = np.count_nonzero(snapped[..., 1:] & ~snapped[..., :-1], axis=-1)
    lowest = start + stride * np.argmax(snapped, axis=-1)
    return (changes > 1).any(axis=0), (first - lowest).max(axis=0)


def _expected(new, known, N_first):
    """Predict thresholds of new samples, (new, rows), by least squares of their logarithms.

    new, known: deviations of new samples and of those with known thresholds, (samples, values)
    N_first: the known thresholds, (known, rows); where it is NaN, the mean of the row stands
    The terms are linear and, if there are enough samples, quadratic. Also returns the least ratio
    of a known threshold to its prediction, (rows,).
    """
    weight = np.isfinite(N_first)
    logs = np.log(np.where(weight, N_first, 1.0))
    mean = logs.sum(axis=0) / np.maximum(weight.sum(axis=0), 1)
    deviation = np.where(weight, logs - mean, 0.0)
    scale = np.abs(known).max(axis=0) + np.finfo(float).tiny
    i, j = np.triu_indices(scale.size)
    is_enough = len(known) >= 2 * (1 + scale.size + i.size)

    def terms(x):
        x = x / scale
        squares = [x[:, i] * x[:, j]] if is_enough else []
        return np.column_stack([np.ones(len(x)), x, *squares])

    fit = np.linalg.lstsq(terms(known), deviation)[0]
    residual = deviation - terms(known) @ fit
    return np.exp(mean + terms(new) @ fit), np.exp(residual.min(axis=0))

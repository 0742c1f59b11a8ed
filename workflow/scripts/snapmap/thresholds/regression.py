"""Thresholds of devices that are much alike: those known tell where to look for the next."""

import numpy as np

from ..beam.limit_loads import static_threshold
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import SECOND, Settings
from .search import SCAN_STEP, TOGETHER, amplitudes, asker, first_snap, near, refine, walk
from .survey import ISLAND_STEP, ISLANDS_FROM, first_seen, scan_range

FIRST_SAMPLES, GROWTH = 64, 8
"""So many samples tell where to look for as many times more of them, and so on."""
SCANNED_SAMPLES = 16
"""Samples whose labels are scanned, to see in which rows they change back and forth."""
SCANNED_TO = 1.3
"""Up to where they are scanned, as a multiple of their threshold."""
NOMINAL_REACH = 30.0
"""A sample's threshold is looked for within so many times the nominal one."""


def nominal_thresholds(
    model: Follows, rows: Rows, settings: Settings, tolerance: float
) -> np.ndarray:
    """Find the lowest N that snaps of rows of which nothing is known, (rows,); NaN for none."""
    ask = asker(model, rows, settings)
    start, bound = settings.start, least_amplitudes(model, rows, settings.start)
    static = static_threshold(model.device, back=start == SECOND)
    wide = amplitudes(*scan_range(model.device, static, rows, bound, start), SCAN_STEP)
    rough, _ = first_seen(ask, wide, bound)
    N = amplitudes(ISLANDS_FROM * rough, rough, ISLAND_STEP)
    begins = np.isfinite(ask(N))
    begins[:, 1:] &= ~begins[:, :-1]
    begins[:, 0] = False
    return refine(ask, *first_snap(N, begins), tolerance)[1]


def thresholds_of_samples(
    model: Follows,
    rows: Rows,
    deviations: np.ndarray,
    nominal: np.ndarray,
    settings: Settings,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps in each sample's rows, (samples, rows), and the ragged rows.

    rows: of all samples, raveled from (samples, rows); deviations: of what scatters from its
        nominal values, (samples, values); nominal: the nominal device's thresholds, (rows,)
    Thresholds are the upper end of a step of `tolerance`; NaN where nothing snaps, or all does,
    within NOMINAL_REACH of the nominal ones, or the row has no nominal one. A row is ragged,
    (rows,), where labels of the first samples change more than once; each of its samples is then
    scanned from below in steps of ISLAND_STEP.
    """
    N_first = np.full((len(deviations), nominal.size), np.nan)
    ragged, known = np.zeros(nominal.size, bool), np.isfinite(nominal)
    if not known.any():
        return N_first, ragged
    # Amplitudes in relative steps, the same for all samples. No others are tried: a threshold
    # between two of them does not depend on where it was expected.
    low, high = nominal[known].min() / NOMINAL_REACH, nominal[known].max() * NOMINAL_REACH
    size = 2 + int(np.log(high / low) / np.log1p(tolerance))
    # Products, not powers: the library's exponential rounds by the processor.
    N = np.multiply.accumulate(np.r_[low, np.full(size - 1, 1 + tolerance)])
    lattice, stride = (
        np.append(N, np.nan),
        max(1, round(np.log1p(ISLAND_STEP) / np.log1p(tolerance))),
    )

    def snaps(numbers, places):
        """Whether rows, by number (n,), snap at places of the lattice; False beyond its end."""
        N = lattice[np.minimum(places, size)]
        return np.isfinite(asker(model, rows.take(numbers), settings)(N))

    def place(N, shape):
        """The place of the first amplitude that is not below N."""
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
            ragged[known], above[known] = _look(snaps, here[few], first[few], stride)
            back = np.broadcast_to(ragged, here.shape)
        low = place(expected * lowest, here.shape) if done else first - above
        first[back] = _from_below(snaps, here[back], low[back], size, stride)
        N_first[block] = np.where(first > 0, lattice[first], np.nan)
        done = block.stop
    return N_first, ragged


def _from_below(snaps, numbers, start, size, step):
    """Find the first places that snap where labels change back and forth, (rows,)."""
    # The same places for every sample, wherever it was expected.
    start = np.maximum(start - start % step, 0)
    first, left = np.empty_like(start), np.arange(start.size)
    while left.size:
        first[left] = walk(snaps, numbers[left], start[left], size, step)
        left = left[(first[left] == start[left]) & (start[left] > 0)]
        start[left] = np.maximum(start[left] - TOGETHER * step, 0)
    inside = np.flatnonzero((first > start) & (first < size))
    low, high = first[inside] - step, first[inside]
    first[inside] = near(snaps, numbers[inside], (low + high) // 2 + 1, size, low, high)
    return first


def _look(snaps, numbers, first, stride):
    """Find rows in which labels change more than once, and how far below `first` they do at most.

    numbers, first: of samples, (samples, rows); both results (rows,), the latter in places
    """
    steps = round(np.log(SCANNED_TO / ISLANDS_FROM) / np.log1p(ISLAND_STEP))
    start = np.maximum(first - round(-np.log(ISLANDS_FROM) / np.log1p(ISLAND_STEP)) * stride, 0)
    places = start[..., np.newaxis] + stride * np.arange(steps)
    snapped = snaps(numbers.ravel(), places.reshape(-1, steps)).reshape(places.shape)
    changes = np.count_nonzero(snapped[..., 1:] & ~snapped[..., :-1], axis=-1)
    lowest = start + stride * np.argmax(snapped, axis=-1)
    return (changes > 1).any(axis=0), (first - lowest).max(axis=0)


def _expected(new, known, N_first):
    """Predict thresholds of new samples, (new, rows), and the least of known over these.

    new, known: deviations of samples, (..., values); N_first: thresholds of those known
    By least squares, of linear and, of enough samples, quadratic terms; where nothing snapped, the
    row's mean stands.
    """
    weight = np.isfinite(N_first)
    logs = np.log(np.where(weight, N_first, 1.0))
    mean = logs.sum(axis=0) / np.maximum(weight.sum(axis=0), 1)
    apart = np.where(weight, logs - mean, 0.0)
    scale = np.abs(known).max(axis=0) + np.finfo(float).tiny
    i, j = np.triu_indices(scale.size)
    is_enough = len(known) >= 2 * (1 + scale.size + i.size)

    def terms(x):
        x = x / scale
        squares = [x[:, i] * x[:, j]] if is_enough else []
        return np.column_stack([np.ones(len(x)), x, *squares])

    fit = np.linalg.lstsq(terms(known), apart)[0]
    left = apart - terms(known) @ fit
    return np.exp(mean + terms(new) @ fit), np.exp(left.min(axis=0))

"""Thresholds of devices that are much alike: those found tell where to look for the next."""

import numpy as np

from ..beam.equilibria import static_threshold
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.model import Follows
from ..solver.search import TOGETHER, asker, near, refine, scan, walk
from ..solver.settings import Settings
from ..thresholds.islands import BELOW, first_seen, wide_scan
from ..thresholds.transitions import FINE_STEP, Window

FIRST, GROWTH = 64, 8
"""So many samples tell where to look for as many times more of them, and so on."""
LOOKED_AT = 16
"""Samples whose labels are looked at closely, to see in which rows they change back and forth."""
ABOVE = 1.3
"""Up to where they are, as a multiple of their threshold."""
REACH = 30.0
"""A sample's threshold is looked for within so many times the nominal one."""


class Lattice:
    """Amplitudes in relative steps, the same for all samples.

    No others are tried: a threshold between two of them does not depend on where it was expected.
    """

    def __init__(self, low: float, high: float, step: float):
        """Set out amplitudes from low to high, multiples of g."""
        self.size = 2 + int(np.log(high / low) / np.log1p(step))
        # Products, not powers: the library's exponential rounds by the processor.
        N = np.multiply.accumulate(np.r_[low, np.full(self.size - 1, 1 + step)])
        self.N = np.append(N, np.nan)
        self.stride = max(1, round(np.log1p(FINE_STEP) / np.log1p(step)))

    def place(self, N: np.ndarray) -> np.ndarray:
        """The place of the first amplitude that is not below N."""
        return np.minimum(np.searchsorted(self.N, N), self.size - 1)

    def threshold(self, place: np.ndarray) -> np.ndarray:
        """N of the first place that snaps; NaN where that is the lattice's first, or beyond it."""
        return np.where(place > 0, self.N[place], np.nan)


def nominal_thresholds(
    model: Follows, rows: Rows, settings: Settings, tolerance: float
) -> np.ndarray:
    """Find the lowest N that snaps of rows of which nothing is known, (rows,); NaN for none."""
    ask = asker(model, rows, settings)
    static = static_threshold(model.device)
    wide = wide_scan(model.device, static, rows, settings.pulses)
    rough, _ = first_seen(ask, wide, least_amplitudes(model, rows, settings.pulses))
    N = Window(BELOW * rough, rough, np.full(rough.size, FINE_STEP)).N
    edges, *_ = scan(ask, N)
    row, *ends = (column[edges.rising] for column in edges[:3])
    row, lowest = np.unique(row, return_index=True)
    first = np.full((2, rough.size), np.nan)
    first[:, row] = [end[lowest] for end in ends]
    return refine(ask, *first, tolerance)[1]


def thresholds_of_samples(
    model: Follows,
    rows: Rows,
    deviations: np.ndarray,
    nominal: np.ndarray,
    settings: Settings,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps in each sample's rows, (samples, rows), and what is ragged.

    rows: of all samples, raveled from (samples, rows); deviations: of what scatters from its
        nominal values, (samples, values); nominal: the nominal device's thresholds, (rows,)
    Thresholds are the upper end of a step of `tolerance`; NaN where nothing snaps, or all does,
    within REACH of the nominal ones, or the row has no nominal one. A row is ragged, (rows,), where
    labels of the first samples change more than once; each of its samples is then scanned from
    below in steps of FINE_STEP.
    """
    found = np.full((len(deviations), nominal.size), np.nan)
    ragged, known = np.zeros(nominal.size, bool), np.isfinite(nominal)
    if not known.any():
        return found, ragged
    lattice = Lattice(nominal[known].min() / REACH, nominal[known].max() * REACH, tolerance)

    def snaps(numbers, places):
        """Whether rows, by number (n,), snap at places of the lattice; False beyond its end."""
        N = lattice.N[np.minimum(places, lattice.size)]
        return np.isfinite(asker(model, rows.some(numbers), settings)(N))

    numbers = np.arange(found.size).reshape(found.shape)
    expected, lowest, done = nominal[np.newaxis], np.full(nominal.size, BELOW), 0
    while done < len(found):
        block = slice(done, FIRST if done == 0 else done * (1 + GROWTH))
        if done:
            expected, lowest = _expected(deviations[block], deviations[:done], found[:done])
        here = numbers[block]
        first = np.full(here.shape, lattice.size)
        clean = np.broadcast_to(known & ~ragged, here.shape)
        guess = lattice.place(np.broadcast_to(expected, here.shape))
        first[clean] = near(snaps, here[clean], guess[clean], lattice.size)
        if not done:
            some = slice(LOOKED_AT), known
            ragged[known] = _are_ragged(snaps, here[some], first[some], lattice)
        low = np.minimum(lattice.place(np.broadcast_to(expected * lowest, here.shape)), first)
        back = np.broadcast_to(known & ragged, here.shape)
        first[back] = _from_below(snaps, here[back], low[back], lattice)
        found[block] = lattice.threshold(first)
        done = block.stop
    return found, ragged


def _from_below(snaps, numbers, start, lattice):
    """Places where the first of labels that change back and forth snaps, (rows,)."""
    # The same places for every sample, wherever it was expected.
    start, size, step = start - start % lattice.stride, lattice.size, lattice.stride
    first, left = np.empty_like(start), np.arange(start.size)
    while left.size:
        first[left] = walk(snaps, numbers[left], start[left], size, step)
        left = left[(first[left] == start[left]) & (start[left] > 0)]
        start[left] = np.maximum(start[left] - TOGETHER * step, 0)
    inside = np.flatnonzero((first > start) & (first < size))
    low, high = first[inside] - step, first[inside]
    first[inside] = near(snaps, numbers[inside], (low + high) // 2 + 1, size, low, high)
    return first


def _are_ragged(snaps, numbers, first, lattice):
    """In which rows the labels of some sample change more than once; (rows,)."""
    steps = round(np.log(ABOVE / BELOW) / np.log1p(FINE_STEP))
    start = np.maximum(first - round(-np.log(BELOW) / np.log1p(FINE_STEP)) * lattice.stride, 0)
    places = start.ravel()[:, np.newaxis] + lattice.stride * np.arange(steps)
    snapped = snaps(numbers.ravel(), places)
    changes = np.count_nonzero(snapped[:, 1:] & ~snapped[:, :-1], axis=1)
    return (changes.reshape(first.shape) > 1).any(axis=0)


def _expected(new, known, found):
    """Thresholds expected of new samples, (new, rows), and a share of them below all, (rows,).

    new, known: deviations of samples, (..., values); found: thresholds of those known
    By least squares; where nothing snapped, the row's mean stands.
    """
    with np.errstate(invalid="ignore"):
        logs = np.log(found)
    logs = np.where(np.isfinite(logs), logs, 0.0)
    weight = np.isfinite(found)
    mean = logs.sum(axis=0) / np.maximum(weight.sum(axis=0), 1)
    logs = np.where(weight, logs, mean)
    scale = np.abs(known).max(axis=0) + np.finfo(float).tiny
    terms = [_terms(some / scale, len(known)) for some in (known, new)]
    fit = np.linalg.lstsq(terms[0], logs - mean)[0]
    apart = logs - mean - terms[0] @ fit
    return np.exp(mean + terms[1] @ fit), np.exp(apart.min(axis=0)) / (1 + 2 * FINE_STEP)


def _terms(x, samples):
    """Constant, linear and, of enough samples, quadratic terms; (samples, terms)."""
    i, j = np.triu_indices(x.shape[1])
    terms = [np.ones((len(x), 1)), x]
    if samples >= 2 * (1 + x.shape[1] + i.size):
        terms.append(x[:, i] * x[:, j])
    return np.concatenate(terms, axis=1)

"""Thresholds of devices that differ in some values.

`Batch` holds similar devices under the same shocks. `thresholds_at` takes any devices, each under
its own shock, and gives error bars.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device.device import VALUES, Device, is_bistable
from ..device.device import batch as batch_of
from ..device.samples import SHOCK_FACTORS, nominal_value
from ..solver.adaptive import Adaptive, choose_model, choose_survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows, to_rows
from ..solver.models import Follows, follow_twice
from ..solver.motion import largest_stress
from ..solver.options import Chosen
from ..solver.outcome import LATCHED, label, side_at_end
from ..solver.settings import SECOND, Run
from ..study.shock import Shock
from ..study.study import ANY, Study
from .effort import ISLAND_STEP, TOGETHER
from .probe import Probe, amplitudes, first_snap, near, refine, walk
from .search import ISLANDS_FROM, Search, scan_upwards
from .survey import distance, tell_cost
from .verified import find_thresholds

FIRST_SAMPLES, GROWTH = 64, 8
"""Size of the first block of samples, and of each further block over all before it."""
SCANNED_SAMPLES = 16
"""Number of samples that are scanned, to see in which rows labels change back and forth."""
SCANNED_TO = 1.3
"""End of these scans, as a multiple of the sample's threshold."""
NOMINAL_REACH = 30.0
"""Factor on the nominal threshold, up and down, within which a sample's threshold is sought."""


def nominal_thresholds(probe: Probe, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest N that snaps in each row, without a first guess, (rows,); NaN for none.

    Returns also where snaps begin more than once in the scan below the first N found.
    """
    start = probe.settings.start
    static = static_threshold(probe.model.device, back=start == SECOND)
    rough, *_ = scan_upwards(probe, static, least_amplitudes(probe.model, probe.rows, start))
    N = amplitudes(ISLANDS_FROM * rough, rough, ISLAND_STEP)
    snaps = probe.snaps(N)
    begins = snaps & np.diff(snaps, prepend=snaps[:, :1])
    return refine(probe, *first_snap(N, begins), tolerance)[1], begins.sum(axis=1) > 1


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


MOST_ROWS = 0.9
"""Share of the rows in which a level must keep the tolerance of `auto`."""
LADDER = ("base", 4.0), ("check", 4.0), ("base", 2.0), ("check", 2.0), ("check", 1.0), ("top", 1.0)
"""Levels of `auto` with the factors on their time steps, from the cheapest run to the dearest."""


class Choice(NamedTuple):
    """The model that decides the thresholds of some rows.

    rows: mask of the rows, (rows,); step: factor on the model's time step
    name: of a level of `Adaptive`; empty if there is a single model
    """

    rows: np.ndarray
    name: str = ""
    step: float = 1.0

    def of(self, models: Follows | Adaptive) -> Follows:
        """Give the chosen model; models: as `choose_model` builds them."""
        level = getattr(models, self.name) if self.name else models
        return level.with_step(self.step)


class Batch:
    """Samples of a device, each with its own values and its own shocks.

    values: by name, (samples,); those of SHOCK_FACTORS are factors on the shocks' values
    bistable: whether a sample has a second shape, (samples,); size: number of those that have
    Methods take the rows of the nominal device; each sample has its own duration and C in them.
    """

    def __init__(
        self,
        device: Device,
        values: Mapping[str, np.ndarray],
        model: Mapping,
        choices: Sequence[Choice],
        start: str,
    ):
        """Take the values; choices: as `choose_levels` makes them, for the same model and start."""
        self.values, count = values, len(next(iter(values.values())))
        self._made = {key: column for key, column in values.items() if key in VALUES}
        self.bistable = is_bistable(device, self._made, count)
        self.size, self.choices = np.count_nonzero(self.bistable), choices
        self._model = model, start
        self.nominal = choose_model(batch_of([device]), *self._model)
        shares = {key: values.get(key, np.ones(count)) for key in SHOCK_FACTORS}
        self.factors = {key: column[self.bistable] for key, column in shares.items()}
        nominal = [nominal_value(device, key) for key in values]
        self.deviations = np.column_stack(list(values.values()))[self.bistable] - nominal

    @cached_property
    def models(self) -> Follows | Adaptive:
        """Build the model, or the levels, of all samples that have a second shape."""
        made = {key: column[self.bistable] for key, column in self._made.items()}
        devices = self.nominal.device.pick(np.zeros(self.size, int))
        return choose_model(devices.vary(made), *self._model)

    @property
    def model(self) -> Follows:
        """Give the model of the last choice, with its own time step."""
        return self.choices[-1]._replace(step=1.0).of(self.models)

    def thresholds(
        self, rows: Rows, settings: Run, tolerance: float, chosen: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Find thresholds of the samples, (samples, rows), and of the nominal device, (rows,).

        chosen: whether each row has its choice; else the last one decides, with its own time step
        Thresholds are multiples of g, NaN where nothing snaps. Also returns which rows are ragged.
        """
        every = np.ones(rows.f0.size, bool)
        N_first, nominal = np.full((self.bistable.size, every.size), np.nan), np.empty(every.size)
        ragged = np.zeros(every.size, bool)
        for choice in self.choices if chosen else [self.choices[-1]._replace(rows=every, step=1.0)]:
            which, part = choice.rows, rows.take(choice.rows)
            if not which.any():
                continue
            probe = Probe(choice.of(self.nominal), part, settings)
            nominal[which] = N = nominal_thresholds(probe, tolerance / 10)[0]
            if self.size:
                probe = Probe(choice.of(self.models), self._rows(part), settings)
                levels, ragged[which] = thresholds_of_samples(probe, self.deviations, N, tolerance)
                scaled = levels / self.factors["N"][:, np.newaxis]
                N_first[np.ix_(self.bistable, which)] = scaled
        return N_first, nominal, ragged

    def meets(self, required: Shock, rows: Rows, settings: Run) -> np.ndarray:
        """Tell whether each sample surely and possibly meets a requirement, (2, samples, rows).

        A sample that must trip is followed to the end in two steps, to see whether it stays: surely
        if it does in both, possibly if in one.
        """
        shape = self.bistable.size, rows.f0.size
        if required.snaps == ANY:
            return np.broadcast_to(self.bistable[:, np.newaxis], (2, *shape))
        snaps = np.zeros((2, *shape), bool)
        if self.size:
            levels = np.repeat(required.N * self.factors["N"], rows.f0.size)[:, np.newaxis]
            every = self._rows(rows)
            arrive = Probe(self.model, every, settings).snaps(levels)
            met = np.array([arrive, arrive])
            if required.snaps is True:
                finest = self.models.levels[-1]
                cells = every.cells(finest.device, levels, settings.horizon).take(arrive)
                stay = [
                    side_at_end(run, settings.energy_tolerance) == 2
                    for run in follow_twice(finest, cells, settings.but(until="end"))
                ]
                met[:, arrive] = np.all(stay, axis=0), np.any(stay, axis=0)
            snaps[:, self.bistable] = met.reshape(2, self.size, -1)
        return (snaps == bool(required.snaps)) & self.bistable[:, np.newaxis]

    def latched(self, N_first: np.ndarray, N: np.ndarray, rows: Rows, settings: Run) -> np.ndarray:
        """Count how many of the first samples latch, (rows, N).

        N_first: their thresholds, multiples of g, (samples, rows), below which none snaps
        """
        model = self.models
        first = N_first[self.bistable[: len(N_first)]]
        levels = np.repeat(self.factors["N"][: len(first)], rows.f0.size)[:, np.newaxis] * N
        every, above = self._rows(rows).take(slice(first.size)), first.reshape(-1, 1) <= N
        cells = every.cells(model.device, levels, settings.horizon).take(above)
        if isinstance(model, Adaptive):
            runs = model.follow_ends(cells, settings)
        else:
            runs = model.follow(cells, settings.but(until="end"))
        above[above] = label(runs, settings.energy_tolerance) == LATCHED
        return above.reshape(len(first), rows.f0.size, N.size).sum(axis=0)

    def stresses(self, study: Study, required: Shock, C: np.ndarray) -> np.ndarray:
        """Find the largest stress, MPa, in bistable samples under each of a requirement's shocks.

        Returns the largest of them, (samples, C).
        """
        part, pulses = required.shaken(study), required.shocks.pulses
        pulse = np.arange(len(pulses))[:, np.newaxis]
        rows = self._rows(to_rows(0, required.f0, C, pulse, pulses))
        N = np.repeat(required.N * self.factors["N"], rows.f0.size // self.size)[:, np.newaxis]
        cells = rows.cells(self.model.device, N, part.run.horizon).flat()
        stress = largest_stress(self.model.device, part.model, cells, part.run)
        return stress.reshape(self.size, len(pulses), len(C)).max(axis=1)

    def _rows(self, rows):
        """Repeat rows for all bistable samples, raveled from (samples, rows)."""
        duration, damping = (self.factors[key][:, np.newaxis] for key in ("duration", "C"))
        return rows._replace(
            device=np.repeat(np.arange(self.size), rows.f0.size),
            f0=np.ravel(rows.f0 / duration),
            C=np.ravel(rows.C * damping),
            pulse=np.tile(rows.pulse, self.size),
        )


def choose_levels(device: Device, model: Chosen, rows: Rows, settings: Run) -> list[Choice]:
    """Choose the models that decide the thresholds of rows.

    With `auto`, each row takes the first of LADDER that agrees, within the tolerance of `auto`,
    with the finest model on the threshold of the nominal device. The ladder ends when MOST_ROWS
    have a model; its last one takes all other rows, too.
    """
    left = np.ones(rows.f0.size, bool)
    if model.name != "auto":
        return [Choice(left)]
    auto = choose_model(batch_of([device]), model, settings.start)
    accepted = model.tolerance
    rough, _ = nominal_thresholds(Probe(auto.base.with_step(4.0), rows, settings), accepted)
    finest, same = (Probe(auto.top.with_step(step), rows, settings) for step in (0.5, 1.0))
    reach = distance(finest, rough, accepted)
    reach[np.isinf(reach)] = np.nan
    exact = refine(finest, rough - reach, rough + reach, accepted / 10)[1]
    clean = distance(same, exact, accepted) <= accepted * exact

    def within(share, level, which):
        """Tell whether rows of a level change their label within a share of the exact threshold."""
        N = np.multiply.outer(exact[which], [1 - share, 1 + share])
        below, above = Probe(level, rows.take(which), settings).snaps(N).T
        return ~below & above

    choices = []
    # ASSUME: what suffices for the nominal device suffices for those that scatter about it.
    for name, step in LADDER:
        level, good = getattr(auto, name), left & clean
        # Errors of model and time step may cancel by chance, but not at half the step, too.
        for share, factor in ((accepted, step), (2 * accepted, step / 2)):
            good[good] = within(share, level.with_step(factor), good)
        choices.append(Choice(good, name, step))
        left &= ~good
        if clean.any() and (clean & ~left).sum() >= MOST_ROWS * clean.sum():
            break
    choices[-1] = choices[-1]._replace(rows=good | left)
    return choices


def thresholds_at(
    study: Study, values: Mapping[str, np.ndarray], f0, C, pulse=0, axes: Sequence[np.ndarray] = ()
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find thresholds of a study's device with other values, multiples of g.

    values: by name, each (n,); f0 (Hz), C (uN us/um) and pulse (an index): numbers or (n,)
    axes: ascending; if values or C are those of a grid, raveled, few rows of it are searched
    Returns thresholds, their errors, and whether the device has a second shape, (n,).
    """
    size = np.broadcast(f0, C, *values.values()).size
    exists = is_bistable(study.device, values, size)
    thresholds = np.full((2, size), np.nan)
    if exists.any():
        places = np.arange(exists.sum())
        made = {key: column[exists] for key, column in values.items()}
        devices = batch_of([study.device]).pick(np.zeros_like(places)).vary(made)
        shock = (np.broadcast_to(a, size)[exists] for a in (f0, C, pulse))
        rows = to_rows(places, *shock, study.shocks.pulses)
        models = choose_survey(devices, study.model, study.start)
        search = Search(models, rows, study.run)
        numbers = np.full(size, -1)
        numbers[exists] = places
        parts = [(numbers.reshape(-1, *(x.size for x in axes)), axes)] if axes else []
        tell_cost(search)
        columns = find_thresholds(search, parts)
        thresholds[:, exists] = columns["N_first"], columns["N_error"]
    return *thresholds, exists

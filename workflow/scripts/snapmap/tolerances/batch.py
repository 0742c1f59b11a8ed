"""Devices that differ in some values: the table of them, and where they trip.

`Batch.thresholds` is for devices that are alike, under the same shocks; `thresholds_at` for any,
each under a shock of its own, with error bars.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..device import VALUES, Device, is_bistable
from ..device import batch as batch_of
from ..motion.envelopes import largest_stress
from ..solver.adaptive import TOLERANCE, choose_model, choose_survey
from ..solver.cells import Rows, to_rows
from ..solver.models import Follows, build_model
from ..solver.outcome import LATCHED, label
from ..solver.search import asker
from ..solver.settings import THRESHOLD_TOLERANCE, Settings
from ..study import Study, of_requirement
from ..thresholds.surface import look
from .regression import nominal_thresholds, thresholds_of_samples
from .samples import SHOCK_FACTORS, nominal_value

MOST_ROWS = 0.9
"""Share of the rows in which a level must keep the tolerance of `auto`."""
FOLLOWED, FEWEST = 256, 32
"""So many cells are followed for their stress, or those of at least so many samples."""


class Batch:
    """Samples of one device, each with its own values, and shocks that differ with them.

    values: by name, (samples,); those of SHOCK_FACTORS as shares of the shocks'
    bistable: which have a second shape; size: how many
    Rows are those of the nominal device; each sample's have its own duration and C.
    """

    def __init__(
        self,
        device: Device,
        values: Mapping[str, np.ndarray],
        build: Callable[[Device], Follows],
    ):
        """Make the devices; build: a model of a batch, as from `choose_builder`."""
        self.values, count = values, len(next(iter(values.values())))
        made = {key: column for key, column in values.items() if key in VALUES}
        self.bistable = is_bistable(device, made, count)
        self.nominal, self.model = build(batch_of([device])), None
        self.size = np.count_nonzero(self.bistable)
        if self.size:
            devices = self.nominal.device.pick(np.zeros(self.size, int))
            made = {key: column[self.bistable] for key, column in made.items()}
            self.model = build(devices.vary(made))
        shares = {key: values.get(key, np.ones(count)) for key in SHOCK_FACTORS}
        self.factors = {key: column[self.bistable] for key, column in shares.items()}
        nominal = [nominal_value(device, key) for key in values]
        self.deviations = np.column_stack(list(values.values()))[self.bistable] - nominal

    def thresholds(
        self, rows: Rows, settings: Settings, tolerance: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The lowest N that snaps, (samples, rows), the nominal device's, and what is ragged.

        NaN where a sample has none; the latter two: (rows,).
        """
        nominal = nominal_thresholds(self.nominal, rows, settings, tolerance / 10)
        N_first = np.full((self.bistable.size, nominal.size), np.nan)
        ragged = np.zeros(nominal.size, bool)
        if self.size:
            levels, ragged = thresholds_of_samples(
                self.model, self._rows(rows), self.deviations, nominal, settings, tolerance
            )
            N_first[self.bistable] = levels / self.factors["N"][:, np.newaxis]
        return N_first, nominal, ragged

    def meets(self, required: Mapping, rows: Rows, settings: Settings) -> np.ndarray:
        """Whether each sample meets a requirement, by its N and snaps; (samples, rows)."""
        snaps = np.zeros((self.bistable.size, rows.f0.size), bool)
        if self.size:
            levels = np.repeat(required["N"] * self.factors["N"], rows.f0.size)
            t_snap = asker(self.model, self._rows(rows), settings)(levels[:, np.newaxis])
            snaps[self.bistable] = np.isfinite(t_snap).reshape(self.size, -1)
        return (snaps == required["snaps"]) & self.bistable[:, np.newaxis]

    def latched(self, samples: int, N: np.ndarray, rows: Rows, settings: Settings) -> np.ndarray:
        """How many of the first samples are proven to stay in the second shape, (rows, N)."""
        count, own = np.zeros((rows.f0.size, N.size), np.int64), self._rows(rows)
        for i in range(np.count_nonzero(self.bistable[:samples])):
            mine = own.take(slice(i * len(count), (i + 1) * len(count)))
            levels = N * self.factors["N"][i]
            cells = mine.cells(self.model.device, levels, settings.horizon)
            seen = self.model.follow(cells, settings)
            count += label(*seen[:4], settings.energy_tolerance) == LATCHED
        return count

    def stresses(self, study: Study, requirements: Sequence[Mapping], C: np.ndarray) -> np.ndarray:
        """Largest stress in the first samples with a second shape, (requirements, samples, C), MPa.

        requirements: shocks, N and f0 (Hz) of each
        """
        size = min(self.size, max(FEWEST, FOLLOWED // (len(requirements) * len(C))))
        device, stress = self.model.device.pick(np.arange(size)), []
        N = np.repeat(self.factors["N"][:size], len(C))[:, np.newaxis]
        for required in requirements:
            own = of_requirement(study, required)
            rows = self._rows(to_rows(0, required["f0"], C, 0, required["shocks"].pulses))
            rows = rows.take(slice(N.size))
            cells = rows.cells(device, required["N"] * N, own.settings.horizon).flat()
            stress.append(largest_stress(own, device, cells).reshape(size, len(C)))
        return np.array(stress)

    def _rows(self, rows):
        """Those of all samples, raveled from (samples, rows)."""
        duration, damping = (self.factors[key][:, np.newaxis] for key in ("duration", "C"))
        return rows._replace(
            device=np.repeat(np.arange(self.size), rows.f0.size),
            f0=np.ravel(rows.f0 / duration),
            C=np.ravel(rows.C * damping),
            pulse=np.tile(rows.pulse, self.size),
        )


def choose_builder(
    device: Device, model: Mapping, rows: Rows, settings: Settings
) -> Callable[[Device], Follows]:
    """What builds the model of a batch, given by its name and options.

    Of `auto` it is the cheapest level whose thresholds of the nominal device in some rows are
    within its tolerance those of the next, in MOST_ROWS of them; where twice the steps move them,
    no level is told from another, and where they do so in all rows it is the finest.
    """
    if model["name"] != "auto":
        return lambda devices: build_model(devices, **model)
    auto = choose_model(batch_of([device]), model)
    accepted = model.get("tolerance", TOLERANCE)

    def thresholds(level):
        return nominal_thresholds(level, rows, settings, accepted / 10)

    # ASSUME: what suffices for the nominal device suffices for those that scatter about it.
    name, N_first = "base", thresholds(auto.base)
    for better in ("check", "top"):
        finer = getattr(auto, better)
        nearer, halved = thresholds(finer), thresholds(finer.with_step(0.5))
        clean = abs(halved / nearer - 1) < accepted
        near = abs(N_first / nearer - 1)[clean] < accepted
        if near.any() and near.mean() >= MOST_ROWS:
            break
        name, N_first = better, nearer
    return lambda devices: getattr(choose_model(devices, model), name)


def thresholds_at(
    study: Study, values: Mapping[str, np.ndarray], f0, C, pulse=0, axes: Sequence[np.ndarray] = ()
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Thresholds of a study's device with other values, each (n,), and their errors, or NaN.

    values: by name; f0: Hz; C: uN us/um; pulse: index in the study's, each a number or (n,)
    axes: ascending, of surfaces that the values are, raveled; of these few rows are searched
    Returns also where there is a device; (n,).
    """
    size = next(iter(values.values())).size
    there = is_bistable(study.device, values, size)
    first = np.full((2, size), np.nan)
    if there.any():
        places = np.arange(there.sum())
        made = {key: column[there] for key, column in values.items()}
        devices = batch_of([study.device]).pick(np.zeros_like(places)).vary(made)
        shock = (np.broadcast_to(a, size)[there] for a in (f0, C, pulse))
        rows = to_rows(places, *shock, study.shocks.pulses)
        models = choose_survey(devices, study.model, study.settings.start)
        numbers = np.full(size, -1)
        numbers[there] = places
        parts = [(numbers.reshape(-1, *(x.size for x in axes)), axes)] if axes else []
        seen = look(models, rows, parts, study.settings, THRESHOLD_TOLERANCE)
        first[:, there] = seen["N_first"], seen["N_error"]
    return *first, there

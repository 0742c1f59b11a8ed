"""A batch of devices as made: what is asked of it, and answered by running each of them."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ..device import FROM_ZERO, SIGNED, VALUES, Device, is_bistable
from ..device import batch as batch_of
from ..motion.history import extremes_of
from ..pulse import Pulse
from ..solver.adaptive import TOLERANCE, choose_model
from ..solver.cells import Rows, to_cells, to_rows
from ..solver.models import Follows, build_model
from ..solver.outcome import LATCHED, label
from ..solver.search import asker
from ..solver.settings import Settings
from ..study import Study
from .regression import nominal_thresholds, thresholds_of_samples
from .samples import SHOCK_FACTORS, Plan

MOST_ROWS = 0.9
"""Share of the rows in which a level must keep the tolerance of `auto`."""

FOLLOWED, FEWEST = 256, 32
"""So many cells are followed for their stress, each in half a second; or those of at least so many
samples."""


class Batch:
    """Samples of one device, each with its own values, and shocks that scatter as well.

    values: by name, (samples,); of SHOCK_FACTORS as such; bistable: which have a second shape
    """

    def __init__(
        self,
        device: Device,
        plan: Plan,
        points: np.ndarray,
        build: Callable[[Device], Follows],
    ):
        """Make the devices at points of a plan, (samples, draws); ValueError for what cannot be."""
        self.values = plan.values(points)
        self._check(plan)
        self.nominal = build(batch_of([device]))
        made = {key: values for key, values in self.values.items() if key in VALUES}
        self.bistable = is_bistable(device, made, len(points))
        made = {key: values[self.bistable] for key, values in made.items()}
        self.size = np.count_nonzero(self.bistable)
        self.model: Follows | None = None
        if self.size:
            devices = self.nominal.device.pick(np.zeros(self.size, int)).vary(made)
            self.model = build(devices)
        self.factors = {
            key: self.values[key][self.bistable] if key in self.values else np.ones(self.size)
            for key in SHOCK_FACTORS
        }
        nominal = np.array([plan.nominal[key] for key in self.values])
        self.deviations = np.column_stack(list(self.values.values()))[self.bistable] - nominal

    def thresholds(
        self,
        pulses: Sequence[Pulse],
        C: np.ndarray,
        f0: np.ndarray,
        settings: Settings,
        tolerance: float,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Find the lowest N that snaps, (samples, pulses, C, f0), and the nominal device's.

        The third result is which of these rows are ragged; NaN where a sample has none.
        """
        pulse, C, f0 = np.meshgrid(np.arange(len(pulses)), C, f0, indexing="ij")
        rows = to_rows(0, f0, C, pulse, pulses)
        nominal = nominal_thresholds(self.nominal, rows, settings, tolerance / 10)
        found, ragged = np.empty((0, f0.size)), np.zeros(f0.size, bool)
        if self.size:
            rows = to_rows(*self._of_samples(f0, C), pulse, pulses)
            found, ragged = thresholds_of_samples(
                self.model, rows, self.deviations, nominal, settings, tolerance
            )
            found /= self.factors["N"][:, np.newaxis]
        whole = np.full((self.bistable.size, *f0.shape), np.nan)
        whole[self.bistable] = found.reshape(-1, *f0.shape)
        return whole, nominal.reshape(f0.shape), ragged.reshape(f0.shape)

    def snapped(
        self, pulse: Pulse, N: float, C: np.ndarray, f0: float, settings: Settings
    ) -> np.ndarray:
        """Whether one shock snaps each sample, (samples, C)."""
        whole = np.zeros((self.bistable.size, len(C)), bool)
        if self.size:
            rows = to_rows(*self._of_samples(f0, np.asarray(C)), pulses=(pulse,))
            shock = np.repeat(N * self.factors["N"], len(C))
            seen = asker(self.model, rows, settings)(shock[:, np.newaxis])
            whole[self.bistable] = np.isfinite(seen).reshape(-1, len(C))
        return whole

    def latched(
        self,
        samples: int,
        pulses: Sequence[Pulse],
        N: np.ndarray,
        C: np.ndarray,
        f0: np.ndarray,
        settings: Settings,
    ) -> np.ndarray:
        """How many of the first samples are proven to stay in the second shape.

        Returns (pulses, C, f0, N).
        """
        pulse, C, f0, N = np.meshgrid(np.arange(len(pulses)), C, f0, N, indexing="ij", copy=False)
        count = np.zeros(N.shape, np.int64)
        for i in range(np.count_nonzero(self.bistable[:samples])):
            factors = {key: values[i] for key, values in self.factors.items()}
            shock = N * factors["N"], f0 / factors["duration"], C * factors["C"]
            cells = to_cells(self.model.device, i, *shock, settings.horizon, pulse, pulses)
            seen = self.model.follow(cells, settings)
            count += label(*seen[:4], settings.energy_tolerance) == LATCHED
        return count

    def stresses(self, study: Study, requirements: Sequence[Mapping], C: np.ndarray) -> np.ndarray:
        """Largest stress in the first samples that have a second shape.

        Returns (requirements, samples, C), MPa.
        """
        size = min(self.size, max(FEWEST, FOLLOWED // (len(requirements) * len(C))))
        stress = np.empty((len(requirements), size, len(C)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # how far the mass of each flies
            for place in product(*map(range, stress.shape)):
                asked, i, damping = requirements[place[0]], place[1], C[place[2]]
                pushed = replace(study, device=self.model.device.pick(i), shocks=asked["shocks"])
                factor = {key: values[i] for key, values in self.factors.items()}
                shock = asked["N"] * factor["N"], asked["f0"] / factor["duration"]
                stress[place] = extremes_of(pushed, *shock, damping * factor["C"]).stress_max
        return stress

    def _of_samples(self, f0, C):
        """Index, f0 and C of the cells of each sample, (samples, ...)."""
        index = np.arange(self.size).reshape(-1, *[1] * np.ndim(C))
        duration, damping = (self.factors[key].reshape(index.shape) for key in ("duration", "C"))
        return index, f0 / duration, C * damping

    def _check(self, plan):
        for key, values in self.values.items():
            least = 0.0 if key in FROM_ZERO else np.finfo(float).tiny
            if key in SIGNED:
                continue
            if (wrong := np.flatnonzero(~(values >= least))).size:
                raise ValueError(
                    f"tolerances.{key}: {values[wrong[0]]:.4g} is drawn and cannot be; write "
                    f"truncated or lognormal, or a smaller scatter about {plan.nominal[key]:g}"
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

    def find(level):
        return nominal_thresholds(level, rows, settings, accepted / 10)

    # ASSUME: what suffices for the nominal device suffices for those that scatter about it.
    name, found = "base", find(auto.base)
    for better in ("check", "top"):
        finer = getattr(auto, better)
        nearer, halved = find(finer), find(finer.with_step(0.5))
        clean = abs(halved / nearer - 1) < accepted
        near = abs(found / nearer - 1)[clean] < accepted
        if near.any() and near.mean() >= MOST_ROWS:
            break
        name, found = better, nearer
    return lambda devices: getattr(choose_model(devices, model), name)

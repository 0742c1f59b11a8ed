"""A model of one device or a batch of them, and the one thing asked of it: to follow cells."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..beam.basis import Basis
from ..beam.equilibria import Barrier
from ..beam.modal import ModalBeam
from ..device import Device
from ..io.counting import count
from .cells import Cells, Observations, no_observations
from .settings import MOVE, Settings
from .steps import Steps

BUNCH = 8192
"""Cells after which it is told how many are done; the last lanes of a call run half empty."""
HALVINGS = 4
"""How often a cell whose energy ledger does not close is followed again with half the step."""
SMALLEST = 2.0**-8
"""Over the longest step that motions take: a pulse that needs a shorter one is not followed."""


class Follows(Protocol):
    """What every model does, however many discretisations it holds."""

    @property
    def device(self) -> Device:
        """One, or a batch that the cells' indices refer to."""

    @property
    def levels(self) -> tuple["Follows", ...]:
        """Its discretisations by the `level` of its observations, the cheapest first."""

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow cells, (rows, n), each row of ascending amplitude, as the settings ask."""

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, "Model"]]:
        """Masks of devices, given by their indices, of any shape, and the model of each."""

    def with_step(self, factor: float) -> "Follows":
        """The same model with every step multiplied by `factor`."""

    def pick(self, which: int | np.ndarray) -> "Follows":
        """The same model of one device of the batch, or of some."""


@dataclass(frozen=True, eq=False)
class Model:
    """A device or a batch, its beam discretised.

    basis, modal: its matrices, and their reduced form
    barrier: between the two shapes of that form
    steps: the rule of its time steps
    """

    name: str
    device: Device
    basis: Basis
    modal: ModalBeam
    barrier: Barrier
    steps: Steps

    @property
    def levels(self) -> tuple["Model"]:
        """Itself alone."""
        return (self,)

    @property
    def modes(self) -> int:
        """Number of modes kept."""
        return self.modal.load.shape[-1]

    def loop(self) -> ModuleType:
        """Its time loop, imported when a run begins: a plan needs no compiler."""
        loop = "plain_loop" if self.name == "reference" else "simd_loop"
        return import_module(f".{loop}", __package__)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, "Model"]]:
        """Itself, for all."""
        return [(np.ones(device.shape, bool), self)]

    def with_step(self, factor: float) -> "Model":
        """The same model with its step multiplied by `factor`."""
        return replace(self, steps=self.steps.times(factor))

    def pick(self, which: int | np.ndarray) -> "Model":
        """The same model of one device of the batch, or of some."""
        if np.ndim(self.device.mass) == 0:
            return self
        parts: dict[str, Any] = {"device": self.device.pick(which), "steps": self.steps.pick(which)}
        for key in ("modal", "barrier"):
            whole = getattr(self, key)
            parts[key] = type(whole)(*(value[which] for value in whole))
        return replace(self, **parts)

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell as the settings ask; cells of any shape.

        Steps depend on the question. To learn where a cell stays, the kernel first follows it to
        the end of its pulse as if to learn whether it snaps; what then is proven never to snap is
        done. A cell whose ledger does not close is followed again with half the step, up to
        HALVINGS times; one whose pulse is too short to be followed has failed.
        """
        flat = cells.flat()
        seen, left = no_observations(flat.f0.shape), self._followed(flat, settings)
        if settings.until == "settled" and self.name != "reference":
            first = self.follow_once(flat.some(left), settings._replace(until="pulse"))
            seen.replace(left, first)
            believed = first.energy_error <= settings.energy_tolerance
            left = left[np.isnan(first.t_settled) | ~believed]
        for halvings in range(HALVINGS + 1):
            if not left.size:
                break
            model = self.with_step(0.5**halvings)
            seen.replace(left, model.follow_once(flat.some(left), settings))
            seen.halvings[left] = halvings
            left = left[~(seen.energy_error[left] <= settings.energy_tolerance)]
        return seen.shaped(np.shape(cells.f0))

    def _followed(self, cells, settings):
        """Indices of the cells whose pulse needs no step below SMALLEST."""
        longest = self.steps.longest[MOVE][cells.device]
        dt = self.steps.of(cells, settings.question)
        return np.flatnonzero(dt >= self.steps.factor * SMALLEST * longest)

    def follow_once(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell, (cells,), in steps of the rule, whatever its ledger then says."""
        seen = no_observations(cells.f0.shape)
        dt = self.steps.of(cells, settings.question)
        # Lanes run side by side: those of one call should take about as many steps.
        order = np.argsort(-cells.t_end / dt, kind="stable")

        def follow_share(first):
            share = order[first :: settings.threads]
            for some in np.split(share, range(BUNCH, share.size, BUNCH)):
                found = self.loop().march(self, cells.some(some), dt[some], settings)
                for whole, part in zip(seen[:6], found, strict=True):
                    whole[some] = part
                count(some.size)

        if settings.threads == 1:
            follow_share(0)
        else:
            with ThreadPoolExecutor(settings.threads) as pool:
                list(pool.map(follow_share, range(settings.threads)))
        seen.t_snap[seen.t_snap > cells.t_end] = np.nan
        seen.t_settled[seen.t_settled > cells.t_end] = np.nan
        seen.pulse_work[~(seen.energy_error <= settings.energy_tolerance)] = np.nan
        return seen


class GuidedOrFree(NamedTuple):
    """A batch in which beams are guided or free to tilt: models of all devices as either."""

    guided: Model
    free: Model

    @property
    def device(self) -> Device:
        """The batch."""
        return self.free.device

    @property
    def levels(self) -> tuple["GuidedOrFree"]:
        """Itself alone."""
        return (self,)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, Model]]:
        """Guided ones and free ones."""
        is_free = np.asarray(self.device.beam.free)[device] != 0
        return [(~is_free, self.guided), (is_free, self.free)]

    def with_step(self, factor: float) -> "GuidedOrFree":
        """The same models with every step multiplied by `factor`."""
        return GuidedOrFree(*(model.with_step(factor) for model in self))

    def pick(self, which: int | np.ndarray) -> Follows:
        """The model of one device, or those of several."""
        if np.ndim(which) == 0:
            return self[int(np.asarray(self.device.beam.free)[which])].pick(which)
        return GuidedOrFree(*(model.pick(which) for model in self))

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell by the model of its device."""
        seen = no_observations(np.shape(cells.f0))
        for mine, model in self.split(cells.device):
            seen.replace(mine, model.follow(cells.some(mine), settings))
        return seen

"""Models of a device or a batch, by name; and the one thing that they do: to follow cells."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from types import ModuleType
from typing import NamedTuple, Protocol

import numpy as np

from ..beam.basis import Basis
from ..beam.cosines import buckling_shapes, symmetric_cosines
from ..beam.elements import hermite_elements
from ..beam.equilibria import Barrier, Rest, find_barrier, require_rest, second_shape
from ..beam.modal import ModalBeam, contact_stiffness, pulse_load, reduce_to_modes
from ..device.device import Device, Value
from ..files.counting import count
from .cells import Cells, Observations, no_observations
from .laws import Laws, laws_of, well_of
from .options import take_model
from .settings import FIRST, MOVE, SECOND, Settings
from .steps import Steps, explicit_steps, largest_speed, steps_of

BUNCH = 8192
"""Cells after which it is reported how many are done; the last lanes of a call run half empty."""
HALVINGS = 4
"""How often a cell whose energy ledger does not close is followed again with half the step."""
SMALLEST = 2.0**-8
"""Over the longest step that motions take: a pulse that needs a shorter step is not followed."""


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
    laws: a user's own in place of some of its forces, of `reference` alone
    """

    name: str
    device: Device
    basis: Basis
    modal: ModalBeam
    barrier: Barrier
    steps: Steps
    laws: Laws | None = None

    @property
    def levels(self) -> tuple["Model"]:
        """Itself alone."""
        return (self,)

    @property
    def modes(self) -> int:
        """Number of modes kept."""
        return self.modal.load.shape[-1]

    @cached_property
    def second(self) -> Rest:
        """The second shape of its form; ValueError if one of the beams cannot rest there."""
        if self.laws and self.laws.force:
            raise ValueError("model.laws: force: runs start in the first shape; leave out start")
        rest = second_shape(self.device.beam, self.basis, self.modes)
        require_rest(rest)
        return rest

    def rest(self, start: str) -> np.ndarray:
        """The modes in the shape in which a run starts, (..., k), as `ModalBeam` has them."""
        return self.second.modes if start == SECOND else np.zeros(self.modal.load.shape)

    def snap_target(self, start: str) -> Value:
        """Where w(L/2), of a run from the second shape -w(L/2), snaps, from the first shape, um."""
        first = self.barrier.first
        return self.barrier.second - first if start == FIRST else 0.0 * first

    def time_steps(self, cells: Cells, settings: Settings) -> np.ndarray:
        """Step of each cell, us, in its shape; no mass rests on a beam in its second shape."""
        speed = largest_speed(self.device, cells) if settings.start == SECOND else 0.0
        return self.steps.of(cells, settings.question, speed)

    def loop(self) -> ModuleType:
        """Its time loop, imported when a run begins: a plan needs no compiler."""
        loop = "plain_loop" if self.name == "reference" else "simd_loop"
        loop = "external" if self.laws and self.laws.solver else loop
        return import_module(f".{loop}", __package__)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, "Model"]]:
        """Give this model for all."""
        return [(np.ones(device.shape, bool), self)]

    def with_step(self, factor: float) -> "Model":
        """The same model with its step multiplied by `factor`."""
        return replace(self, steps=self.steps.times(factor))

    def pick(self, which: int | np.ndarray) -> "Model":
        """The same model of one device of the batch, or of some."""
        if np.ndim(self.device.mass) == 0:
            return self
        modal = ModalBeam(*(np.asarray(column)[which] for column in self.modal))
        barrier = Barrier(*(np.asarray(column)[which] for column in self.barrier))
        device, steps = self.device.pick(which), self.steps.pick(which)
        return replace(self, device=device, modal=modal, barrier=barrier, steps=steps)

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell as the settings ask; cells of any shape.

        Steps depend on the question. To learn where a cell stays, the kernel first follows it to
        the end of its pulse as if to learn whether it snaps; what then is proven never to snap is
        done. A cell whose ledger does not close is followed again with half the step, up to
        HALVINGS times; one whose pulse is too short to be followed has failed.
        """
        flat = cells.flat()
        observed = no_observations(flat.f0.shape)
        longest = self.steps.factor * self.steps.longest[MOVE][flat.device]
        left = np.flatnonzero(self.time_steps(flat, settings) >= SMALLEST * longest)
        if settings.until == "settled" and self.name != "reference":
            first = self.follow_once(flat.take(left), settings._replace(until="pulse"))
            observed.replace(left, first)
            believed = first.energy_error <= settings.energy_tolerance
            left = left[np.isnan(first.t_settled) | ~believed]
        for halvings in range(HALVINGS + 1):
            if not left.size:
                break
            model = self.with_step(0.5**halvings) if halvings else self
            observed.replace(left, model.follow_once(flat.take(left), settings))
            observed.halvings[left] = halvings
            left = left[~(observed.energy_error[left] <= settings.energy_tolerance)]
        return observed.shaped(np.shape(cells.f0))

    def follow_once(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell, (cells,), in steps of the rule, whatever its ledger then says."""
        observed = no_observations(cells.f0.shape)
        dt = self.time_steps(cells, settings)
        # Lanes run side by side: all of a call should be full, and take about as many steps.
        order, loop = np.argsort(-cells.t_end / dt, kind="stable"), self.loop()
        threads = max(1, min(settings.threads, -(-order.size // loop.LANES)))

        def follow_share(first):
            share = order[first::threads]
            for at in np.split(share, range(BUNCH, share.size, BUNCH)):
                facts = loop.march(self, cells.take(at), dt[at], settings)
                for column, part in zip(observed[:7], facts, strict=True):
                    column[at] = part
                count(at.size)

        with ThreadPoolExecutor(threads) as pool:
            list((pool.map if threads > 1 else map)(follow_share, range(threads)))
        observed.t_snap[observed.t_snap > cells.t_end] = np.nan
        observed.t_settled[observed.t_settled > cells.t_end] = np.nan
        observed.pulse_work[~(observed.energy_error <= settings.energy_tolerance)] = np.nan
        return observed


def deciders(
    levels: Sequence[Follows], device: np.ndarray, decided: np.ndarray, which: np.ndarray
) -> Iterator[tuple[np.ndarray, Model]]:
    """Indices of cells, out of `which`, and the model that decided them, at its step.

    device: of all cells; decided: their level and halvings, (2, cells)
    """
    for number, halved in np.unique(decided[:, which], axis=1).T:
        alike = which[(decided[0, which] == number) & (decided[1, which] == halved)]
        for mine, part in levels[number].with_step(0.5**halved).split(device[alike]):
            yield alike[mine], part


class Mixed(NamedTuple):
    """A batch in which some devices take another model: both models are of all devices.

    other: which take the second, (devices,)
    """

    first: Follows
    second: Follows
    other: np.ndarray

    @property
    def device(self) -> Device:
        """The batch."""
        return self.first.device

    @property
    def levels(self) -> tuple["Mixed"]:
        """Itself alone."""
        return (self,)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, Model]]:
        """Give masks and models of the first, and of the second."""
        other = self.other[device]
        sides = (~other, self.first), (other, self.second)
        return [(mine & part, model) for mine, side in sides for part, model in side.split(device)]

    def with_step(self, factor: float) -> "Mixed":
        """The same models with every step multiplied by `factor`."""
        return Mixed(self.first.with_step(factor), self.second.with_step(factor), self.other)

    def pick(self, which: int | np.ndarray) -> Follows:
        """Give the model of one device, or those of several."""
        if np.ndim(which) == 0:
            return (self.second if self.other[which] else self.first).pick(which)
        return Mixed(self.first.pick(which), self.second.pick(which), self.other[which])

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow every cell by the model of its device."""
        observed = no_observations(np.shape(cells.f0))
        for mine, model in self.split(cells.device):
            observed.replace(mine, model.follow(cells.take(mine), settings))
        return observed


def mixed(build: Callable[[bool], Follows], other: np.ndarray | bool) -> Follows:
    """Build the models that the devices of a batch need, of those that are `other` and of the rest.

    build: makes either model for all devices; other: mask, (devices,), or a single bool
    """
    kinds = np.unique(other)
    if kinds.size == 1:
        return build(bool(kinds[0]))
    return Mixed(build(False), build(True), np.asarray(other))


def build_model(device: Device, name: str = "elements", **options) -> Follows:
    """Discretise the beams of a device or a batch; a ValueError names an option that cannot be.

    elements (of the half beam), cosines, modes (kept); of a beam that is free to tilt as many
        antisymmetric ones beside them
    """
    check_options(device, name, options)
    device.beam.require_second_shape()
    return mixed(partial(_build, device, name, options), np.not_equal(device.beam.free, 0))


def _build(device, name, options, is_free):
    """Build the model of devices as if all were guided, or free to tilt."""
    laws = laws_of(options)
    force = laws.force if laws else None
    if force:
        basis = symmetric_cosines(1)
    elif name == "cosines":
        basis_of = buckling_shapes if is_free else symmetric_cosines
        basis = basis_of(options.get("cosines", options.get("modes", 5)))
    else:
        basis = hermite_elements(options.get("elements", 5), bool(is_free))
    modes, most = options.get("modes"), basis.load.size // (1 + is_free)
    if modes is None:
        modes = basis.load.size if name == "cosines" else _modes_of_elements(device, basis, name)
    elif modes > most:
        raise ValueError(f"model.modes: {modes} is too many; write {most} or fewer")
    else:
        modes *= 1 + is_free  # as many antisymmetric ones as symmetric
    modal = reduce_to_modes(device.beam, basis, modes)
    modal = modal._replace(load=pulse_load(device, modal.load, modal.midpoint))
    if np.isinf(contact_stiffness(device, modal.residual)).any():
        raise ValueError(
            f"device.contact: hard needs a residual flexibility, and the {name} model leaves none "
            f"with {modes} of {basis.load.size} modes; write fewer modes, or a contact in N/m"
        )
    barrier = find_barrier(device.beam, basis, modes)
    if force:
        # ASSUME: a beam with a force of its own moves as its first cosine, which gives it its mass.
        saddle, second, energy = well_of(force, device.beam.rise)
        first, ones = barrier.first, 0.0 * barrier.first + 1.0
        modal = modal._replace(residual=0.0 * modal.residual)
        barrier = Barrier(energy * ones, -saddle * ones, first - second, first)
    steps = (explicit_steps if name == "reference" else steps_of)(device, modal)
    return Model(name, device, basis, modal, barrier, steps, laws)


def check_options(device: Device, name: str, options: Mapping) -> None:
    """Raise ValueError, one line, for a model or an option that cannot be."""
    take_model({"name": name, **options})
    if name == "reference" and np.isinf(device.contact).any():
        raise ValueError(
            "device.contact: hard excludes the reference model; write a stiffness such as 40 N/m, "
            "or the model elements"
        )
    if laws := laws_of(options):
        for key, refused in {
            "model.elements:": laws.force and "elements" in options,
            "device.stops:": laws.contact and device.has_stops,
            "device.contact_at:": device.has_electrode,
            "device.strength:": np.isfinite(device.strength),
            "device.mass: none": device.is_alone,
        }.items():
            if np.any(refused):
                raise ValueError(f"{key} does not work with these laws; leave it out")


def _modes_of_elements(device, basis, name):
    """Say how many modes elements keep where the options leave it open."""
    unknowns, hard = basis.load.size, np.isinf(device.contact)
    if not hard.any():
        return unknowns
    if not hard.all():
        raise ValueError(
            f"device.contact: the {name} model cannot mix hard and other contacts; write modes, or "
            "model: cosines"
        )
    # ASSUME: hard contact acts through the static flexibility of the highest quarter of the
    # elements' modes; it moves the threshold of five elements by 0.02 %.
    return max(1, min(unknowns - 1, (3 * unknowns + 3) // 4))

"""Models of a device or a batch, by name: each follows cells and returns observations."""

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from types import ModuleType
from typing import NamedTuple

import numpy as np

from ..beam.basis import Basis
from ..beam.cosines import buckling_shapes, symmetric_cosines
from ..beam.elements import hermite_elements
from ..beam.equilibria import Barrier, Rest, find_barrier, require_rest, second_shape
from ..beam.modal import ModalBeam, contact_stiffness, pulse_load, reduce_to_modes
from ..device.device import Device
from ..files.counting import count
from ..values.kinds import Number
from ..values.records import told
from .cells import Cells, Observations, no_observations
from .law_tables import Tables, tabulate, well_as_mode
from .laws import Laws, well_of
from .options import Chosen, Cosines, Elements, Reference
from .outcome import REPEATED_STEP
from .settings import CALM, FIRST, MOVE, SECOND, STAY, TO_THE_END, Run
from .steps import Steps, explicit_steps, steps_of, strikes

BUNCH = 8192
"""Cells of a call to a kernel, after which progress is reported; too few leave its lanes idle."""
HALVINGS = 4
"""Most halvings of the step for a cell whose energy ledger does not close."""
SMALLEST = 2.0**-8
"""Shortest step over the longest step of the question MOVE; a pulse that needs less has failed."""


@dataclass(frozen=True, eq=False)
class Model:
    """A device or a batch with a discretised beam.

    basis, modal: matrices of the beam, and their reduced form
    barrier: between the two shapes of the reduced form
    steps: rule of the time steps
    laws: of a user, in place of some forces; tables: of these, but for `reference`
    """

    name: str
    device: Device
    basis: Basis
    modal: ModalBeam
    barrier: Barrier
    steps: Steps
    laws: Laws | None = None
    tables: Tables | None = None

    @property
    def levels(self) -> tuple["Model"]:
        """This model alone."""
        return (self,)

    @property
    def modes(self) -> int:
        """Number of modes kept."""
        return self.modal.load.shape[-1]

    @cached_property
    def second(self) -> Rest:
        """The second shape of the reduced form; ValueError if a beam cannot rest there."""
        if self.laws and self.laws.force:
            raise ValueError("model.laws: force: runs start in the first shape; leave out start")
        rest = second_shape(self.device.beam, self.basis, self.modes)
        require_rest(rest)
        return rest

    def rest(self, start: str) -> np.ndarray:
        """Return the modes p of `ModalBeam` at which a run starts, (..., k)."""
        return self.second.modes if start == SECOND else np.zeros(self.modal.load.shape)

    def snap_target(self, start: str) -> Number:
        """Return w(L/2) of a snap, um from the first shape; -w(L/2) of a run from the second."""
        first = self.barrier.first
        return self.barrier.second - first if start == FIRST else 0.0 * first

    def time_steps(self, cells: Cells, settings: Run) -> np.ndarray:
        """Return the step of each cell, us, in the cells' shape."""
        struck = strikes(self.device, cells, settings.start)
        return self.steps.of(cells, settings.question, *struck)

    def steps_after_snap(self, cells: Cells, dt: np.ndarray, settings: Run) -> np.ndarray:
        """Return the steps of each cell once it has snapped, us: at first, and when it is calm.

        Neither is longer than the step up to the snap, dt. (2, cells)
        """
        if settings.until not in TO_THE_END:
            return np.array([dt, dt])
        struck = strikes(self.device, cells, settings.start)
        steps = [self.steps.of(cells, question, *struck) for question in (STAY, CALM)]
        return np.minimum(steps, dt)

    def loop(self) -> ModuleType:
        """Import the module of the time loop when a run begins, as a plan needs no compiler."""
        loop = "plain_loop" if self.name == "reference" else "simd_loop"
        return import_module(f".{loop}", __package__)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, "Model"]]:
        """Return this model, for all devices."""
        return [(np.ones(device.shape, bool), self)]

    def with_step(self, factor: float) -> "Model":
        """Return the same model with every step multiplied by `factor`."""
        return replace(self, steps=self.steps.times(factor))

    def pick(self, which: int | np.ndarray) -> "Model":
        """Return the same model of a device of the batch, or of several."""
        if np.ndim(self.device.mass) == 0:
            return self
        modal = ModalBeam(*(np.asarray(column)[which] for column in self.modal))
        barrier = Barrier(*(np.asarray(column)[which] for column in self.barrier))
        device, steps = self.device.pick(which), self.steps.pick(which)
        tables = self.tables and self.tables.pick(which)
        return replace(
            self, device=device, modal=modal, barrier=barrier, steps=steps, tables=tables
        )

    def follow(self, cells: Cells, settings: Run) -> Observations:
        """Follow cells of any shape.

        A cell whose ledger does not close is followed again with half the step, up to HALVINGS
        times. A cell whose pulse is too short for SMALLEST has failed.
        """
        flat = cells.flat()
        observed = no_observations(flat.f0.shape)
        longest = self.steps.factor * self.steps.longest[MOVE][flat.device]
        dt = self.time_steps(flat, settings)
        left = np.flatnonzero(dt >= SMALLEST * longest)
        for halvings in range(HALVINGS + 1):
            if not left.size:
                break
            model = self.with_step(math.ldexp(1.0, -halvings)) if halvings else self
            steps = None if halvings else dt[left]
            observed.replace(left, model.follow_once(flat.take(left), settings, steps))
            observed.halvings[left] = halvings
            left = left[~(observed.energy_error[left] <= settings.energy_tolerance)]
        return observed.shaped(np.shape(cells.f0))

    def follow_once(self, cells: Cells, settings: Run, dt: Number | None = None) -> Observations:
        """Follow every cell, (cells,), once, whatever its ledger says; dt: us, as `time_steps`."""
        observed = no_observations(cells.f0.shape)
        dt = self.time_steps(cells, settings) if dt is None else dt
        # Lanes run side by side: those of a call should all be full, and take about as many steps.
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


def follow_twice(model: "Follows", cells: Cells, settings: Run) -> list[Observations]:
    """Follow cells in the model's step, and again in the REPEATED_STEP."""
    return [model.with_step(step).follow(cells, settings) for step in (1.0, REPEATED_STEP)]


def deciders(
    levels: Sequence["Follows"], device: np.ndarray, decided: np.ndarray, which: np.ndarray
) -> Iterator[tuple[np.ndarray, Model]]:
    """Yield indices of cells, out of `which`, and the model that decided them, at its step.

    device: index of the device of each cell, (cells,); decided: level and halvings, (2, cells)
    """
    for number, halved in np.unique(decided[:, which], axis=1).T:
        alike = which[(decided[0, which] == number) & (decided[1, which] == halved)]
        for mine, part in levels[number].with_step(np.ldexp(1.0, -halved)).split(device[alike]):
            yield alike[mine], part


class Mixed(NamedTuple):
    """Two models, each of all devices of a batch, of which every device takes one.

    other: mask of the devices that take the second, (devices,)
    """

    first: "Follows"
    second: "Follows"
    other: np.ndarray

    @property
    def device(self) -> Device:
        """The batch, which both models share."""
        return self.first.device

    @property
    def levels(self) -> tuple["Mixed"]:
        """This model alone."""
        return (self,)

    def split(self, device: np.ndarray) -> list[tuple[np.ndarray, Model]]:
        """Return masks and models of the first, and of the second."""
        other = self.other[device]
        sides = (~other, self.first), (other, self.second)
        return [(mine & part, model) for mine, side in sides for part, model in side.split(device)]

    def with_step(self, factor: float) -> "Mixed":
        """Return the same models with every step multiplied by `factor`."""
        return Mixed(self.first.with_step(factor), self.second.with_step(factor), self.other)

    def pick(self, which: int | np.ndarray) -> "Follows":
        """Return the model of a device, or those of several."""
        if np.ndim(which) == 0:
            return (self.second if self.other[which] else self.first).pick(which)
        return Mixed(self.first.pick(which), self.second.pick(which), self.other[which])

    def follow(self, cells: Cells, settings: Run) -> Observations:
        """Follow every cell by the model of its device."""
        observed = no_observations(np.shape(cells.f0))
        for mine, model in self.split(cells.device):
            observed.replace(mine, model.follow(cells.take(mine), settings))
        return observed


Follows = Model | Mixed
"""What all models are: of one discretisation for all devices of a batch, or of several. In rows of
cells, (rows, n), the amplitude ascends."""


def mixed(build: Callable[[bool], Follows], other: np.ndarray | bool) -> Follows:
    """Build the models that the devices of a batch need, one for `other` devices, one for the rest.

    build: maps a value of `other` to its model of all devices; other: (devices,), or a single bool
    """
    kinds = np.unique(other)
    if kinds.size == 1:
        return build(bool(kinds[0]))
    return Mixed(build(False), build(True), np.asarray(other))


def build_model(device: Device, chosen: Cosines | Elements | Reference) -> Follows:
    """Discretise the beams of a device or a batch; raises ValueError, one line.

    A beam that is free to tilt has as many antisymmetric cosines and modes beside those chosen.
    """
    require_fitting(device, chosen)
    device.beam.require_second_shape()
    return mixed(partial(_build, device, chosen), np.not_equal(device.beam.free, 0))


def _build(device, chosen, is_free):
    """Build the model of devices as if all were guided, or all free to tilt."""
    name, laws, modes = chosen.name, chosen.laws, getattr(chosen, "modes", None)
    force = laws.force if laws else None
    if force:
        basis = symmetric_cosines(1)
    elif name == "cosines":
        basis_of = buckling_shapes if is_free else symmetric_cosines
        basis = basis_of(chosen.cosines or modes or 5)
    else:
        basis = hermite_elements(chosen.elements, bool(is_free))
    most = basis.load.size // (1 + is_free)
    if modes is None:
        modes = basis.load.size if name == "cosines" else _modes_of_elements(device, basis, name)
    elif modes > most:
        raise ValueError(f"model.modes: {modes} is too many; write {most} or fewer")
    else:
        modes *= 1 + is_free  # as many antisymmetric as symmetric
    modal = reduce_to_modes(device.beam, basis, modes)
    modal = modal._replace(load=pulse_load(device, modal.load, modal.midpoint))
    if np.isinf(contact_stiffness(device, modal.residual)).any():
        raise ValueError(
            f"device.contact: hard needs a residual flexibility, and the {name} model leaves none "
            f"with {modes} of {basis.load.size} modes; write fewer modes, or a contact in N/m"
        )
    barrier = find_barrier(device.beam, basis, modes)
    if force:
        # ASSUME: a beam whose force is a law moves as its first cosine, which gives its mass.
        saddle, second, energy = well_of(force, device.beam.rise)
        first, ones = barrier.first, 0.0 * barrier.first + 1.0
        modal = well_as_mode(modal._replace(residual=0.0 * modal.residual), force, second)
        barrier = Barrier(energy * ones, -saddle * ones, first - second, first)
    steps = (explicit_steps if name == "reference" else steps_of)(device, modal)
    if force:
        steps = steps.of_one_mode()
    tables = tabulate(laws, device, modal) if laws else None
    return Model(name, device, basis, modal, barrier, steps, laws, tables)


def require_fitting(device: Device, chosen: Chosen) -> None:
    """Raise ValueError, one line, for a model that a device excludes."""
    if chosen.name == "reference" and np.isinf(device.contact).any():
        raise ValueError(
            "device.contact: hard excludes the reference model; write a stiffness such as 40 N/m, "
            "or the model elements"
        )
    if laws := chosen.laws:
        sizes, law_meets_stops = {*told(chosen)} - {"laws", "name"}, laws.contact or laws.force
        for key, refused in {
            f"model.{min(sizes, default='')}:": laws.force and sizes,
            "device.contact: hard": (laws.contact or laws.force) and np.isinf(device.contact),
            "device.stop_toward:": law_meets_stops and np.isfinite(device.stop_toward),
            "device.stop_away:": law_meets_stops and np.isfinite(device.stop_away),
            "device.contact_at:": device.has_electrode,
            "device.strength:": np.isfinite(device.strength) & bool(laws.force),
            "device.mass: none": device.is_alone,
        }.items():
            if np.any(refused):
                raise ValueError(f"{key} does not work with these laws; leave it out")


def _modes_of_elements(device, basis, name):
    """Return the number of modes that elements keep by default."""
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

"""Models by name: which basis, how many modes and which step stand behind each."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from .bases.basis import Basis
from .bases.cosines import symmetric_cosines
from .bases.elements import hermite_elements
from .device import Device
from .modal import ModalBeam, contact_stiffness, reduce_to_modes, step_limit
from .protocol import check_number
from .wells import Barrier, find_barrier

ELEMENT_OPTIONS = ("elements", "mass_matrix", "step")
OPTIONS = {
    "reference": ELEMENT_OPTIONS,
    "handout": ELEMENT_OPTIONS,
    "elements": (*ELEMENT_OPTIONS, "modes"),
    "cosines": ("cosines", "modes", "step"),
    "auto": ("tolerance",),
}

RUNGS = (3, 5, 7, 10, 14, 18)
"""Cosines that `auto` chooses from; fewer than three save next to nothing and cost ten times."""


class Model(NamedTuple):
    """A device, its beam discretised.

    name: "reference" is marched by the plain loop, the others by the lane kernel
    basis, modal: its matrices, and their reduced form
    barrier: between the two shapes of that form
    dt: time step, us
    """

    name: str
    device: Device
    basis: Basis
    modal: ModalBeam
    barrier: Barrier
    dt: float

    def with_step(self, factor: float) -> "Model":
        """The same model with its step multiplied by `factor`."""
        return self._replace(dt=factor * self.dt)


def build_model(device: Device, name: str = "handout", **options) -> Model:
    """Discretise a device's beam; a ValueError names an option that cannot be, in one line.

    elements (of the half beam), mass_matrix ("consistent", "hrz"), cosines, modes (kept)
    step: fraction of the stability limit, above 0 and up to 1
    """
    check_options(device, name, options)
    basis = _basis(options, name)
    modes = options.get("modes", _default_modes(device, name, basis))
    if modes > basis.load.size:
        raise ValueError(f"model.modes: {modes} is too many; this beam has {basis.load.size}")
    modal = reduce_to_modes(device, basis, modes)
    if math.isinf(contact_stiffness(device, modal.residual)):
        raise ValueError(
            f"device.contact: hard needs a residual flexibility, and the {name} model leaves none "
            f"with {modes} of {basis.load.size} modes; write fewer modes, or a contact in N/m"
        )
    step = options.get("step", _default_step(device, basis, modes))
    return Model(name, device, basis, modal, find_barrier(modal), step * step_limit(device, modal))


def check_options(device: Device, name: str, options: Mapping) -> None:
    """Raise ValueError, one line, for a model or an option that cannot be."""
    if not isinstance(device, Device):
        raise ValueError(f"device: {device!r} is no device; `snapmap.load_device` reads one")
    if name not in OPTIONS:
        raise ValueError(f"model.name: {name!r} is unknown; known are {', '.join(OPTIONS)}")
    for key, value in options.items():
        if key not in OPTIONS[name]:
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: not an option of {name}; its options are {known}")
        if key != "mass_matrix":
            check_number(f"model.{key}", value)
        if key == "mass_matrix":
            if value not in ("consistent", "hrz"):
                raise ValueError(f"model.mass_matrix: {value!r} is not consistent or hrz")
        elif key == "step":
            if not 0 < value <= 1:
                raise ValueError(f"model.step: {value} is not above 0 and up to 1, the limit")
        elif key == "tolerance":
            if not 0 < value < 1:
                raise ValueError(f"model.tolerance: {value} is not between 0 and 1")
        elif value != int(value) or value < 1:
            raise ValueError(f"model.{key}: {value!r} is not a whole number from 1")
    if name == "reference" and math.isinf(device.contact):
        raise ValueError("device.contact: hard is not for the reference model; write handout")


def _basis(options, name):
    if name == "cosines":
        cosines = options.get("cosines", options.get("modes", 5))
        return symmetric_cosines(cosines)
    chosen = {key: options[key] for key in ("elements", "mass_matrix") if key in options}
    return hermite_elements(**chosen)


def _default_modes(device, name, basis):
    unknowns = basis.load.size
    if math.isinf(device.contact) and name != "cosines":
        # ASSUME: hard contact acts through the static flexibility of the highest quarter of the
        # elements' modes; it moves the threshold of five elements by 0.02 %.
        return max(1, min(unknowns - 1, (3 * unknowns + 3) // 4))
    return unknowns


def _default_step(device, basis, modes):
    # ASSUME: chosen by measurement, see docs/performance.md; few modes allow steps too long for a
    # short pulse. A cell whose energy ledger asks for less is followed again with less.
    if math.isinf(device.contact):
        return 0.3
    return 0.8 if basis.complete and modes == basis.load.size else 0.5

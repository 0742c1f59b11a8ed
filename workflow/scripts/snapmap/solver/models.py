"""Models by name: which basis, how many modes and which step stand behind each."""

from collections.abc import Mapping

import numpy as np

from ..arguments import require_model
from ..beam.cosines import buckling_shapes, symmetric_cosines
from ..beam.elements import hermite_elements
from ..beam.equilibria import find_barrier
from ..beam.modal import contact_stiffness, pulse_load, reduce_to_modes
from ..device import Device
from .model import Follows, GuidedOrFree, Model
from .steps import explicit_steps, steps_of


def build_model(device: Device, name: str = "handout", **options) -> Follows:
    """Discretise the beams of a device or a batch; a ValueError names an option that cannot be.

    elements (of the half beam), mass_matrix ("consistent", "hrz"), cosines, modes (kept); of a beam
        that is free to tilt as many antisymmetric ones beside them
    step: fraction of the limit of linear stability, above 0 and up to 1
    """
    check_options(device, name, options)
    device.beam.require_second_shape()
    free = np.unique(device.beam.free)
    models = [_build(device, name, options, sort != 0) for sort in free]
    return models[0] if free.size == 1 else GuidedOrFree(*models)


def _build(device, name, options, is_free):
    """The model of devices as if all were guided, or free to tilt."""
    basis = _basis(options, name, is_free)
    modes, most = options.get("modes"), basis.load.size // (1 + is_free)
    if modes is None:
        modes = basis.load.size if name == "cosines" else _modes_of_elements(device, basis, name)
    elif modes > most:
        raise ValueError(f"model.modes: {modes} is too many; this beam has {most}")
    else:
        modes *= 1 + is_free  # as many antisymmetric ones as symmetric
    modal = reduce_to_modes(device.beam, basis, modes)
    modal = modal._replace(load=pulse_load(device, modal.load, modal.midpoint))
    if np.isinf(contact_stiffness(device, modal.residual)).any():
        raise ValueError(
            f"device.contact: hard needs a residual flexibility, and the {name} model leaves none "
            f"with {modes} of {basis.load.size} modes; write fewer modes, or a contact in N/m"
        )
    barrier, step = find_barrier(device.beam, basis, modes), options.get("step")
    steps = (explicit_steps if name == "reference" else steps_of)(device, modal, step)
    return Model(name, device, basis, modal, barrier, steps)


def check_options(device: Device, name: str, options: Mapping) -> None:
    """Raise ValueError, one line, for a model or an option that cannot be."""
    require_model({"name": name, **options})
    if name == "reference" and np.isinf(device.contact).any():
        raise ValueError("device.contact: hard is not for the reference model; write handout")


def _basis(options, name, is_free):
    if name == "cosines":
        cosines = options.get("cosines", options.get("modes", 5))
        return buckling_shapes(cosines) if is_free else symmetric_cosines(cosines)
    chosen = {key: options[key] for key in ("elements", "mass_matrix") if key in options}
    return hermite_elements(**chosen, **{"free": True} if is_free else {})


def _modes_of_elements(device, basis, name):
    """How many modes elements keep, if the options leave it open."""
    unknowns, hard = basis.load.size, np.isinf(device.contact)
    if not hard.any():
        return unknowns
    if not hard.all():
        raise ValueError(
            f"device.contact: the {name} model takes hard ones and others each by themselves; "
            "write modes, or model: cosines"
        )
    # ASSUME: hard contact acts through the static flexibility of the highest quarter of the
    # elements' modes; it moves the threshold of five elements by 0.02 %.
    return max(1, min(unknowns - 1, (3 * unknowns + 3) // 4))

"""The two schemes of the SIMD kernel: which one a model takes, and its limit of stability."""

import numpy as np

from ..beam.modal import ModalBeam, contact_stiffness
from ..device import Device, Value
from ..numerics.linalg import dot, eigenvalues, outer, solve

EXPLICIT, CONSERVING = SCHEMES = ("explicit", "conserving")

# ASSUME: no run bends the beam further than this multiple of its start; see docs/stability.md.
TENSION_REACH = 1.25
SOFT_CONTACT = 0.2
"""Up to this product of the contact's frequency and the step, explicit impacts cost no repeats."""
# ASSUME: explicit steps are chosen by measurement, see docs/stability.md.
WHOLE, PART = 0.8, 0.5
"""Over the limit of stability, with all modes of a mesh and with some left out."""


def pays_explicit(device: Device, modal: ModalBeam, whole: bool) -> Value:
    """Whether the explicit scheme is the faster one; bool, of a batch (devices,).

    whole: whether all modes of a mesh of elements are kept, whose highest then set a step that
        resolves a soft contact anyway
    """
    if not whole:
        return np.zeros(np.shape(device.mass), bool)
    with np.errstate(divide="ignore"):
        compliance = dot(modal.midpoint, modal.midpoint) + np.divide(1, device.mass)
    frequency = np.sqrt(contact_stiffness(device, modal.residual) * compliance)
    return WHOLE * bending_limit(modal) * frequency <= SOFT_CONTACT


def stability_limit(device: Device, modal: ModalBeam, scheme: str) -> Value:
    """2/omega_max, us: of all that an explicit run meets, else of linear bending; docs/theory.md.

    The conserving scheme has no limit; there it is a measure by which `step` counts.
    """
    of_beam = bending_limit(modal) if scheme == CONSERVING else tangent_limit(device, modal)
    of_mass = 2 / device.mass_frequency
    return np.where(device.is_alone, of_beam, np.minimum(of_beam, of_mass))[()]


def default_step(device: Device, modal: ModalBeam, whole: bool) -> Value:
    """Time step of the explicit scheme, us, by default; whole: as in `pays_explicit`."""
    return (WHOLE if whole else PART) * stability_limit(device, modal, EXPLICIT)


def bending_limit(modal: ModalBeam) -> Value:
    """2/omega_max of linear bending, us, which neither contact nor tension shorten."""
    return 2 / np.sqrt(modal.stiffness[..., -1])


def tangent_limit(device: Device, modal: ModalBeam) -> Value:
    """2/omega_max, us, of the stiffest state that a run is expected to meet.

    The tangent stiffness kappa + T S + EA/L (S q)(S q)^T + contact, with q the start or its mirror
    image, TENSION_REACH times as far, and T the tension there.
    """
    slope, identity = TENSION_REACH * modal.slope_start, np.eye(modal.load.shape[-1])
    stretch = dot(modal.slope_start, solve(modal.geometric, modal.slope_start))
    tension = modal.axial * (TENSION_REACH * TENSION_REACH - 1) * stretch
    tangent = modal.stiffness[..., np.newaxis] * identity + _column(tension) * modal.geometric
    tangent += _column(2 * modal.axial) * outer(slope, slope)
    contact = contact_stiffness(device, modal.residual)
    tangent += _column(contact) * outer(modal.midpoint, modal.midpoint)
    return 2 / np.sqrt(eigenvalues(tangent)[..., -1])


def arch_frequency(modal: ModalBeam) -> Value:
    """About how fast the arch swings with its axial stiffness, 1/us: kappa_1 + EA/L |S q0|^2."""
    arch = 2 * modal.axial * dot(modal.slope_start, modal.slope_start)
    return np.sqrt(modal.stiffness[..., 0] + arch)


def _column(values):
    return np.asarray(values)[..., np.newaxis, np.newaxis]

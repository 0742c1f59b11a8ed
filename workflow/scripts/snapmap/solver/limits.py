"""How fast a beam swings at most, and the longest steps in which central differences are stable."""

import numpy as np

from ..beam.modal import ModalBeam, contact_stiffness
from ..device import Device, Value
from ..numerics.linalg import dot, eigenvalues, outer, solve

# ASSUME: no run bends the beam further than this multiple of its start; see docs/stability.md.
TENSION_REACH = 1.25


def bending_limit(device: Device, modal: ModalBeam) -> Value:
    """2/omega_max, us, of linear bending and of the mass on its spring.

    The kernel has no limit; there it is a measure by which `step` counts.
    """
    return _with_mass(device, 2 / np.sqrt(modal.stiffness[..., -1]))


def stability_limit(device: Device, modal: ModalBeam) -> Value:
    """2/omega_max, us, of the stiffest state that a run is expected to meet; docs/theory.md.

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
    return _with_mass(device, 2 / np.sqrt(eigenvalues(tangent)[..., -1]))


def arch_frequency(modal: ModalBeam) -> Value:
    """About how fast the arch swings with its axial stiffness, 1/us: kappa_1 + EA/L |S q0|^2."""
    arch = 2 * modal.axial * dot(modal.slope_start, modal.slope_start)
    return np.sqrt(modal.stiffness[..., 0] + arch)


def _with_mass(device, of_beam):
    of_mass = 2 / device.mass_frequency
    return np.where(device.is_alone, of_beam, np.minimum(of_beam, of_mass))[()]


def _column(values):
    return np.asarray(values)[..., np.newaxis, np.newaxis]

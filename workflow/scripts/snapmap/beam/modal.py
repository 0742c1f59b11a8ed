"""The small reduced form that every discretisation shares: the beam's own modes, a few of them."""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam, Device, Value
from ..numerics.linalg import apply, dot, eigh, multiply, solve
from .basis import Basis


class ModalBeam(NamedTuple):
    """Beam in k mass-normalised modes p of its bending, u = V p measured from the start w0.

    p'' = -stiffness p + N (geometric p + slope_start) - load a - midpoint P,
    N = -axial (p.geometric.p + 2 p.slope_start),  w(L/2) = rise + midpoint.p - residual P

    stiffness: (k,), 1/us^2
    geometric: (k, k), V^T G V, 1/(um ng)
    slope_start: (k,), V^T G q0, 1/ng^0.5
    load: (k,), ng^0.5
    midpoint: (k,), ng^-0.5
    axial: E A / (2 L), uN/um
    residual: static flexibility of the modes left out, um/uN; 0 when none is

    Of a batch of devices each has one more axis, in front.
    """

    stiffness: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Value
    residual: Value


def reduce_to_modes(beam: Beam, basis: Basis, modes: int | None = None) -> ModalBeam:
    """Give a beam its lowest `modes` modes; None keeps all that the basis has."""
    unit = unit_modes(basis, modes)
    root = np.sqrt(beam.weight)
    return ModalBeam(
        stiffness=np.multiply.outer(beam.stiffness_unit / beam.weight, unit.stiffness),
        geometric=unit.geometric / _column(beam.span * beam.weight, 2),
        slope_start=np.multiply.outer(beam.rise / (beam.span * root), unit.slope_start),
        load=np.multiply.outer(root, unit.load),
        midpoint=unit.midpoint / _column(root, 1),
        axial=beam.axial_stiffness,
        residual=unit.residual / beam.stiffness_unit,
    )


@cache
def unit_modes(basis: Basis, modes: int | None = None) -> ModalBeam:
    """Solve K v = kappa M v once for all beams: span, rise, rho A, EI and EA/2L are 1."""
    stiffness, shapes = eigh(basis.bending, basis.mass)
    shapes = shapes[:, :modes]
    slopes = multiply(shapes.T, basis.geometric)
    modal = ModalBeam(
        stiffness=stiffness[:modes],
        geometric=multiply(slopes, shapes),
        slope_start=apply(slopes, basis.start),
        load=apply(shapes.T, basis.load),
        midpoint=apply(shapes.T, basis.midpoint),
        axial=1.0,
        residual=0.0,
    )
    return modal._replace(residual=_residual_flexibility(basis, modal))


def contact_stiffness(device: Device, residual: Value) -> Value:
    """Contact force per overlap of mass and kept modes, 1 / (1/lambda + residual), uN/um.

    residual: static flexibility of the modes left out, um/uN; hard contact without it gives inf.
    """
    with np.errstate(divide="ignore"):
        return 1 / (1 / np.asarray(device.contact, float) + residual)


def _column(values, more):
    """Values with so many more axes at the end."""
    return np.reshape(values, (*np.shape(values), *[1] * more))


def _residual_flexibility(basis, modal):
    # ASSUME: the modes left out follow the contact force statically, softened by the axial force
    # half way between the start (0) and the saddle (4 N_1).
    if modal.stiffness.size == basis.load.size and basis.complete:
        return 0.0
    axial_force = 8 * math.pi * math.pi
    tangent = np.diag(modal.stiffness) - axial_force * modal.geometric
    kept = dot(modal.midpoint, solve(tangent, modal.midpoint))
    return max(0.0, basis.flexibility(axial_force) - float(kept))

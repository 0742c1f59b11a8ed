"""The small reduced form that every discretisation shares: the beam's own modes, a few of them."""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam, Device, Value
from ..numerics.linalg import apply, dot, eigh, multiply, solve
from .basis import Basis
from .prestress import Kinds, at_rest, kinds_of


class ModalBeam(NamedTuple):
    """Beam in k mass-normalised modes p of its bending, u = V p measured from its shape at rest.

    p'' = -stiffness p + N (geometric p + slope_start) - load a - midpoint P,
    N = -axial (p.geometric.p + 2 p.slope_start),  w(L/2) = height + midpoint.p - residual P

    stiffness: (k,), 1/us^2
    geometric: (k, k), V^T G V, 1/(um ng)
    slope_start: (k,), V^T G q0, 1/ng^0.5
    load: (k,), ng^0.5
    midpoint: (k,), ng^-0.5
    axial: E A / (2 L), uN/um
    residual: static flexibility of the modes left out, um/uN; 0 when none is
    shapes: (n, k), V over the basis's n shapes, ng^-0.5

    Of a batch of devices each has one more axis, in front.
    """

    stiffness: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Value
    residual: Value
    shapes: np.ndarray


def reduce_to_modes(beam: Beam, basis: Basis, modes: int | None = None) -> ModalBeam:
    """Give a beam its lowest `modes` modes; None keeps all that the basis has."""
    kinds, kind = kinds_of(beam)
    unit = unit_form(basis, modes, kinds)
    if not kinds.as_made:
        some = kind if np.ndim(beam.rise) else kind[0]
        unit = ModalBeam(*(np.asarray(column)[some] for column in unit))
    root = np.sqrt(beam.weight)
    return ModalBeam(
        stiffness=_column(beam.stiffness_unit / beam.weight, 1) * unit.stiffness,
        geometric=unit.geometric / _column(beam.span * beam.weight, 2),
        slope_start=_column(beam.made_rise / (beam.span * root), 1) * unit.slope_start,
        load=_column(root, 1) * unit.load,
        midpoint=unit.midpoint / _column(root, 1),
        axial=beam.axial_stiffness,
        residual=unit.residual / beam.stiffness_unit,
        shapes=unit.shapes / _column(root, 2),
    )


def unit_form(basis: Basis, modes: int | None, kinds: Kinds) -> ModalBeam:
    """The form of beams whose span, rise, rho A, EI and EA/2L are 1.

    One for all kinds as made; else each has its own, along an axis in front.
    """
    made = unit_modes(basis, modes)
    if kinds.as_made:
        return made
    T, q = at_rest(basis, kinds)
    stiffness, shapes = eigh(basis.bending + _column(T, 2) * basis.geometric, basis.mass)
    stiffness, shapes = stiffness[:, :modes], shapes[..., :modes]
    stressed = T != 0
    # What has no stress has the modes of all others that have none, to the last bit.
    stiffness[~stressed], shapes[~stressed] = made.stiffness, _unit_shapes(basis, modes)
    back = shapes.swapaxes(-1, -2)
    slopes = multiply(back, basis.geometric)
    found = ModalBeam(
        stiffness=stiffness,
        geometric=multiply(slopes, shapes),
        slope_start=apply(slopes, q),
        load=apply(back, basis.load),
        midpoint=apply(back, basis.midpoint),
        axial=np.ones(T.size),
        residual=np.zeros(T.size),
        shapes=shapes,
    )
    return found._replace(residual=_residual_flexibility(basis, found, T))


@cache
def unit_modes(basis: Basis, modes: int | None = None) -> ModalBeam:
    """The form of all beams as made: K v = kappa M v is solved once."""
    shapes = _unit_shapes(basis, modes)
    slopes = multiply(shapes.T, basis.geometric)
    modal = ModalBeam(
        stiffness=_unit_eigen(basis)[0][:modes],
        geometric=multiply(slopes, shapes),
        slope_start=apply(slopes, basis.start),
        load=apply(shapes.T, basis.load),
        midpoint=apply(shapes.T, basis.midpoint),
        axial=1.0,
        residual=0.0,
        shapes=shapes,
    )
    return modal._replace(residual=_residual_flexibility(basis, modal, 0.0))


@cache
def _unit_eigen(basis):
    return eigh(basis.bending, basis.mass)


def _unit_shapes(basis, modes):
    return _unit_eigen(basis)[1][:, :modes]


def pulse_load(device: Device, load: np.ndarray, midpoint: np.ndarray) -> np.ndarray:
    """The load of the device's pulse: of the frame, or of a force on the midpoint.

    load, midpoint: those of a form of the beam
    """
    if not np.any(device.force):
        return load
    # ASSUME: the modes left out do not yield to a force that is the pulse; it is far below theirs.
    share = _column(np.divide(device.force, device.gravity), np.ndim(load) - np.ndim(device.force))
    return np.where(share, share * midpoint, load)


def contact_stiffness(device: Device, residual: Value) -> Value:
    """Contact force per overlap of mass and kept modes, 1 / (1/lambda + residual), uN/um.

    residual: static flexibility of the modes left out, um/uN; hard contact without it gives inf.
    """
    with np.errstate(divide="ignore"):
        return 1 / (1 / np.asarray(device.contact, float) + residual)


def _column(values, more):
    """Values with so many more axes at the end."""
    return np.reshape(values, (*np.shape(values), *[1] * more))


def _residual_flexibility(basis, modal, tension):
    """Static flexibility of the modes left out; tension: of the beam at rest, in EI/L^2."""
    # ASSUME: the modes left out follow the contact force statically, softened by the axial force
    # half way between the beam at rest and the saddle (4 N_1).
    if modal.stiffness.shape[-1] == basis.load.size and basis.complete:
        return 0.0 * tension
    axial_force = 8 * math.pi * math.pi - tension / 2
    bending = modal.stiffness[..., np.newaxis] * np.eye(modal.stiffness.shape[-1])
    tangent = bending - _column(axial_force + tension, 2) * modal.geometric
    kept = dot(modal.midpoint, solve(tangent, modal.midpoint))
    return np.maximum(0.0, basis.flexibility(axial_force) - kept)

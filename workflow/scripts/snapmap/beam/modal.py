"""The beam at rest under residual stress, and its reduction to a few modes.

Residual stress changes the shape and the stiffness. Coordinates at rest and the tension T = -N are
those of the first shape in `device.arch`. For displacements from that shape the equations stay the
same, with bending + T geometric in place of bending.
"""

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from ..device.arch import equilibria
from ..device.device import Beam, Device
from ..numerics.linalg import apply, dot, eigh, multiply, outer, solve
from ..values.kinds import Number
from .basis import Basis
from .elements import hermite_elements

FIRST_LOAD = 4 * np.pi * np.pi
"""First buckling load N_1, in EI/L^2."""
ELEMENTS = 10
"""Elements of the half beam for its natural frequency, which they make 1e-4 too high."""


@dataclass(frozen=True, eq=False)
class UnitBeams:
    """The distinct beams of a batch, scaled such that span, rise, rho A and EI are 1.

    Q: rise over thickness, (beams,)
    compression: residual stress over that of buckling, compression positive, (beams,)
    imperfection: over the rise, (beams,)
    a: the a_n of the shapes as made, (beams, TERMS); None if all are cosines
    index: of each device's beam among these, (devices,); a number for a single device
    """

    basis: Basis
    Q: np.ndarray
    compression: np.ndarray
    imperfection: np.ndarray
    a: np.ndarray | None
    index: np.ndarray

    @property
    def are_as_made(self) -> bool:
        """Whether all are cosines without stress and imperfection, and so share one unit form."""
        return self.a is None and not (self.compression.any() or self.imperfection.any())

    @property
    def axial(self) -> np.ndarray:
        """EA/2L, in EI/L^3, (beams,)."""
        return 6 * self.Q * self.Q

    @cached_property
    def made(self) -> np.ndarray:
        """Coordinates of the shapes as made, in the rise, (beams, n)."""
        start = np.broadcast_to(self.basis.start, (self.Q.size, self.basis.start.size))
        if self.a is not None:
            cosine = (self.a[:, :1] == 1) & (self.a[:, 1:] == 0).all(axis=1, keepdims=True)
            start = np.where(cosine, start, self.basis.project(self.a))
        return start + self.imperfection[:, np.newaxis] * self.basis.tilt

    @cached_property
    def at_rest(self) -> tuple[np.ndarray, np.ndarray]:
        """Tension T, in EI/L^2, (beams,), and coordinates at rest, in the rise, (beams, n)."""
        stressed = self.compression != 0
        T, q = np.zeros(stressed.size), self.made.copy()
        if stressed.any():
            loads, shapes = buckling(self.basis)
            s = apply(shapes.T, apply(self.basis.geometric, self.made[stressed]))
            residual = FIRST_LOAD * self.compression[stressed]
            loads = np.broadcast_to(loads, s.shape)
            rest = equilibria(loads, s, self.axial[stressed], residual)
            T[stressed] = -rest.N_first
            q[stressed] += apply(shapes, s * (rest.first - 1))
        return T, q

    @property
    def midpoint(self) -> np.ndarray:
        """w(L/2) of the beams at rest, in the rise, (beams,)."""
        _, q = self.at_rest
        shares = apply(q, self.basis.midpoint)
        if self.a is not None:
            shares += 1 - apply(self.made, self.basis.midpoint)
        return np.where(self.compression == 0, 1.0, shares)

    def form(self, modes: int | None) -> "ModalBeam":
        """Reduce the beams to their lowest modes, None for all, in units in which EA/2L is 1 too.

        If `are_as_made`, all share one form; else each has its own, along a first axis.
        """
        basis, made = self.basis, unit_modes(self.basis, modes)
        if self.are_as_made:
            return made
        T, q = self.at_rest
        stiffness, shapes = eigh(basis.bending + column(T, 2) * basis.geometric, basis.mass)
        stiffness, shapes = stiffness[:, :modes], shapes[..., :modes]
        # All beams without stress have the same modes, to the last bit.
        stiffness[T == 0], shapes[T == 0] = made.stiffness, made.shapes
        return _form(basis, stiffness, shapes, q, T)


def unit_beams(basis: Basis, beam: Beam) -> UnitBeams:
    """Collect the distinct beams of a batch, or a single beam, on a basis."""
    columns = [beam.bistability, beam.compression, np.divide(beam.imperfection, beam.made_rise)]
    if not beam.is_cosine.all():
        columns += np.moveaxis(beam.cosines, -1, 0).tolist()
    table = np.stack(np.broadcast_arrays(*map(np.atleast_1d, columns)))
    (Q, compression, imperfection, *a), index = np.unique(table, axis=1, return_inverse=True)
    return UnitBeams(
        basis=basis,
        Q=Q,
        compression=compression,
        imperfection=imperfection,
        a=np.transpose(a) if a else None,
        index=index.ravel() if np.ndim(beam.rise) else index.ravel()[0],
    )


def first_midpoint(basis: Basis, beam: Beam) -> Number:
    """Return w(L/2) of a beam at rest in its first shape, um, a number or (devices,)."""
    beams = unit_beams(basis, beam)
    return beam.made_rise * beams.midpoint[beams.index]


def settled(basis: Basis, beam: Beam) -> Basis:
    """Return the basis of a single beam at rest: it starts there, and T is part of its bending."""
    beams = unit_beams(basis, beam)
    if beams.are_as_made:
        return basis
    (T,), (q,) = beams.at_rest
    bending = basis.bending + T * basis.geometric
    return replace(basis, bending=bending, start=q, tilt=0 * basis.tilt)


@cache
def buckling(basis: Basis) -> tuple[np.ndarray, np.ndarray]:
    """Return buckling loads N_j, in EI/L^2, ascending, and modes, columns v, v.geometric v = 1."""
    return eigh(basis.bending, basis.geometric)


class ModalBeam(NamedTuple):
    """A beam in k mass-normalised modes p of its bending; u = V p is measured from rest.

    p'' = -stiffness p + N (geometric p + slope_start) - load a - midpoint P,
    N = -axial (p.geometric.p + 2 p.slope_start),  w(L/2) = height + midpoint.p - residual P

    stiffness: (k,), 1/us^2
    geometric: (k, k), V^T G V, 1/(um ng)
    slope_start: (k,), V^T G q0, 1/ng^0.5
    load: (k,), ng^0.5
    midpoint: (k,), ng^-0.5
    axial: E A / (2 L), uN/um
    residual: static flexibility of the modes left out, um/uN; 0 if none is
    shapes: (n, k), V over the n shapes of the basis, ng^-0.5

    For a batch each has one more axis in front, (devices, ...).
    """

    stiffness: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Number
    residual: Number
    shapes: np.ndarray


def reduce_to_modes(beam: Beam, basis: Basis, modes: int | None = None) -> ModalBeam:
    """Reduce a beam, or a batch, to its lowest `modes` modes; None keeps all of the basis."""
    beams = unit_beams(basis, beam)
    unit = beams.form(modes)
    if not beams.are_as_made:
        unit = ModalBeam(*(np.asarray(part)[beams.index] for part in unit))
    root = np.sqrt(beam.weight)
    return ModalBeam(
        stiffness=column(beam.stiffness_unit / beam.weight, 1) * unit.stiffness,
        geometric=unit.geometric / column(beam.span * beam.weight, 2),
        slope_start=column(beam.made_rise / (beam.span * root), 1) * unit.slope_start,
        load=column(root, 1) * unit.load,
        midpoint=unit.midpoint / column(root, 1),
        axial=beam.axial_stiffness,
        residual=unit.residual / beam.stiffness_unit,
        shapes=unit.shapes / column(root, 2),
    )


@cache
def unit_modes(basis: Basis, modes: int | None = None) -> ModalBeam:
    """Solve K v = kappa M v, once for all beams that are as made; modes: None for all."""
    stiffness, shapes = eigh(basis.bending, basis.mass)
    return _form(basis, stiffness[:modes], shapes[:, :modes], basis.start, np.float64(0))


def _form(basis, stiffness, shapes, start, T):
    """Return the modal form of UnitBeams, with EA/2L = 1.

    start: coordinates at rest, in the rise, (..., n); T: tension at rest, in EI/L^2, (...)
    """
    back = shapes.swapaxes(-1, -2)
    slopes = multiply(back, basis.geometric)
    geometric, midpoint = multiply(slopes, shapes), apply(back, basis.midpoint)
    slope_start, load = apply(slopes, start), apply(back, basis.load)
    residual = 0.0 * T
    if not basis.complete or stiffness.shape[-1] < basis.load.size:
        tangent = stiffness[..., np.newaxis] * np.eye(stiffness.shape[-1])
        tangent = tangent - column(halfway(T) + T, 2) * geometric
        kept = dot(midpoint, solve(tangent, midpoint))
        residual = np.maximum(0.0, basis.flexibility(halfway(T)) - kept)
    axial = np.ones(np.shape(T))
    return ModalBeam(stiffness, geometric, slope_start, load, midpoint, axial, residual, shapes)


def pulse_load(device: Device, load: np.ndarray, midpoint: np.ndarray) -> np.ndarray:
    """Return the load of the device's pulse, which shakes the frame or pushes the midpoint.

    load, midpoint: those of a basis or a modal form of the beam, whose shape the result has
    """
    if not np.any(device.force):
        return load
    # ASSUME: a pulse that pushes is far slower than the modes left out, which do not yield to it.
    share = column(np.divide(device.force, device.gravity), np.ndim(load) - np.ndim(device.force))
    return np.where(share, share * midpoint, load)


def halfway(tension: np.ndarray) -> np.ndarray:
    """Return N half way from the beam at rest, under some tension, to the saddle, in EI/L^2."""
    # ASSUME: softened by this N, the modes left out follow the contact force statically.
    return 8 * math.pi * math.pi - tension / 2


def contact_stiffness(device: Device, residual: Number) -> Number:
    """Return contact force per overlap of mass and kept modes, 1 / (1/lambda + residual), uN/um.

    residual: static flexibility of the modes left out, um/uN; if 0, hard contact gives inf
    """
    with np.errstate(divide="ignore"):
        return 1 / (1 / np.asarray(device.contact, float) + residual)


def column(values: Number, more: int) -> np.ndarray:
    """Append `more` axes of length 1 to values."""
    return np.reshape(values, (*np.shape(values), *[1] * more))


def natural_frequency(beam: Beam) -> float:
    """Find the undamped frequency of the first symmetric mode of a single beam, rad/us.

    The stiffness of small vibrations is Kb + 2 EA/2L (G q0)(G q0)^T, as an arch cannot bend without
    stretch. An imperfection mixes this mode with the first antisymmetric one: of these two, which
    are the lowest, a shaken frame moves the wanted one more.
    """
    basis = settled(hermite_elements(ELEMENTS, free=True), beam)
    slope = apply(basis.geometric, basis.start)
    axial = 6 * beam.bistability * beam.bistability
    squares, shapes = eigh(basis.bending + 2 * axial * outer(slope, slope), basis.mass)
    first = np.argmax(np.abs(apply(shapes.T, basis.load)[:2]))
    return float(np.sqrt(squares[first] * (beam.stiffness_unit / beam.weight)))

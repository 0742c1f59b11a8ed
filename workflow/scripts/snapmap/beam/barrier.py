"""The barrier between the beam's two shapes."""

from functools import cache
from typing import NamedTuple

import numpy as np

from ..arch import equilibria
from ..device import Beam, Value
from ..numerics.linalg import apply, dot, eigh
from .basis import Basis
from .modal import unit_form, unit_modes
from .prestress import first_midpoint, kinds_of


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes; numbers, or arrays (devices,).

    energy: of the beam there, above its shape at rest, pJ
    midpoint: w(L/2) there, from that at rest, um
    second: w(L/2) in the second shape, um; of a beam that has none because it is free to tilt, that
        of a guided one
    first: w(L/2) in the shape at rest, um
    """

    energy: Value
    midpoint: Value
    second: Value
    first: Value


def find_barrier(beam: Beam, basis: Basis, modes: int | None = None) -> Barrier:
    """Find the lowest equilibrium that is no minimum: every way out of a well passes as high.

    Below its energy each well is closed, and w(L/2) on either side of its midpoint tells which
    well the beam is in: among all shapes with that midpoint none has less energy than the saddle.
    A model that has no stable second shape has a barrier of energy 0: one too coarse, close to
    Q = 4/sqrt(3), or a beam that is free to tilt out of it.
    """
    # With rise, span, rho A and EI as units few values tell one beam from another.
    kinds, kind = kinds_of(beam)
    modal = unit_form(basis, modes, kinds)._replace(axial=6 * kinds.Q * kinds.Q)
    stiffness = modal.stiffness[..., np.newaxis] * np.eye(modal.stiffness.shape[-1])
    loads, shapes = eigh(stiffness, modal.geometric)
    s = apply(shapes.swapaxes(-1, -2), modal.slope_start)
    loads, s = (np.broadcast_to(part, (kinds.Q.size, part.shape[-1])) for part in (loads, s))
    rest = equilibria(loads, s, modal.axial, np.zeros(kinds.Q.size))
    saddle, own = (apply(shapes, q - s) for q in (rest.saddle, s * rest.second))
    exists = np.isfinite(saddle).all(axis=-1)
    unit = beam.stiffness_unit * beam.made_rise * beam.made_rise
    first = first_midpoint(basis, beam)
    energy, along = _energy(modal, saddle), dot(modal.midpoint, saddle)
    energy, along = (np.where(exists, part, 0.0)[kind] for part in (energy, along))
    second = np.atleast_1d(beam.second_equilibrium)
    if basis.tilt.any():
        stays = first + dot(modal.midpoint, own)[kind] * beam.made_rise
        second = np.where(exists[kind], stays, second)
    found = energy * unit, along * beam.made_rise, second, first
    return Barrier(*(value if np.ndim(beam.rise) else value.item() for value in found))


@cache
def unit_buckling(basis: Basis, modes: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, in EI/L^2, and modes v_j, the columns, with v.S v = 1."""
    modal = unit_modes(basis, modes)
    return eigh(np.diag(modal.stiffness), modal.geometric)


def _energy(modal, p):
    slope = apply(modal.geometric, p) + modal.slope_start
    axial_force = -modal.axial * dot(p, slope + modal.slope_start)
    return dot(p, modal.stiffness * p) / 2 + axial_force * axial_force / (4 * modal.axial)

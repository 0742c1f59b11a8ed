"""The beam at rest: what residual stress makes of the shape as made, and of its stiffness.

Its coordinates in buckling modes and its tension T = -N are those of the first shape in `arch`;
measured from there the beam has the same form with bending + T geometric for its bending.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from ..arch import equilibria
from ..device import Beam
from ..numerics.linalg import apply, eigh
from .basis import Basis

FIRST_LOAD = 4 * np.pi * np.pi
"""N_1, in EI/L^2."""


class Kinds(NamedTuple):
    """What tells one beam's unit form from another's; arrays (kinds,).

    Q: rise over thickness; compression: residual stress over that of buckling, compression
    positive; imperfection: over the rise; a: of the shapes as made, (kinds, TERMS), None if all
    are cosines
    """

    Q: np.ndarray
    compression: np.ndarray
    imperfection: np.ndarray
    a: np.ndarray | None = None

    @property
    def as_made(self) -> bool:
        """Whether all are cosines without stress and imperfection: one unit form serves them."""
        return self.a is None and not (self.compression.any() or self.imperfection.any())

    def made(self, basis: Basis) -> np.ndarray:
        """Coordinates of the shapes as made, in the rise, (kinds, n)."""
        start = np.broadcast_to(basis.start, (self.Q.size, basis.start.size))
        if self.a is not None:
            cosine = (self.a[:, :1] == 1) & (self.a[:, 1:] == 0).all(axis=1, keepdims=True)
            start = np.where(cosine, start, basis.project(self.a))
        return start + self.imperfection[:, np.newaxis] * basis.tilt


def kinds_of(beam: Beam) -> tuple[Kinds, np.ndarray]:
    """The kinds among a batch of beams, or of one, and the kind of each."""
    columns = [beam.bistability, beam.compression, np.divide(beam.imperfection, beam.made_rise)]
    if not beam.is_cosine.all():
        columns += np.moveaxis(beam.cosines, -1, 0).tolist()
    table = np.stack(np.broadcast_arrays(*map(np.atleast_1d, columns)))
    found, kind = np.unique(table, axis=1, return_inverse=True)
    a = found[3:].T if len(found) > 3 else None
    return Kinds(found[0], found[1], found[2], a), kind.ravel()


def at_rest(basis: Basis, kinds: Kinds) -> tuple[np.ndarray, np.ndarray]:
    """Tension T, in EI/L^2, (kinds,), and coordinates, in the rise, (kinds, n), of the beams."""
    as_made = kinds.made(basis)
    stressed = kinds.compression != 0
    T, q = np.zeros(stressed.size), as_made.copy()
    if stressed.any():
        loads, shapes = buckling(basis)
        s = apply(shapes.T, apply(basis.geometric, as_made[stressed]))
        axial = 6 * kinds.Q[stressed] * kinds.Q[stressed]
        residual = FIRST_LOAD * kinds.compression[stressed]
        rest = equilibria(np.broadcast_to(loads, s.shape), s, axial, residual)
        T[stressed] = -rest.N_first
        q[stressed] += apply(shapes, s * (rest.first - 1))
    return T, q


def first_midpoint(basis: Basis, beam: Beam) -> np.ndarray:
    """w(L/2) of beams at rest in their first shape, um; (beams,)."""
    kinds, kind = kinds_of(beam)
    _, q = at_rest(basis, kinds)
    shares = apply(q, basis.midpoint)
    if kinds.a is not None:
        shares += 1 - apply(kinds.made(basis), basis.midpoint)
    return beam.made_rise * np.where(kinds.compression == 0, 1.0, shares)[kind]


def settled(basis: Basis, beam: Beam) -> Basis:
    """The basis of one beam whose start is its shape at rest, and whose bending holds T."""
    kinds, _ = kinds_of(beam)
    if kinds.as_made:
        return basis
    (T,), (q,) = at_rest(basis, kinds)
    bending = basis.bending + T * basis.geometric
    return replace(basis, bending=bending, start=q, tilt=0 * basis.tilt)


@cache
def buckling(basis: Basis) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, in EI/L^2, and modes v_j, the columns, v.geometric v = 1."""
    return eigh(basis.bending, basis.geometric)

"""The beam at rest: what residual stress makes of the shape as made, and of its stiffness.

In buckling modes v_j (bending v_j = N_j geometric v_j, v_j.geometric v_j = 1), with s_j = v_j.
geometric q0 of the shape as made, a beam under the tension T is at rest where each coordinate is
s_j N_j / (N_j + T). The stretch that this takes must add up to T itself,

    T = T0 + EA/2L sum s_j^2 ((N_j / (N_j + T))^2 - 1),

T0 the residual stress times A; the right side falls with T, so there is one root above -N_1.
Measured from there the beam has the same form with bending + T geometric for its bending.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam
from ..numerics.linalg import apply, eigh
from .basis import Basis

NEWTON_STEPS = 200
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
        T[stressed] = _tension(loads, s, axial, -FIRST_LOAD * kinds.compression[stressed])
        change = loads / (loads + T[stressed, np.newaxis]) - 1
        q[stressed] += apply(shapes, s * change)
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


def _tension(loads, s, axial, residual):
    """The root T, (n,), by Newton's method from below, where the convex side is above T."""
    square, axial = s * s, axial[:, np.newaxis]
    whole = np.sum(axial * square, axis=1) + abs(residual) + loads[0]
    first = axial[:, 0] * square[:, 0]
    T = loads[0] / np.sqrt(1 + whole / first) - loads[0]
    for _ in range(NEWTON_STEPS):
        share = loads / (loads + T[:, np.newaxis])
        over = residual - T + np.sum(axial * square * (share * share - 1), axis=1)
        slope = 1 + 2 * np.sum(axial * square * share * share * share / loads, axis=1)
        nearer = T + over / slope
        if not (nearer > T).any():
            break
        T = np.maximum(nearer, T)
    return T

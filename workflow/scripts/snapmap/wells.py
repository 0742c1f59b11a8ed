"""The barrier between the beam's two shapes, in a reduced model's own terms."""

from typing import NamedTuple

import numpy as np

from .linalg import apply, dot, eigh, is_positive, solve
from .modal import ModalBeam

NEWTON_STEPS = 10
"""More than it takes from guesses as good as these."""


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes.

    energy: of the beam there, above the start, pJ
    midpoint: w(L/2) - rise there, um
    """

    energy: float
    midpoint: float


def find_barrier(modal: ModalBeam) -> Barrier:
    """Find the lowest equilibrium that is no minimum: every way out of a well passes as high.

    Below its energy each well is closed, and w(L/2) on either side of its midpoint tells which
    well the beam is in: among all shapes with that midpoint none has less energy than the saddle.
    A model too coarse to have a second shape, close to Q = 4/sqrt(3), has a barrier of energy 0.
    """
    equilibria = _polish(modal, _equilibria(modal))
    passes = equilibria[~is_positive(_hessian(modal, equilibria))]
    if not len(passes):
        return Barrier(0.0, 0.0)
    energies = _energy(modal, passes)
    lowest = np.argmin(energies)
    return Barrier(float(energies[lowest]), float(dot(modal.midpoint, passes[lowest])))


def _equilibria(modal):
    """Guesses at all equilibria but the start, (n, k), by the buckling modes kappa v = N_j S v.

    In these, p = sum c_j v_j, equilibrium reads c_j = N s_j / (N_j - N), s_j = v_j.S q0: either
    N is a buckling load N_k and c_k is free, or N is a root of the stretch equation alone. The
    start is a multiple of the first mode, but for a small remainder that `_polish` adds.
    """
    loads, shapes = buckling(modal)
    starts = apply(shapes.T, modal.slope_start)
    first, start = loads[0], starts[0]
    along = first * start / (first - loads[1:])
    free = start * start - along * along - loads[1:] / modal.axial
    some = free > 0
    bent = np.sqrt(free[some])[:, np.newaxis] * shapes.T[1:][some]
    # N = axial (s^2 - q^2), q = first s / (first - N): a cubic in q, of which q = s is a root; the
    # others solve q^2 + s q + first/axial = 0.
    root = start * start - 4 * first / modal.axial
    straight = np.array([-1.0, 1.0]) * np.sqrt(root) - start if root >= 0 else np.empty(0)
    along = np.concatenate([along[some], straight / 2]) - start
    return along[:, np.newaxis] * shapes[:, 0] + np.pad(bent, ((0, straight.size), (0, 0)))


def buckling(modal: ModalBeam) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, uN, and modes v_j, the columns, with v.S v = 1."""
    return eigh(np.diag(modal.stiffness), modal.geometric)


def _stretch(modal, p):
    """S p + S q0 and the axial force N."""
    slope = apply(modal.geometric, p) + modal.slope_start
    return slope, -modal.axial * dot(p, slope + modal.slope_start)


def _energy(modal, p):
    _, axial_force = _stretch(modal, p)
    return dot(p, modal.stiffness * p) / 2 + axial_force * axial_force / (4 * modal.axial)


def _hessian(modal, p):
    slope, axial_force = _stretch(modal, p)
    tangent = np.diag(modal.stiffness) - axial_force[..., np.newaxis, np.newaxis] * modal.geometric
    return tangent + 2 * modal.axial * slope[..., :, np.newaxis] * slope[..., np.newaxis, :]


def _polish(modal, p):
    for _ in range(NEWTON_STEPS):
        slope, axial_force = _stretch(modal, p)
        force = modal.stiffness * p - axial_force[..., np.newaxis] * slope
        p = p - solve(_hessian(modal, p), force)
    return p

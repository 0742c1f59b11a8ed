"""Energies of a lane, their ledger, and what they prove; all times dt^2."""

import numpy as np

from ...numerics.kept_kernels import inlined
from . import rows as R


@inlined
def half_step_midpoint(V, modes, l):
    """e.p at the last half step."""
    w = 0.0
    for i in range(modes):
        d, p = V[R.D, i, l], V[R.P, i, l]
        w += V[R.E, i, l] * (p - d / 2)
    return w


@inlined
def energies(X, V, modes, l):
    """What `advance` conserves, of the beam, the mass and the contact; and w.

    At the last half step: products of two instants stand for squares.
    """
    beam = X[R.AXIAL, l] * X[R.Q, l] ** 2 / 4
    for i in range(modes):
        d, p = V[R.D, i, l], V[R.P, i, l]
        beam += d * d / 2 + V[R.KAPPA, i, l] * p * (p - d) / 2
    d, y = X[R.DY, l], X[R.Y, l]
    middle = y - d / 2
    mass = X[R.M, l] * d * d / 2 + X[R.K, l] * middle * middle / 2
    contact = X[R.CONTACT, l] * max(0.0, X[R.OVERLAP, l]) ** 2 / 2
    return beam, mass, contact, half_step_midpoint(V, modes, l)


@inlined
def ledger(X, V, modes, l, drag):
    """What `energies` returns, and energy + losses - work of the pulse.

    Up to the last half step; drag: C dt.
    """
    beam, mass, contact, w = energies(X, V, modes, l)
    swept = drag * X[R.SWEPT, l] + X[R.ALPHA, l] * X[R.BEAM_SWEPT, l]
    energy = beam + mass + contact + X[R.LOST, l]
    return beam, mass, contact, w, energy + swept / 4 - X[R.WORK, l] / 2


@inlined
def proven_well(X, l, kept, margin):
    """The well (1 or 2) that the beam can never leave without a shock, or 0 if that is open.

    Energy only falls after the pulse. 1 or 2: all of it is below the barrier. 2: the beam's alone
    is, and the mass on its spring cannot swing as low as the beam can rise, the saddle.
    """
    beam, mass, contact, w = kept
    barrier, saddle = X[R.BARRIER, l], X[R.SADDLE, l]
    if beam + mass + contact + margin < barrier:
        return 1 if w > saddle else 2
    lowest_mass = -np.sqrt(2 * (mass + margin) / X[R.K, l])
    if beam + margin < barrier and w < saddle < lowest_mass + X[R.Z0, l]:
        return 2
    return 0

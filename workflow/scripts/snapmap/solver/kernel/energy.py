"""Energies of a lane, their ledger, and what they prove; all times dt^2."""

import numpy as np

from ...numerics.kept_kernels import inlined
from . import rows as R
from .rows import at, row


@inlined
def half_step_midpoint(X, shape, l):
    """e.p at the last half step."""
    modes, w = len(shape), 0.0
    for i in range(modes):
        d, p = X[at(R.P_STEP, i, modes, l)], X[at(R.P, i, modes, l)]
        w += X[at(R.MIDPOINT, i, modes, l)] * (p - d / 2)
    return w


@inlined
def energies(X, shape, l):
    """What `advance` conserves, of the beam, the mass and the contact; and w.

    At the last half step: products of two instants stand for squares.
    """
    modes, beam = len(shape), X[row(R.AXIAL, l)] * X[row(R.STRETCH, l)] ** 2 / 4
    for i in range(modes):
        d, p = X[at(R.P_STEP, i, modes, l)], X[at(R.P, i, modes, l)]
        beam += d * d / 2 + X[at(R.STIFFNESS, i, modes, l)] * p * (p - d) / 2
    d, y = X[row(R.Y_STEP, l)], X[row(R.Y, l)]
    middle = y - d / 2
    mass = X[row(R.MASS, l)] * d * d / 2 + X[row(R.SPRING, l)] * middle * middle / 2
    contact = X[row(R.CONTACT, l)] * max(0.0, X[row(R.OVERLAP, l)]) ** 2 / 2
    return beam, mass, contact, half_step_midpoint(X, shape, l)


@inlined
def ledger(X, shape, l, drag):
    """What `energies` returns, and energy + losses - work of the pulse.

    Up to the last half step; drag: C dt.
    """
    beam, mass, contact, w = energies(X, shape, l)
    swept = drag * X[row(R.SWEPT, l)] + X[row(R.BEAM_DAMPING, l)] * X[row(R.BEAM_SWEPT, l)]
    energy = beam + mass + contact + X[row(R.LOST, l)]
    return beam, mass, contact, w, energy + swept / 4 - X[row(R.WORK, l)] / 2


@inlined
def proven_well(X, l, kept, margin):
    """The well (1 or 2) that the beam can never leave without a shock, or 0 if that is open.

    Energy only falls after the pulse. 1 or 2: all of it is below the barrier. 2: the beam's alone
    is, and the mass on its spring cannot swing as low as the beam can rise, the saddle.
    """
    beam, mass, contact, w = kept
    barrier, saddle = X[row(R.BARRIER, l)], X[row(R.SADDLE, l)]
    if beam + mass + contact + margin < barrier:
        return 1 if w > saddle else 2
    lowest_mass = -np.sqrt(2 * (mass + margin) / X[row(R.SPRING, l)])
    if beam + margin < barrier and w < saddle < lowest_mass + X[row(R.GAP, l)]:
        return 2
    return 0

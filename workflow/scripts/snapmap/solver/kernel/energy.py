"""Energies of a lane, the ledger of each scheme, and what energy proves; all times dt^2."""

import numpy as np

from ...numerics.kept_kernels import inlined
from . import rows as R
from .rows import at, row


@inlined
def whole_step_energies(before, after, X, shape, l):
    """Energy of the beam, of the mass on its spring, and of the contact; and w.

    At the instant of the state `before`, one step ahead of `after`, so that velocities are centred.
    """
    modes = len(shape)
    quadratic, beam, w = 0.0, 0.0, 0.0
    for i in range(modes):
        p = before[at(R.P, i, modes, l)]
        slope = 2 * X[at(R.SLOPE_START, i, modes, l)]
        for j in range(modes):
            slope += X[at(R.GEOMETRIC + i, j, modes, l)] * before[at(R.P, j, modes, l)]
        quadratic += p * slope
        w += X[at(R.MIDPOINT, i, modes, l)] * p
        velocity = (before[at(R.P_STEP, i, modes, l)] + after[at(R.P_STEP, i, modes, l)]) / 2
        beam += velocity**2 / 2 + X[at(R.STIFFNESS, i, modes, l)] * p**2 / 2
    beam += X[row(R.AXIAL, l)] * quadratic**2 / 4
    y = before[row(R.Y, l)]
    velocity = (before[row(R.Y_STEP, l)] + after[row(R.Y_STEP, l)]) / 2
    mass = X[row(R.MASS, l)] * velocity**2 / 2 + X[row(R.SPRING, l)] * y**2 / 2
    overlap = max(0.0, w - y - X[row(R.GAP, l)])
    contact = X[row(R.CONTACT, l)] * overlap**2 / 2
    return beam, mass, contact, w


@inlined
def whole_step_stretch(X, shape, l):
    """The stretch u.G u + 2 u.G q0 at the instant, and the overlap of mass and beam."""
    modes, quadratic = len(shape), 0.0
    overlap = 0.0 - X[row(R.Y, l)] - X[row(R.GAP, l)]
    for i in range(modes):
        p = X[at(R.P, i, modes, l)]
        slope = 2 * X[at(R.SLOPE_START, i, modes, l)]
        for j in range(modes):
            slope += X[at(R.GEOMETRIC + i, j, modes, l)] * X[at(R.P, j, modes, l)]
        quadratic += p * slope
        overlap += X[at(R.MIDPOINT, i, modes, l)] * p
    return quadratic, overlap


@inlined
def whole_step_ledger(before, after, X, shape, l, drag):
    """What `whole_step_energies` returns, and energy + losses - work of the pulse.

    By the trapezoidal rule; drag: C dt.
    """
    beam, mass, contact, w = whole_step_energies(before, after, X, shape, l)
    work = (before[row(R.WORK, l)] + after[row(R.WORK, l)]) / 4
    lost = before[row(R.LOST, l)] + drag * (before[row(R.SWEPT, l)] + after[row(R.SWEPT, l)]) / 8
    beam_swept = before[row(R.BEAM_SWEPT, l)] + after[row(R.BEAM_SWEPT, l)]
    kept = beam + mass + contact + lost + X[row(R.BEAM_DAMPING, l)] * beam_swept / 8
    return beam, mass, contact, w, kept - work


@inlined
def half_step_midpoint(X, shape, l):
    """e.p at the last half step."""
    modes, w = len(shape), 0.0
    for i in range(modes):
        d, p = X[at(R.P_STEP, i, modes, l)], X[at(R.P, i, modes, l)]
        w += X[at(R.MIDPOINT, i, modes, l)] * (p - d / 2)
    return w


@inlined
def conserved_energies(X, shape, l):
    """What `advance_conserving` conserves, of the beam, the mass and the contact; and w.

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
def conserved_ledger(X, shape, l, drag):
    """What `conserved_energies` returns, and energy + losses - work of the pulse.

    Up to the last half step; drag: C dt.
    """
    beam, mass, contact, w = conserved_energies(X, shape, l)
    swept = drag * X[row(R.SWEPT, l)] + X[row(R.BEAM_DAMPING, l)] * X[row(R.BEAM_SWEPT, l)]
    energy = beam + mass + contact + X[row(R.LOST, l)]
    return beam, mass, contact, w, energy + swept / 4 - X[row(R.WORK, l)] / 2


@inlined
def proven_well(X, l, energies, margin):
    """The well (1 or 2) that the beam can never leave without a shock, or 0 if that is open.

    Energy only falls after the pulse. 1 or 2: all of it is below the barrier. 2: the beam's alone
    is, and the mass on its spring cannot swing as low as the beam can rise, the saddle.
    """
    beam, mass, contact, w = energies
    barrier, saddle = X[row(R.BARRIER, l)], X[row(R.SADDLE, l)]
    if beam + mass + contact + margin < barrier:
        return 1 if w > saddle else 2
    lowest_mass = -np.sqrt(2 * (mass + margin) / X[row(R.SPRING, l)])
    if beam + margin < barrier and w < saddle < lowest_mass + X[row(R.GAP, l)]:
        return 2
    return 0

"""The one place that knows which scheme is followed."""

from ...numerics.kept_kernels import compiled, inlined
from . import rows as R
from .conserving import advance_conserving
from .energy import (
    conserved_energies,
    conserved_ledger,
    half_step_midpoint,
    whole_step_energies,
    whole_step_ledger,
    whole_step_stretch,
)
from .explicit import advance_explicit
from .pulse import BLOCK
from .rows import LANES, row
from .shared import copy
from .stops import crossed, has_stops, meet_stops, overlap_at_half

EXPLICIT, CONSERVING = (0,), (0, 0)
"""As kernels take a scheme: numba knows a tuple's length, and compiles nothing of the other one."""
GUARD = 0.1
"""Largest residual of the energy at whole steps, over the gross work of the pulse, of any run."""


@inlined
def added_inertia(scheme):
    """Inertia over the stiffness times dt^2 that means of linear forces over three instants add."""
    if len(scheme) == 1:
        return 0.0
    return 0.25


@compiled
def advance(X, shape, scheme, shocks, first, steps):
    """Advance every lane by `steps` steps."""
    if len(scheme) == 1:
        advance_explicit(X, shape, shocks, first, steps)
    else:
        advance_conserving(X, shape, shocks, first, steps)


@compiled
def rebound(X, shape, scheme):
    """Reflect the masses that have crossed a stop, as the next step else begins with."""
    if has_stops(X) and crossed(X):
        if len(scheme) == 1:
            overlap_at_half(X, shape)
        meet_stops(X)


@inlined
def advance_block(X, shape, scheme, shocks, before, after):
    """Advance every lane by a block.

    before, after: the last two instants, modified in place; the explicit scheme's energy is that
    between them
    """
    if len(scheme) == 1:
        first, end = R.STATE * LANES, (R.VECTORS + R.SCRATCH * len(shape)) * LANES
        advance_explicit(X, shape, shocks, 0, BLOCK - 1)
        rebound(X, shape, scheme)
        copy(X, before, first, end, 1)
        advance_explicit(X, shape, shocks, BLOCK - 1, 1)
        copy(X, after, first, end, 1)
    else:
        advance_conserving(X, shape, shocks, 0, BLOCK)


@inlined
def ledger(X, shape, scheme, l, instants, drag):
    """Energy of the beam, the mass and the contact, w, and the residual of the ledger.

    instants: before, after, of which the explicit scheme takes its energy; drag: C dt
    """
    if len(scheme) == 1:
        return whole_step_ledger(*instants, X, shape, l, drag)
    return conserved_ledger(X, shape, l, drag)


@inlined
def is_confirmed(X, scheme, l, well):
    """Whether a proof is believed: of the explicit scheme, whose energy wobbles, the second."""
    if len(scheme) == 1:
        again = well == X[row(R.PROVEN_BEFORE, l)]
        X[row(R.PROVEN_BEFORE, l)] = well
        return again
    return True


@inlined
def guarded(X, shape, scheme, l, instants, drag, residual, scale):
    """The residual at the very end of an explicit run if beyond GUARD, else the one given."""
    if len(scheme) == 1:
        at_end = whole_step_ledger(*instants, X, shape, l, drag)[4]
        if not abs(at_end) * scale <= GUARD:
            return at_end
    return residual


@inlined
def observe(before, X, shape, scheme, l):
    """y, all energy and the beam's: at the instant `before`, or half way from there to X."""
    if len(scheme) == 1:
        y, energies = before[row(R.Y, l)], whole_step_energies(before, X, X, shape, l)
    else:
        y = before[row(R.Y, l)] + X[row(R.Y_STEP, l)] / 2
        energies = conserved_energies(X, shape, l)
    beam, mass, contact, _ = energies
    return y, beam + mass + contact, beam


@inlined
def stretch_and_contact(X, shape, scheme, l):
    """u.G u + 2 u.G q0, and the contact force times dt^2, where `midpoint` has w."""
    if len(scheme) == 1:
        stretch, overlap = whole_step_stretch(X, shape, l)
    else:
        stretch, overlap = X[row(R.STRETCH, l)], X[row(R.OVERLAP, l)]
    return stretch, X[row(R.CONTACT, l)] * max(0.0, overlap)


@inlined
def midpoint(X, shape, scheme, l):
    """w(L/2) from rest, where `observe` has it, contact within the midpoint's own stiffness."""
    if len(scheme) == 1:
        return X[row(R.W, l)]
    overlap = X[row(R.OVERLAP, l)]
    force = X[row(R.CONTACT, l)] * (overlap if overlap > 0.0 else 0.0)
    return half_step_midpoint(X, shape, l) - X[row(R.RESIDUAL, l)] * force

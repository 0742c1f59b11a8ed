"""One step in which contact and stretch do the work they store: docs/theory.md, "One step"."""

import numpy as np

from ...numerics.arithmetic import fma, widen_vectors
from ...numerics.kept_kernels import compiled, inlined
from . import rows as R
from .rows import LANES, at, row
from .shared import latch, move_mass, take
from .stops import crossed, has_stops, meet_stops


@compiled
def advance(X, shape, shocks, first, steps):
    """Advance every lane by `steps` steps.

    shocks: a dt^2 of each step of a block, as `set_out` leaves them; first: the step to begin with

    At half steps q = p.S p+ + (p + p+).S q0 and x = e.(p + p+)/2 - (y + y+)/2 - z0, z0 the gap at
    rest; with u = S p + S q0,

    r = (q+ + q-)/2,  N = -EA/2L r,  P = k (<x+>^2 - <x->^2) / 2 (x+ - x-)
    p+ - 2 p + p- + alpha dt/2 (p+ - p-) = dt^2 (-kappa p + N u - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)

    r is linear in P, and x+ in both: x+ = F - beta P, which has one root.
    """
    widen_vectors()
    modes = len(shape)
    # LLVM unrolls a short loop and gives up on a long one, and only what is unrolled vectorises
    # over lanes: so the loops over modes are cut in four.
    cut_1, cut_2, cut_3 = modes // 4, modes // 2, 3 * modes // 4
    stopped = has_stops(X)
    for step in range(first, first + steps):
        if stopped and crossed(X):
            meet_stops(X)
        take(X, shocks, step)
        for l in range(LANES):
            a = X[row(R.SHOCK, l)]
            sums = release(X, l, modes, 0, cut_1, a, (0.0, 0.0, 0.0, 0.0, 0.0))
            sums = release(X, l, modes, cut_1, cut_2, a, sums)
            sums = release(X, l, modes, cut_2, cut_3, a, sums)
            touch(X, l, a, release(X, l, modes, cut_3, modes, a, sums))
        switch_contacts(X)
        for l in range(LANES):
            force, pull = meet(X, l)
            kick, sums = X[row(R.BEAM_MOBILITY, l)] * force, (0.0, X[row(R.BEAM_SWEPT, l)])
            sums = press(X, l, modes, 0, cut_1, pull, kick, sums)
            sums = press(X, l, modes, cut_1, cut_2, pull, kick, sums)
            sums = press(X, l, modes, cut_2, cut_3, pull, kick, sums)
            swept, X[row(R.BEAM_SWEPT, l)] = press(X, l, modes, cut_3, modes, pull, kick, sums)
            move_mass(X, l, fma(X[row(R.MOBILITY, l)], force, X[row(R.Y_FREE, l)]), swept)


@inlined
def touch(X, l, a, sums):
    """F and beta of the overlap, and P where no contact opens or closes; sums: of `release`."""
    uu, eu, w, ef, ud = sums
    y, overlap = X[row(R.Y, l)], X[row(R.OVERLAP, l)]
    pull = fma(-X[row(R.MASS, l)], a, -X[row(R.SPRING, l)] * y)
    y_free = fma(X[row(R.MOBILITY, l)], pull, X[row(R.KEEP, l)] * X[row(R.Y_STEP, l)])

    # t_beta = t beta, t_1_h = t (1 + h), and one division for 1/t and beta.
    gamma, half_k = X[row(R.TENSION, l)], X[row(R.HALF_CONTACT, l)]
    t = fma(gamma, uu, 1.0)
    rho = fma(0.5, ud, X[row(R.STRETCH, l)])
    t_beta = fma(X[row(R.COMPLIANCE, l)], t, -X[row(R.SOFTENING, l)] * eu * eu)
    t_1_h = fma(half_k, t_beta, t)
    both = 1.0 / (t * t_1_h)
    inverse, beta = t_1_h * both, t_beta * (t_1_h * both)
    apart = w - y - X[row(R.GAP, l)]
    F = fma(-gamma * eu, rho * inverse, apart + (ef - y_free) / 2)
    is_open = (overlap <= 0.0) & (F <= 0.0)
    is_closed = (overlap >= 0.0) & (half_k * beta * overlap <= F)
    X[row(R.FORCE, l)] = half_k * (F + overlap) * (t * (t * both)) if is_closed else 0.0
    X[row(R.SWITCHES, l)] = 0.0 if is_open | is_closed else 1.0
    X[row(R.W_FREE, l)], X[row(R.Y_FREE, l)] = w, y_free
    X[row(R.OVERLAP_FREE, l)], X[row(R.OVERLAP_GIVE, l)] = F, beta
    X[row(R.STRETCH_FREE, l)], X[row(R.INVERSE, l)] = rho, inverse
    X[row(R.ALONG, l)] = eu


@inlined
def switch_contacts(X):
    """P of the lanes in which a contact opens or closes, by its square root."""
    switches = False
    for l in range(LANES):
        switches |= X[row(R.SWITCHES, l)] > 0.0
    if switches:
        for l in range(LANES):
            if X[row(R.SWITCHES, l)] == 0.0:
                continue
            m, F, beta = X[row(R.OVERLAP, l)], X[row(R.OVERLAP_FREE, l)], X[row(R.OVERLAP_GIVE, l)]
            h = X[row(R.HALF_CONTACT, l)] * beta
            root = np.sqrt((F - m) ** 2 + 4 * h * m * (m if m > 0.0 else -F))
            x = (F + m - root) / 2 if m > 0.0 else (F + m + root) / (2 * (1 + h))
            X[row(R.FORCE, l)] = (F - x) / beta


@inlined
def meet(X, l):
    """q and x at the next half step, w latched; returns P and 2 gamma r."""
    force, b = X[row(R.FORCE, l)], X[row(R.BEAM_MOBILITY, l)]
    r = fma(-X[row(R.ALONG, l)] * (b / 2), force, X[row(R.STRETCH_FREE, l)])
    r *= X[row(R.INVERSE, l)]
    X[row(R.STRETCH, l)] = fma(2.0, r, -X[row(R.STRETCH, l)])
    X[row(R.OVERLAP, l)] = fma(-X[row(R.OVERLAP_GIVE, l)], force, X[row(R.OVERLAP_FREE, l)])
    latch(X, l, fma(-X[row(R.RESIDUAL, l)], force, X[row(R.W_FREE, l)]))
    return force, 2 * X[row(R.TENSION, l)] * r


@inlined
def release(X, l, modes, first, last, a, sums):
    """`release_some`, its modes cut in two once more."""
    middle = (first + last) // 2
    sums = release_some(X, l, modes, first, middle, a, sums)
    return release_some(X, l, modes, middle, last, a, sums)


@inlined
def release_some(X, l, modes, first, last, a, sums):
    """free_i = keep d_i + b (-kappa p - f a)_i and u_i = (S p + S q0)_i, d = p - p-.

    sums: u.u, e.u, e.p, e.free and u.(d + free) so far; returned with their shares added
    """
    uu, eu, ep, ef, ud = sums
    for i in range(first, last):
        u = X[at(R.SLOPE_START, i, modes, l)]
        for j in range(modes):
            u = fma(X[at(R.GEOMETRIC + i, j, modes, l)], X[at(R.P, j, modes, l)], u)
        p, d = X[at(R.P, i, modes, l)], X[at(R.P_STEP, i, modes, l)]
        force = fma(-X[at(R.STIFFNESS, i, modes, l)], p, -X[at(R.LOAD, i, modes, l)] * a)
        free = fma(X[row(R.BEAM_MOBILITY, l)], force, X[row(R.BEAM_KEEP, l)] * d)
        X[at(R.SCRATCH, i, modes, l)], X[at(R.FREE, i, modes, l)] = u, free
        e = X[at(R.MIDPOINT, i, modes, l)]
        uu, eu, ep = fma(u, u, uu), fma(e, u, eu), fma(e, p, ep)
        ef, ud = fma(e, free, ef), fma(u, d + free, ud)
    return uu, eu, ep, ef, ud


@inlined
def press(X, l, modes, first, last, pull, kick, sums):
    """(p+ - p = free - pull u - kick e)_i.

    sums: load.(p+ - p-) and |p+ - p-|^2 so far; returned with their shares added
    """
    swept, squared = sums
    for i in range(first, last):
        before = X[at(R.P_STEP, i, modes, l)]
        after = fma(-pull, X[at(R.SCRATCH, i, modes, l)], X[at(R.FREE, i, modes, l)])
        after = fma(-kick, X[at(R.MIDPOINT, i, modes, l)], after)
        X[at(R.P_STEP, i, modes, l)] = after
        X[at(R.P, i, modes, l)] += after
        swept = fma(X[at(R.LOAD, i, modes, l)], before + after, swept)
        squared = fma(before + after, before + after, squared)
    return swept, squared

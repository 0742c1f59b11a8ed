"""One step of central differences, forces at the instant: eqs. (2), (4) and (5) in modes."""

from ...numerics.arithmetic import fma, widen_vectors
from ...numerics.kept_kernels import compiled, inlined
from . import rows as R
from .rows import LANES, at, row
from .shared import latch, move_mass, take
from .stops import crossed, has_stops, meet_stops, overlap_at_half


@compiled
def advance_explicit(X, shape, shocks, first, steps):
    """Advance every lane by `steps` steps.

    shocks: a dt^2 of each step of a block, as `set_out` leaves them; first: the step to begin with

    N = -EA/2L (p.S p + 2 p.S q0),  w = e.p - c P,  P = <e.p - y - z0>+ / (1/lambda + c)
    p+ - 2 p + p- + alpha dt/2 (p+ - p-) = dt^2 (-kappa p + N (S p + S q0) - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)
    """
    widen_vectors()
    modes = len(shape)
    # LLVM unrolls a short loop and gives up on a long one, and only what is unrolled vectorises
    # over lanes: so the loops over modes are cut in four.
    cut_1, cut_2, cut_3 = modes // 4, modes // 2, 3 * modes // 4
    stopped = has_stops(X)
    for step in range(first, first + steps):
        if stopped and crossed(X):
            overlap_at_half(X, shape)
            meet_stops(X)
        take(X, shocks, step)
        for l in range(LANES):
            a, y = X[row(R.SHOCK, l)], X[row(R.Y, l)]
            quadratic = stretch(X, l, modes, 0, cut_1) + stretch(X, l, modes, cut_1, cut_2)
            quadratic += stretch(X, l, modes, cut_2, cut_3) + stretch(X, l, modes, cut_3, modes)
            axial = -X[row(R.AXIAL, l)] * quadratic
            w = 0.0
            for i in range(modes):
                w = fma(X[at(R.MIDPOINT, i, modes, l)], X[at(R.P, i, modes, l)], w)
            force = X[row(R.CONTACT, l)] * (w - y - X[row(R.GAP, l)])
            force = force if force > 0.0 else 0.0
            latch(X, l, fma(-X[row(R.RESIDUAL, l)], force, w))

            swept_1, squared_1 = move(X, l, modes, 0, cut_1, axial, force, a)
            swept_2, squared_2 = move(X, l, modes, cut_1, cut_2, axial, force, a)
            swept_3, squared_3 = move(X, l, modes, cut_2, cut_3, axial, force, a)
            swept_4, squared_4 = move(X, l, modes, cut_3, modes, axial, force, a)
            X[row(R.BEAM_SWEPT, l)] += squared_1 + squared_2 + squared_3 + squared_4
            pull = fma(-X[row(R.MASS, l)], a, fma(-X[row(R.SPRING, l)], y, force))
            after = fma(X[row(R.KEEP, l)], X[row(R.Y_STEP, l)], X[row(R.MOBILITY, l)] * pull)
            move_mass(X, l, after, swept_1 + swept_2 + swept_3 + swept_4)


@inlined
def stretch(X, l, modes, first, last):
    """(scratch = S p + S q0)_i from first to last, not included; their p.S p + 2 p.S q0."""
    quadratic = 0.0
    for i in range(first, last):
        slope = X[at(R.SLOPE_START, i, modes, l)]
        total = slope
        for j in range(modes):
            total = fma(X[at(R.GEOMETRIC + i, j, modes, l)], X[at(R.P, j, modes, l)], total)
        X[at(R.SCRATCH, i, modes, l)] = total
        quadratic = fma(X[at(R.P, i, modes, l)], total + slope, quadratic)
    return quadratic


@inlined
def move(X, l, modes, first, last, axial, contact, a):
    """One step of p_i, likewise; returns their load.(p+ - p-) and |p+ - p-|^2."""
    swept, squared = 0.0, 0.0
    for i in range(first, last):
        p, before = X[at(R.P, i, modes, l)], X[at(R.P_STEP, i, modes, l)]
        force = fma(-X[at(R.STIFFNESS, i, modes, l)], p, axial * X[at(R.SCRATCH, i, modes, l)])
        force = fma(-X[at(R.MIDPOINT, i, modes, l)], contact, force)
        force = fma(-X[at(R.LOAD, i, modes, l)], a, force)
        after = fma(X[row(R.BEAM_KEEP, l)], before, X[row(R.BEAM_MOBILITY, l)] * force)
        X[at(R.P_STEP, i, modes, l)] = after
        X[at(R.P, i, modes, l)] = p + after
        swept = fma(X[at(R.LOAD, i, modes, l)], before + after, swept)
        squared = fma(before + after, before + after, squared)
    return swept, squared

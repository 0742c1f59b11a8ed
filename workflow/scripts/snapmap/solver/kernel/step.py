"""A step in which contact and stretch do exactly the work that they store; stops of the mass.

See docs/theory.md, "One step" and "Stops".
"""

from collections.abc import Callable

import numpy as np
from numba.extending import overload

from ...numerics.kernels import OF_KERNELS, called, compiled, fma, inlined, widen_vectors
from . import rows as R
from .access import numbers, vectors
from .laws import LaneLaws, damp, dissipate, hold_by_law, touch_by_law
from .rows import LANES, Rows, Shape

Sums = tuple[float, ...]


@compiled
def advance(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    shocks: np.ndarray,
    first: int,
    steps: int,
) -> None:
    """Advance every lane by `steps` steps.

    laws: `LaneLaws` or None
    shocks: a dt^2 of each step of a block, as `set_out` sets them; first: index of the first step

    At half steps q = p.S p+ + (p + p+).S q0 is the stretch and x = e.(p + p+)/2 - (y + y+)/2 - z0
    the overlap, with the gap z0 at rest. With u = S p + S q0,

    r = (q+ + q-)/2,  N = -EA/2L r,  P = k (<x+>^2 - <x->^2) / 2 (x+ - x-)
    p+ - 2 p + p- + alpha dt/2 (p+ - p-) = dt^2 (-kappa p + N u - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)

    r is linear in P, and so is x+ = F - beta P, which with P(x+) has a single root.
    """
    widen_vectors()
    X, V = numbers(work), vectors(work, len(shape))
    stopped = has_stops(work)
    for step in range(first, first + steps):
        if stopped and crossed(work):
            meet_stops(work)
        take(X, shocks, step)
        if laws is not None and laws.damping != 0:
            damp(work, laws)
        for l in range(LANES):
            touch(X, l, release_all(X, V, shape, l, (0.0, 0.0, 0.0, 0.0, 0.0)))
        switch_contacts(X)
        if stopped:
            let_go(work)
        if laws is not None and laws.holds:
            hold_by_law(work, laws)
        elif laws is not None and laws.tabled:
            touch_by_law(work, laws)
        for l in range(LANES):
            press(X, V, shape, l, meet(X, l))
        if laws is not None and laws.damping != 0:
            dissipate(X)


@inlined
def take(X: Rows, shocks: np.ndarray, step: int) -> None:
    """Set a of this step; in a loop of its own, as else the compiler separates the lanes."""
    for l in range(LANES):
        X[R.A, l] = shocks[step * LANES + l]


FEW = 5
"""Most modes that LLVM unrolls in a single loop."""


def over_modes(loop: Callable, times: int) -> Callable:
    """Make a function over all modes of a loop over modes `first` to `last`.

    LLVM unrolls short loops only, and only an unrolled one vectorises over lanes; else a step takes
    twice the time. So a loop over more than FEW modes is cut; the type of `shape` decides, as each
    cut takes time to compile.
    times: how often a long loop is cut in two
    """
    parts = loop
    for _ in range(times):
        parts = halved(parts)

    def all_modes(X, V, shape, l, sums):
        raise NotImplementedError("is only called by kernels")

    @overload(all_modes, jit_options=OF_KERNELS)
    def choose(X, V, shape, l, sums):
        chosen = loop if shape.count <= FEW else parts
        return lambda X, V, shape, l, sums: chosen(X, V, len(shape), l, 0, len(shape), sums)

    return all_modes


def halved(loop: Callable) -> Callable:
    """Make a loop over modes that runs as two loops, each over half of them."""

    @inlined
    def both(X, V, modes, l, first, last, sums):
        middle = (first + last) // 2
        sums = loop(X, V, modes, l, first, middle, sums)
        return loop(X, V, modes, l, middle, last, sums)

    return both


@inlined
def release_modes(X: Rows, V: Rows, modes: int, l: int, first: int, last: int, sums: Sums) -> Sums:
    """Set d_free = keep d + b (-kappa p - f a) and u = S p + S q0, of modes first to last - 1.

    sums: u.u, e.u, e.p, e.d_free and u.(d + d_free) of the modes before; returned with these
    """
    uu, eu, ep, ef, ud = sums
    a = X[R.A, l]
    for i in range(first, last):
        u = V[R.SQ0, i, l]
        for j in range(modes):
            u = fma(V[R.S + i, j, l], V[R.P, j, l], u)
        p, d, e = V[R.P, i, l], V[R.D, i, l], V[R.E, i, l]
        force = fma(-V[R.KAPPA, i, l], p, -V[R.F, i, l] * a)
        free = fma(X[R.BEAM_B, l], force, X[R.BEAM_KEEP, l] * d)
        V[R.U, i, l], V[R.D_FREE, i, l] = u, free
        uu, eu, ep = fma(u, u, uu), fma(e, u, eu), fma(e, p, ep)
        ef, ud = fma(e, free, ef), fma(u, d + free, ud)
    return uu, eu, ep, ef, ud


release_all = over_modes(release_modes, 3)


@inlined
def touch(X: Rows, l: int, sums: Sums) -> None:
    """Set F and beta, and P if no contact opens or closes; sums: as `release_all` returns them."""
    uu, eu, w, ef, ud = sums
    a, y, overlap = X[R.A, l], X[R.Y, l], X[R.OVERLAP, l]
    pull = fma(-X[R.M, l], a, -X[R.K, l] * y)
    y_free = fma(X[R.B, l], pull, X[R.KEEP, l] * X[R.DY, l])

    # t_beta = t beta, t_1_h = t (1 + h), and one division for 1/t and beta.
    gamma, half_k = X[R.GAMMA, l], X[R.HALF_CONTACT, l]
    t = fma(gamma, uu, 1.0)
    rho = fma(0.5, ud, X[R.Q, l])
    t_beta = fma(X[R.COMPLIANCE, l], t, -X[R.SOFTENING, l] * eu * eu)
    t_1_h = fma(half_k, t_beta, t)
    both = 1.0 / (t * t_1_h)
    inverse, beta = t_1_h * both, t_beta * (t_1_h * both)
    apart = w - y - X[R.Z0, l]
    F = fma(-gamma * eu, rho * inverse, apart + (ef - y_free) / 2)
    is_open = (overlap <= 0.0) & (F <= 0.0)
    is_closed = (overlap >= 0.0) & (half_k * beta * overlap <= F)
    X[R.FORCE, l] = half_k * (F + overlap) * (t * (t * both)) if is_closed else 0.0
    X[R.SWITCHES, l] = 0.0 if is_open | is_closed else 1.0
    X[R.EP, l], X[R.DY_FREE, l] = w, y_free
    X[R.OVERLAP_FREE, l], X[R.BETA, l] = F, beta
    X[R.Q_FREE, l], X[R.INVERSE, l] = rho, inverse
    X[R.EU, l] = eu


@inlined
def switch_contacts(X: Rows) -> None:
    """Set P, by the root of a quadratic, in lanes in which a contact opens or closes."""
    switches = False
    for l in range(LANES):
        switches |= X[R.SWITCHES, l] > 0.0
    if switches:
        for l in range(LANES):
            if X[R.SWITCHES, l] > 0.0:
                X[R.FORCE, l] = contact_force(X, l)


@inlined
def contact_force(X: Rows, l: int) -> float:
    """Return P, the root of x + beta P(x) = F, whether or not a contact opens or closes."""
    m, F, beta = X[R.OVERLAP, l], X[R.OVERLAP_FREE, l], X[R.BETA, l]
    h = X[R.HALF_CONTACT, l] * beta
    if m <= 0.0 and F <= 0.0:
        return 0.0
    if m >= 0.0 and h * m <= F:
        return X[R.HALF_CONTACT, l] * (F + m) / (1 + h)
    root = np.sqrt((F - m) ** 2 + 4 * h * m * (m if m > 0.0 else -F))
    x = (F + m - root) / 2 if m > 0.0 else (F + m + root) / (2 * (1 + h))
    return (F - x) / beta


@inlined
def meet(X: Rows, l: int) -> float:
    """Set q and x at the next half step, and w = e.p - c P; returns 2 gamma r.

    At the first instant at which w, or -w in a run from the second shape, is at or below the
    target, it is latched with the value before.
    """
    force, b = X[R.FORCE, l], X[R.BEAM_B, l]
    r = fma(-X[R.EU, l] * (b / 2), force, X[R.Q_FREE, l])
    r *= X[R.INVERSE, l]
    X[R.Q, l] = fma(2.0, r, -X[R.Q, l])
    X[R.OVERLAP, l] = fma(-X[R.BETA, l], force, X[R.OVERLAP_FREE, l])
    w = X[R.SIDE, l] * fma(-X[R.RESIDUAL, l], force, X[R.EP, l])
    w_last = X[R.W, l]
    above = w_last > X[R.TARGET, l]
    X[R.W_BEFORE, l] = w_last if above else X[R.W_BEFORE, l]
    X[R.W, l] = w if above else w_last
    X[R.COUNT, l] += 1.0 if above else 0.0
    X[R.BEYOND, l] += 1.0 if w < X[R.SADDLE, l] else 0.0
    X[R.LOWEST, l] = w if w < X[R.LOWEST, l] else X[R.LOWEST, l]
    return 2 * X[R.GAMMA, l] * r


@inlined
def press_modes(X: Rows, V: Rows, modes: int, l: int, first: int, last: int, sums: Sums) -> Sums:
    """Set p+ as in `press`, of modes first to last - 1.

    sums: 2 gamma r, b P, and f.(p+ - p-) and |p+ - p-|^2 of the modes before; returned with these
    """
    pull, kick, swept, squared = sums
    for i in range(first, last):
        before = V[R.D, i, l]
        after = fma(-pull, V[R.U, i, l], V[R.D_FREE, i, l])
        after = fma(-kick, V[R.E, i, l], after)
        V[R.D, i, l] = after
        V[R.P, i, l] += after
        swept = fma(V[R.F, i, l], before + after, swept)
        squared = fma(before + after, before + after, squared)
    return pull, kick, swept, squared


press_all = over_modes(press_modes, 4)


@inlined
def press(X: Rows, V: Rows, shape: Shape, l: int, pull: float) -> None:
    """Set p+ = p + d_free - 2 gamma r u - b e P and y+ = y + dy_free + B P; pull: 2 gamma r."""
    kick = X[R.BEAM_B, l] * X[R.FORCE, l]
    sums = press_all(X, V, shape, l, (pull, kick, 0.0, X[R.BEAM_SWEPT, l]))
    _, _, swept, X[R.BEAM_SWEPT, l] = sums
    before, after = X[R.DY, l], fma(X[R.B, l], X[R.FORCE, l], X[R.DY_FREE, l])
    X[R.DY, l] = after
    X[R.Y, l] += after
    work = -X[R.A, l] * fma(X[R.M, l], before + after, swept)
    X[R.WORK, l] += work
    X[R.GROSS_WORK, l] += abs(work)
    X[R.SWEPT, l] = fma(before + after, before + after, X[R.SWEPT, l])


@called
def has_stops(work: np.ndarray) -> bool:
    """Return whether the mass of any lane has a stop; empty lanes have zeros there."""
    X, any_lane = numbers(work), False
    for l in range(LANES):
        any_lane |= 0.0 < X[R.STOP_TOWARD, l] < np.inf
        any_lane |= 0.0 < X[R.STOP_AWAY, l] < np.inf
    return any_lane


@called
def crossed(work: np.ndarray) -> bool:
    """Return whether the mass of any lane is beyond a stop."""
    X, any_lane = numbers(work), False
    for l in range(LANES):
        any_lane |= (X[R.Y, l] < -X[R.STOP_TOWARD, l]) | (X[R.Y, l] > X[R.STOP_AWAY, l])
    return any_lane


@called
def meet_stops(work: np.ndarray) -> None:
    """Reflect every mass that is beyond a stop and moves on.

    At the last half step it was at m with speed d. In the potential U it meets the stop s with
    v^2 = d^2 + 2 (U(m) - U(s)) dt^2/M, leaves with e v, and then is at m' = s - e (m - s).
    """
    X = numbers(work)
    for l in range(LANES):
        if X[R.Y, l] < -X[R.STOP_TOWARD, l] and X[R.DY, l] < 0.0:
            strike(X, l, -X[R.STOP_TOWARD, l])
        if X[R.Y, l] > X[R.STOP_AWAY, l] and X[R.DY, l] > 0.0:
            strike(X, l, X[R.STOP_AWAY, l])


@compiled
def rebound(work: np.ndarray) -> None:
    """Reflect masses that have crossed a stop now, and not at the begin of the next step."""
    if has_stops(work) and crossed(work):
        meet_stops(work)


@inlined
def strike(X: Rows, l: int, stop: float) -> None:
    """Reflect the mass of lane l at a stop, and account for its energy."""
    d, mass, e = X[R.DY, l], X[R.M, l], X[R.RESTITUTION, l]
    middle, weight = X[R.Y, l] - d / 2, mass * X[R.A, l]
    squared = d * d - 2 * (stored(X, l, middle, stop) + weight * (stop - middle)) / mass
    if squared <= 0.0 and (middle - stop) * d < 0.0:
        return  # the mass turns before the stop, and is beyond it by the error of the step only
    left = e * e * max(squared, 0.0)
    place = stop - e * (middle - stop)
    away = left - 2 * (stored(X, l, stop, place) + weight * (place - stop)) / mass
    if away < 0.0:
        place, away = stop, 0.0
        hold(X, l)
    turned = -np.copysign(np.sqrt(away), d)
    work = weight * (middle - place)
    taken = mass * (d * d - away) / 2 - stored(X, l, middle, place) + work
    X[R.LOST, l] += max(taken, 0.0)
    X[R.WORK, l] += 2 * work
    X[R.GROSS_WORK, l] += abs(2 * work)
    X[R.OVERLAP, l] -= place - middle
    X[R.Y, l], X[R.DY, l] = place + turned / 2, turned
    X[R.DY_BEFORE, l] = turned


@inlined
def hold(X: Rows, l: int) -> None:
    """Keep the mass of lane l from moving: without B no force moves it."""
    X[R.HELD, l], X[R.B, l] = X[R.B, l], 0.0
    X[R.COMPLIANCE, l] -= X[R.HELD, l] / 2


@called
def let_go(work: np.ndarray) -> None:
    """Free every mass that the net force of this step pulls off its stop, and set its P anew."""
    X = numbers(work)
    for l in range(LANES):
        B, y = X[R.HELD, l], X[R.Y, l]
        pull = fma(-X[R.M, l], X[R.A, l], -X[R.K, l] * y)
        if (pull + X[R.FORCE, l]) * y < 0.0 < B:
            X[R.B, l], X[R.HELD, l] = B, 0.0
            X[R.COMPLIANCE, l] += B / 2
            X[R.BETA, l] += B / 2
            X[R.DY_FREE, l] = B * pull
            X[R.OVERLAP_FREE, l] -= B * pull / 2
            X[R.FORCE, l] = contact_force(X, l)


@inlined
def stored(X: Rows, l: int, begin: float, end: float) -> float:
    """Return the energy that spring and contact store as the mass moves from `begin` to `end`."""
    middle = X[R.Y, l] - X[R.DY, l] / 2
    before = max(0.0, X[R.OVERLAP, l] - (begin - middle))
    after = max(0.0, X[R.OVERLAP, l] - (end - middle))
    contact = X[R.CONTACT, l] * (after - before) * (after + before) / 2
    return X[R.K, l] * (end - begin) * (begin + end) / 2 + contact

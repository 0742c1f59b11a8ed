"""The kernels of every modal model: central differences of two kinds, one cell per SIMD lane.

All state and coefficients of the cells in flight stand in one flat array X, row r of lane l at
X[row(r, l)]: only so does the compiler see that rows never alias, and vectorises over lanes.
Each lane has coefficients of its own, so cells of different devices share a call, and no lane's
result depends on its neighbours. Times in X are counted in steps, forces are times dt^2.

A function compiled for k modes gets them as `shape`, a tuple of k numbers, whose length the
compiler knows.
"""

from typing import NamedTuple

import numpy as np

from ..numerics import pieces as curve
from ..numerics.arithmetic import fma, sine, widen_vectors
from ..numerics.kept_kernels import compiled, inlined

LANES = 16
BLOCK = 64
"""Steps between two looks at the lanes; the pulse is set out for so many at a time."""
MARGIN = 2.0
"""A proof must hold by this many times the largest residual of the energy ledger seen so far."""
OPENED = 4.0
"""A run is given up at the look at which its ledger misses by this many times the tolerance."""
GUARD = 0.1
"""Largest residual of the energy at whole steps, over the gross work of the pulse, of any run."""
# ASSUME: a trace looks at every fourth instant; the ringing of w has some forty to a period.
SAMPLE = 4
"""Steps between two looks at w for a trace; a divisor of BLOCK."""

# Rows of one number: the device's; the cell's; scratch; from STATE on, the state at instant n.
AXIAL, RESIDUAL, CONTACT, MASS, SPRING, TARGET, BARRIER, SADDLE = range(8)
CLEARANCE, BEAM_DAMPING = 8, 9
AMPLITUDE, KEEP, PUSH, BEAM_KEEP, BEAM_PUSH = range(10, 15)
X_STEP, PIECE = 15, 16
BEGIN, START, SLOPE, TURNS, LIFT, SWING, TURN, PULSE, PULSE_STEP, PULSE_LEFT = range(16, 26)
HALF_CONTACT, TENSION, SOFTENING, COMPLIANCE = range(26, 30)
SHOCK, W_FREE, Y_FREE, GAP_FREE, GAP_GIVE, STRETCH_MEAN, INVERSE, ALONG, PRESS, TURNING = range(
    30, 40
)
STATE = 40
Y, Y_STEP, STRETCH, GAP = range(40, 44)
W_BEFORE, W, COUNT, WORK, GROSS_WORK, SWEPT, BEAM_SWEPT, BEYOND = range(44, 52)
# Vectors of k rows, from row VECTORS on: the state; scratch; the device's; S, k vectors.
VECTORS = 52
P, P_STEP, SCRATCH, FREE, STIFFNESS, SLOPE_START, LOAD, MIDPOINT, GEOMETRIC = range(9)


class Pushes(NamedTuple):
    """How the pulse stands in each lane, (LANES,); modified in place.

    pulse: its number; piece: the last one that was entered; steps: done; lasts: steps until it is
    over
    """

    pulse: np.ndarray
    piece: np.ndarray
    steps: np.ndarray
    lasts: np.ndarray


@inlined
def row(name, l):
    """Place in X of a row of one number, lane l."""
    return name * LANES + l


@inlined
def at(vector, i, modes, l):
    """Place in X of component i of a vector, lane l."""
    return (VECTORS + vector * modes + i) * LANES + l


@inlined
def take(X, shocks, step):
    """a of this step of every lane; apart, as only so the compiler keeps lanes side by side."""
    for l in range(LANES):
        X[row(SHOCK, l)] = shocks[step * LANES + l]


@inlined
def stretch(X, l, modes, first, last):
    """scratch_i = (S p + S q0)_i; returns their share of p.S p + 2 p.S q0."""
    quadratic = 0.0
    for i in range(first, last):
        slope = X[at(SLOPE_START, i, modes, l)]
        total = slope
        for j in range(modes):
            total = fma(X[at(GEOMETRIC + i, j, modes, l)], X[at(P, j, modes, l)], total)
        X[at(SCRATCH, i, modes, l)] = total
        quadratic = fma(X[at(P, i, modes, l)], total + slope, quadratic)
    return quadratic


@inlined
def move(X, l, modes, first, last, axial, contact, a):
    """One step of p_i; returns their share of load.(p+ - p-) and of |p+ - p-|^2."""
    swept, squared = 0.0, 0.0
    for i in range(first, last):
        p = X[at(P, i, modes, l)]
        before = X[at(P_STEP, i, modes, l)]
        force = fma(-X[at(STIFFNESS, i, modes, l)], p, axial * X[at(SCRATCH, i, modes, l)])
        force = fma(-X[at(MIDPOINT, i, modes, l)], contact, force)
        force = fma(-X[at(LOAD, i, modes, l)], a, force)
        after = fma(X[row(BEAM_KEEP, l)], before, X[row(BEAM_PUSH, l)] * force)
        X[at(P_STEP, i, modes, l)] = after
        X[at(P, i, modes, l)] = p + after
        swept = fma(X[at(LOAD, i, modes, l)], before + after, swept)
        squared = fma(before + after, before + after, squared)
    return swept, squared


@compiled
def advance(X, shape, shocks, first, steps):
    """Advance every lane by `steps` steps of the modal form of eqs. (2), (4) and (5).

    shocks: a dt^2 of each step of a block, as `set_out` leaves them; first: the step to begin with

    N = -EA/2L (p.S p + 2 p.S q0),  w = e.p - c P,  P = <e.p - y - h>+ / (1/lambda + c)
    p+ - 2 p + p- + alpha dt/2 (p+ - p-) = dt^2 (-kappa p + N (S p + S q0) - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)

    w is latched, with the value before, at the first instant at or below the target. Instants at
    which it is beyond the saddle are counted.
    """
    widen_vectors()
    modes = len(shape)
    # LLVM unrolls a short loop and gives up on a long one, and only what is unrolled vectorises
    # over lanes: so the loops over modes are cut in four.
    cut_1, cut_2, cut_3 = modes // 4, modes // 2, 3 * modes // 4
    for step in range(first, first + steps):
        take(X, shocks, step)
        for l in range(LANES):
            a = X[row(SHOCK, l)]
            quadratic = stretch(X, l, modes, 0, cut_1) + stretch(X, l, modes, cut_1, cut_2)
            quadratic += stretch(X, l, modes, cut_2, cut_3) + stretch(X, l, modes, cut_3, modes)
            axial = -X[row(AXIAL, l)] * quadratic
            w = 0.0
            for i in range(modes):
                w = fma(X[at(MIDPOINT, i, modes, l)], X[at(P, i, modes, l)], w)
            y = X[row(Y, l)]
            contact = X[row(CONTACT, l)] * (w - y - X[row(CLEARANCE, l)])
            contact = contact if contact > 0.0 else 0.0

            w_last = X[row(W, l)]
            above = w_last > X[row(TARGET, l)]
            w_now = fma(-X[row(RESIDUAL, l)], contact, w)
            X[row(W_BEFORE, l)] = w_last if above else X[row(W_BEFORE, l)]
            X[row(W, l)] = w_now if above else w_last
            X[row(COUNT, l)] += 1.0 if above else 0.0
            X[row(BEYOND, l)] += 1.0 if w_now < X[row(SADDLE, l)] else 0.0

            swept_1, squared_1 = move(X, l, modes, 0, cut_1, axial, contact, a)
            swept_2, squared_2 = move(X, l, modes, cut_1, cut_2, axial, contact, a)
            swept_3, squared_3 = move(X, l, modes, cut_2, cut_3, axial, contact, a)
            swept_4, squared_4 = move(X, l, modes, cut_3, modes, axial, contact, a)
            swept = swept_1 + swept_2 + swept_3 + swept_4
            X[row(BEAM_SWEPT, l)] += squared_1 + squared_2 + squared_3 + squared_4
            mass = X[row(MASS, l)]
            before = X[row(Y_STEP, l)]
            pull = fma(-mass, a, fma(-X[row(SPRING, l)], y, contact))
            after = fma(X[row(KEEP, l)], before, X[row(PUSH, l)] * pull)
            X[row(Y_STEP, l)] = after
            X[row(Y, l)] = y + after

            work = -a * fma(mass, before + after, swept)
            X[row(WORK, l)] += work
            X[row(GROSS_WORK, l)] += abs(work)
            X[row(SWEPT, l)] = fma(before + after, before + after, X[row(SWEPT, l)])


@inlined
def release(X, l, modes, first, last, a, sums):
    """`release_some`, its modes cut in two once more."""
    middle = (first + last) // 2
    sums = release_some(X, l, modes, first, middle, a, sums)
    return release_some(X, l, modes, middle, last, a, sums)


@inlined
def release_some(X, l, modes, first, last, a, sums):
    """free_i = keep d_i + push (-kappa p - f a)_i and u_i = (S p + S q0)_i, d = p - p-.

    sums: u.u, e.u, e.p, e.free and u.(d + free) so far; returned with their shares added
    """
    uu, eu, ep, ef, ud = sums
    for i in range(first, last):
        u = X[at(SLOPE_START, i, modes, l)]
        for j in range(modes):
            u = fma(X[at(GEOMETRIC + i, j, modes, l)], X[at(P, j, modes, l)], u)
        p, d = X[at(P, i, modes, l)], X[at(P_STEP, i, modes, l)]
        force = fma(-X[at(STIFFNESS, i, modes, l)], p, -X[at(LOAD, i, modes, l)] * a)
        free = fma(X[row(BEAM_PUSH, l)], force, X[row(BEAM_KEEP, l)] * d)
        X[at(SCRATCH, i, modes, l)], X[at(FREE, i, modes, l)] = u, free
        e = X[at(MIDPOINT, i, modes, l)]
        uu, eu, ep = fma(u, u, uu), fma(e, u, eu), fma(e, p, ep)
        ef, ud = fma(e, free, ef), fma(u, d + free, ud)
    return uu, eu, ep, ef, ud


@inlined
def press(X, l, modes, first, last, pull, contact, sums):
    """p+ - p = free - pull u - contact e.

    sums: load.(p+ - p-) and |p+ - p-|^2 so far; returned with their shares added
    """
    swept, squared = sums
    for i in range(first, last):
        before = X[at(P_STEP, i, modes, l)]
        after = fma(-pull, X[at(SCRATCH, i, modes, l)], X[at(FREE, i, modes, l)])
        after = fma(-contact, X[at(MIDPOINT, i, modes, l)], after)
        X[at(P_STEP, i, modes, l)] = after
        X[at(P, i, modes, l)] += after
        swept = fma(X[at(LOAD, i, modes, l)], before + after, swept)
        squared = fma(before + after, before + after, squared)
    return swept, squared


@compiled
def advance_conserving(X, shape, shocks, first, steps):
    """Advance every lane by `steps` steps in which contact and stretch do the work they store.

    shocks, first: as in `advance`

    At half steps q = p.S p+ + (p + p+).S q0 and x = e.(p + p+)/2 - (y + y+)/2 - h, h the gap at
    rest; with u = S p + S q0,

    r = (q+ + q-)/2,  N = -EA/2L r,  P = k (<x+>^2 - <x->^2) / 2 (x+ - x-)
    p+ - 2 p + p- + alpha dt/2 (p+ - p-) = dt^2 (-kappa p + N u - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)

    r is linear in P, and x+ in both: x+ = F - b P, which has one root. See docs/theory.md.
    """
    widen_vectors()
    modes = len(shape)
    cut_1, cut_2, cut_3 = modes // 4, modes // 2, 3 * modes // 4
    for step in range(first, first + steps):
        take(X, shocks, step)
        for l in range(LANES):
            a = X[row(SHOCK, l)]
            sums = release(X, l, modes, 0, cut_1, a, (0.0, 0.0, 0.0, 0.0, 0.0))
            sums = release(X, l, modes, cut_1, cut_2, a, sums)
            sums = release(X, l, modes, cut_2, cut_3, a, sums)
            uu, eu, w, ef, ud = release(X, l, modes, cut_3, modes, a, sums)
            y, gap = X[row(Y, l)], X[row(GAP, l)]
            pull = fma(-X[row(MASS, l)], a, -X[row(SPRING, l)] * y)
            y_free = fma(X[row(PUSH, l)], pull, X[row(KEEP, l)] * X[row(Y_STEP, l)])

            # r = (rho - push eu P/2) / t, with t = 1 + push EA/4L u.u
            tension, half = X[row(TENSION, l)], X[row(HALF_CONTACT, l)]
            t = fma(tension, uu, 1.0)
            rho = fma(0.5, ud, X[row(STRETCH, l)])
            give = fma(X[row(COMPLIANCE, l)], t, -X[row(SOFTENING, l)] * eu * eu)
            stiff = fma(half, give, t)
            both = 1.0 / (t * stiff)
            inverse, b = stiff * both, give * (stiff * both)
            apart = w - y - X[row(CLEARANCE, l)]
            free = fma(-tension * eu, rho * inverse, apart + (ef - y_free) / 2)
            is_open = (gap <= 0.0) & (free <= 0.0)
            is_closed = (gap >= 0.0) & (free >= half * b * gap)
            X[row(PRESS, l)] = half * (free + gap) * (t * (t * both)) if is_closed else 0.0
            X[row(TURNING, l)] = 0.0 if is_open | is_closed else 1.0
            X[row(W_FREE, l)], X[row(Y_FREE, l)] = w, y_free
            X[row(GAP_FREE, l)], X[row(GAP_GIVE, l)] = free, b
            X[row(STRETCH_MEAN, l)], X[row(INVERSE, l)] = rho, inverse
            X[row(ALONG, l)] = eu

        turning = False
        for l in range(LANES):
            turning |= X[row(TURNING, l)] > 0.0
        if turning:
            for l in range(LANES):
                if X[row(TURNING, l)] == 0.0:
                    continue
                m, F, b = X[row(GAP, l)], X[row(GAP_FREE, l)], X[row(GAP_GIVE, l)]
                h = X[row(HALF_CONTACT, l)] * b
                root = np.sqrt((F - m) ** 2 + 4 * h * m * (m if m > 0.0 else -F))
                x = (F + m - root) / 2 if m > 0.0 else (F + m + root) / (2 * (1 + h))
                X[row(PRESS, l)] = (F - x) / b

        for l in range(LANES):
            contact, push = X[row(PRESS, l)], X[row(BEAM_PUSH, l)]
            r = fma(-X[row(ALONG, l)] * (push / 2), contact, X[row(STRETCH_MEAN, l)])
            r *= X[row(INVERSE, l)]
            X[row(STRETCH, l)] = fma(2.0, r, -X[row(STRETCH, l)])
            X[row(GAP, l)] = fma(-X[row(GAP_GIVE, l)], contact, X[row(GAP_FREE, l)])

            w_last = X[row(W, l)]
            above = w_last > X[row(TARGET, l)]
            w_now = fma(-X[row(RESIDUAL, l)], contact, X[row(W_FREE, l)])
            X[row(W_BEFORE, l)] = w_last if above else X[row(W_BEFORE, l)]
            X[row(W, l)] = w_now if above else w_last
            X[row(COUNT, l)] += 1.0 if above else 0.0
            X[row(BEYOND, l)] += 1.0 if w_now < X[row(SADDLE, l)] else 0.0

            pull, kick = 2 * X[row(TENSION, l)] * r, push * contact
            sums = press(X, l, modes, 0, cut_1, pull, kick, (0.0, X[row(BEAM_SWEPT, l)]))
            sums = press(X, l, modes, cut_1, cut_2, pull, kick, sums)
            sums = press(X, l, modes, cut_2, cut_3, pull, kick, sums)
            swept, X[row(BEAM_SWEPT, l)] = press(X, l, modes, cut_3, modes, pull, kick, sums)
            before = X[row(Y_STEP, l)]
            after = fma(X[row(PUSH, l)], contact, X[row(Y_FREE, l)])
            X[row(Y_STEP, l)] = after
            X[row(Y, l)] += after
            work = -X[row(SHOCK, l)] * fma(X[row(MASS, l)], before + after, swept)
            X[row(WORK, l)] += work
            X[row(GROSS_WORK, l)] += abs(work)
            X[row(SWEPT, l)] = fma(before + after, before + after, X[row(SWEPT, l)])


@compiled
def fill(X, shape, is_conserving, l, device, damping, amplitude, dt):
    """Put a cell at rest into lane l.

    device: as `simd_loop.coefficients` has it; damping: C, uN us/um; amplitude: um/us^2; dt: us
    The conserving scheme takes the mean of linear forces over three instants, which is a mode
    heavier by kappa dt^2/4: its coordinate is stretched by 1/s, s^2 = 1/(1 + kappa dt^2/4).
    """
    X[l::LANES] = 0.0
    modes, square = len(shape), dt * dt
    for name in range(AXIAL, BEAM_DAMPING + 1):
        X[row(name, l)] = device[name]
    for name in (AXIAL, CONTACT, SPRING, BARRIER):
        X[row(name, l)] *= square
    X[row(RESIDUAL, l)] /= square
    X[row(BEAM_DAMPING, l)] *= dt
    of_modes = device[BEAM_DAMPING + 1 :]
    for i in range(modes):
        stiffness = square * of_modes[i]
        s = 1 / np.sqrt(1 + stiffness / 4) if is_conserving else 1.0
        X[at(STIFFNESS, i, modes, l)] = stiffness * (s * s)
        for v in range(SLOPE_START, GEOMETRIC):
            X[at(v, i, modes, l)] = s * of_modes[(v - STIFFNESS) * modes + i]
        X[at(SCRATCH, i, modes, l)] = s
    for i in range(modes):
        for j in range(modes):
            element = of_modes[(GEOMETRIC - STIFFNESS + i) * modes + j]
            both = X[at(SCRATCH, i, modes, l)] * X[at(SCRATCH, j, modes, l)]
            X[at(GEOMETRIC + i, j, modes, l)] = both * element
    X[row(GAP, l)] = 0.0 - X[row(CLEARANCE, l)]
    drag = damping * dt / 2
    mass = X[row(MASS, l)]
    heavier = mass + X[row(SPRING, l)] / 4 if is_conserving else mass
    X[row(AMPLITUDE, l)] = amplitude * dt**2
    X[row(KEEP, l)] = (heavier - drag) / (heavier + drag)
    X[row(PUSH, l)] = 1 / (heavier + drag)
    beam_drag = X[row(BEAM_DAMPING, l)] / 2
    X[row(BEAM_KEEP, l)] = (1 - beam_drag) / (1 + beam_drag)
    X[row(BEAM_PUSH, l)] = 1 / (1 + beam_drag)
    beam_push, softness = X[row(BEAM_PUSH, l)], 0.0
    for i in range(len(shape)):
        softness += X[at(MIDPOINT, i, len(shape), l)] ** 2
    X[row(HALF_CONTACT, l)] = X[row(CONTACT, l)] / 2
    X[row(TENSION, l)] = beam_push * X[row(AXIAL, l)] / 2
    X[row(SOFTENING, l)] = beam_push * X[row(TENSION, l)] / 2
    X[row(COMPLIANCE, l)] = (beam_push * softness + X[row(PUSH, l)]) / 2


@compiled
def no_pushes():
    """Lanes without a pulse."""
    pulse, piece, steps, lasts = np.zeros((4, LANES), np.int64)
    return Pushes(pulse, piece, steps, lasts)


@compiled
def push(X, l, pushes, pulses, pulse, x_step):
    """Begin a pulse in lane l; pulses: as in `follow_all`; x_step: f0 dt."""
    bounds, jumps = pulses[1:]
    pushes.pulse[l], pushes.piece[l], pushes.steps[l] = pulse, bounds[pulse] - 1, 0
    pushes.lasts[l] = curve.lasts(jumps[pulse, 1], x_step)
    X[row(X_STEP, l)] = x_step


@compiled
def set_out(X, shocks, pushes, pulses):
    """a dt^2 of every lane and each step of the next block, in rows as X has them."""
    pieces, bounds, jumps = pulses
    joined = 0
    for l in range(LANES):
        steps, pulse, step = pushes.steps[l], pushes.pulse[l], X[row(X_STEP, l)]
        left = pushes.lasts[l] - steps
        X[row(PULSE_LEFT, l)] = left
        if left <= 0:
            # What a lane goes on with must not grow: denormal numbers would slow down all.
            for name in range(PIECE, PULSE_LEFT):
                X[row(name, l)] = 0.0
            continue
        end, x = bounds[pulse + 1], step * steps
        k = curve.at(pieces, max(pushes.piece[l], bounds[pulse]), end, x)
        if k != pushes.piece[l]:
            pushes.piece[l] = k
            for column in range(curve.COLUMNS):
                X[row(PIECE + column, l)] = pieces[k, column]
            X[row(TURN, l)] = 4 * sine(X[row(TURNS, l)] * step / 2) ** 2
        X[row(PULSE, l)] = x
        joins = k + 1 < end and pieces[k + 1, curve.BEGIN] < x + BLOCK * step
        joins |= steps == 0 and jumps[pulse, 0] != 0
        joins |= left <= BLOCK + 1 and jumps[pulse, 1] != 0
        joined |= joins << l
    go_on(X, shocks)
    for l in range(LANES):
        if joined >> l & 1:
            set_out_joined(X, shocks, l, pushes, pulses)


@compiled
def set_out_joined(X, shocks, l, pushes, pulses):
    """The same of a lane in whose block pieces join, or the pulse jumps."""
    pieces, bounds, jumps = pulses
    pulse, k, step = pushes.pulse[l], pushes.piece[l], X[row(X_STEP, l)]
    for i in range(BLOCK):
        x = step * (pushes.steps[l] + i)
        k = curve.at(pieces, k, bounds[pulse + 1], x)
        sample = curve.sample(pieces, k, (jumps[pulse, 0], jumps[pulse, 1]), x, step)
        shocks[i * LANES + l] = X[row(AMPLITUDE, l)] * sample


@compiled
def go_on(X, shocks):
    """Follow each lane's piece through a block, from x = PULSE on.

    By the recurrence of a sine of phase p a step: v+ - 2 v + v- = 4 sin^2(p/2) (centre - v).
    """
    widen_vectors()
    for l in range(LANES):
        s, turns = X[row(PULSE, l)] - X[row(BEGIN, l)], X[row(TURNS, l)]
        slope, lift, swing = X[row(SLOPE, l)], X[row(LIFT, l)], X[row(SWING, l)]
        X[row(PULSE, l)] = curve.form(X[row(START, l)], slope, turns, lift, swing, s)
        last = curve.increment(slope, turns, lift, swing, s, X[row(X_STEP, l)])
        X[row(PULSE_STEP, l)] = last
    for step in range(BLOCK):
        for l in range(LANES):
            pulse, left = X[row(PULSE, l)], X[row(PULSE_LEFT, l)]
            bend = X[row(START, l)] + X[row(LIFT, l)] - pulse
            pulse_step = fma(X[row(TURN, l)], bend, X[row(PULSE_STEP, l)])
            X[row(PULSE_STEP, l)] = pulse_step
            X[row(PULSE, l)] = pulse + pulse_step
            X[row(PULSE_LEFT, l)] = left - 1.0
            a = X[row(AMPLITUDE, l)] * pulse if left > 0.0 else 0.0
            shocks[step * LANES + l] = a


@compiled
def energies(before, after, X, shape, l):
    """Energy of the beam, of the mass on its spring, and of the contact; and w; times dt^2.

    At the instant of the state `before`, one step ahead of `after`, so that velocities are centred.
    """
    modes = len(shape)
    quadratic, beam, w = 0.0, 0.0, 0.0
    for i in range(modes):
        p = before[at(P, i, modes, l)]
        slope = 2 * X[at(SLOPE_START, i, modes, l)]
        for j in range(modes):
            slope += X[at(GEOMETRIC + i, j, modes, l)] * before[at(P, j, modes, l)]
        quadratic += p * slope
        w += X[at(MIDPOINT, i, modes, l)] * p
        velocity = (before[at(P_STEP, i, modes, l)] + after[at(P_STEP, i, modes, l)]) / 2
        beam += velocity**2 / 2 + X[at(STIFFNESS, i, modes, l)] * p**2 / 2
    beam += X[row(AXIAL, l)] * quadratic**2 / 4
    y = before[row(Y, l)]
    velocity = (before[row(Y_STEP, l)] + after[row(Y_STEP, l)]) / 2
    mass = X[row(MASS, l)] * velocity**2 / 2 + X[row(SPRING, l)] * y**2 / 2
    overlap = max(0.0, w - y - X[row(CLEARANCE, l)])
    contact = X[row(CONTACT, l)] * overlap**2 / 2
    return beam, mass, contact, w


@compiled
def whole_step_ledger(before, after, X, shape, l, drag):
    """What `energies` returns, and energy + losses - work of the pulse, times dt^2.

    By the trapezoidal rule; drag: C dt.
    """
    beam, mass, contact, w = energies(before, after, X, shape, l)
    work = (before[row(WORK, l)] + after[row(WORK, l)]) / 4
    swept = drag * (before[row(SWEPT, l)] + after[row(SWEPT, l)]) / 8
    beam_swept = before[row(BEAM_SWEPT, l)] + after[row(BEAM_SWEPT, l)]
    kept = beam + mass + contact + swept + X[row(BEAM_DAMPING, l)] * beam_swept / 8
    return beam, mass, contact, w, kept - work


@compiled
def conserved_energies(X, shape, l):
    """What `advance_conserving` conserves, of the beam, the mass and the contact; and w.

    At the last half step, times dt^2: products of two instants stand for squares.
    """
    modes, w, beam = len(shape), 0.0, X[row(AXIAL, l)] * X[row(STRETCH, l)] ** 2 / 4
    for i in range(modes):
        d, p = X[at(P_STEP, i, modes, l)], X[at(P, i, modes, l)]
        beam += d * d / 2 + X[at(STIFFNESS, i, modes, l)] * p * (p - d) / 2
        w += X[at(MIDPOINT, i, modes, l)] * (p - d / 2)
    d, y = X[row(Y_STEP, l)], X[row(Y, l)]
    middle = y - d / 2
    mass = X[row(MASS, l)] * d * d / 2 + X[row(SPRING, l)] * middle * middle / 2
    return beam, mass, X[row(CONTACT, l)] * max(0.0, X[row(GAP, l)]) ** 2 / 2, w


@compiled
def conserved_ledger(X, shape, l, drag):
    """What `conserved_energies` returns, and energy + losses - work of the pulse, times dt^2.

    Up to the last half step; drag: C dt.
    """
    beam, mass, contact, w = conserved_energies(X, shape, l)
    swept = drag * X[row(SWEPT, l)] + X[row(BEAM_DAMPING, l)] * X[row(BEAM_SWEPT, l)]
    energy = beam + mass + contact
    return beam, mass, contact, w, energy + swept / 4 - X[row(WORK, l)] / 2


@compiled
def go(X, shape, explicit, conserving, shocks, first, steps):
    """Advance every lane by the scheme that is not None: of the other nothing is compiled."""
    if explicit is not None:
        advance(X, shape, shocks, first, steps)
    if conserving is not None:
        advance_conserving(X, shape, shocks, first, steps)


@compiled
def ledger(before, after, X, shape, explicit, conserving, l, drag):
    """Energies and residual of the scheme that is not None."""
    found = 0.0, 0.0, 0.0, 0.0, 0.0
    if explicit is not None:
        found = whole_step_ledger(before, after, X, shape, l, drag)
    if conserving is not None:
        found = conserved_ledger(X, shape, l, drag)
    return found


@compiled
def copy(of, into, first, end):
    """Copy a stretch of an array into another; slices would take seconds more to compile."""
    for i in range(first, end):
        into[i] = of[i]


@compiled
def proven_well(X, l, beam, mass, contact, w, margin):
    """The well (1 or 2) that the beam can never leave without a shock, or 0 if that is open.

    Energy only falls after the pulse. 1 or 2: all of it is below the barrier. 2: the beam's alone
    is, and the mass on its spring cannot swing as low as the beam can rise, the saddle.
    """
    barrier, saddle = X[row(BARRIER, l)], X[row(SADDLE, l)]
    if beam + mass + contact + margin < barrier:
        return 1 if w > saddle else 2
    lowest_mass = -np.sqrt(2 * (mass + margin) / X[row(SPRING, l)])
    if beam + margin < barrier and w < saddle < lowest_mass + X[row(CLEARANCE, l)]:
        return 2
    return 0


@compiled
def snap_time(X, l, dt):
    """Time at which w passed the target, linear between the two instants around it."""
    before, after = X[row(W_BEFORE, l)], X[row(W, l)]
    fraction = (before - X[row(TARGET, l)]) / (before - after)
    return (X[row(COUNT, l)] - 2 + fraction) * dt


@compiled
def follow_all(X, shape, explicit, conserving, devices, pulses, cells, ends_at, tolerance, facts):
    """Follow every cell until its well is proven or t_end is past, refilling each free lane.

    A proof is looked for after the pulse. The explicit scheme's energy wobbles with modes near the
    step limit, and one look may miss it: there a proof must hold at two, by a margin over the
    largest residual of all of them. It is judged at the look before a snap that ends it, and
    believed only if its energy closes within GUARD at its very end, too, as it may have blown up
    meanwhile.

    X: work array; devices: (n_devices, coefficients)
    explicit, conserving: None for the scheme that is not taken
    cells: device_of, pulse_of, amplitude (um/us^2), f0 (1/us), damping (C, uN us/um), t_end and dt
        (us); (cells,)
    pulses: as in `numerics.pieces`, over x = f0 t: the pieces of all, (pieces, 6), where each one's
        begin and end, (pulses + 1,), and what it begins and ends with, (pulses, 2)
    ends_at: whether a cell also ends at its snap, and at the first look after its pulse
    tolerance: of the ledger, over the gross work of the pulse; a run that exceeds it is given up
    facts, modified in place: t_snap, t_settled (us, NaN if not seen), well (1 or 2, the side of
        the saddle at the end; 0 where the run ended before its pulse or at its snap), energy_error
        (residual of the energy ledger over the gross work of the pulse, not finite after a
        blow-up), well_share (share of the mass's last swing spent on that side, 1 if proven; NaN
        for well 0), pulse_work (of the whole pulse, pJ; NaN if the run ended before); (cells,)
    """
    widen_vectors()
    device_of, pulse_of, amplitude, f0, damping, t_end, dt = cells
    stop_at_snap, stop_after_pulse = ends_at
    t_snap, t_settled, well, energy_error, well_share, pulse_work = facts
    cell_in = np.full(LANES, -1)
    pushes, shocks, pushed = no_pushes(), np.zeros(BLOCK * LANES), False
    steps, lasts = pushes.steps, pushes.lasts
    worst, found_before = np.zeros(LANES), np.zeros(LANES, np.int64)
    last_swing, since, beyond = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    next_cell, running = 0, 0
    X[:] = 0.0
    state = STATE * LANES, (VECTORS + SCRATCH * len(shape)) * LANES
    before, after = X.copy(), X.copy()
    last_before, last_after = X.copy(), X.copy()
    while next_cell < t_snap.size or running > 0:
        pushing = False
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < t_snap.size:
                device = device_of[next_cell]
                load = damping[next_cell], amplitude[next_cell]
                fill(X, shape, conserving is not None, l, devices[device], *load, dt[next_cell])
                push(X, l, pushes, pulses, pulse_of[next_cell], f0[next_cell] * dt[next_cell])
                cell_in[l] = next_cell
                worst[l], found_before[l] = 0.0, 0
                swing = 2 * np.pi * np.sqrt(X[row(MASS, l)] / X[row(SPRING, l)])
                last_swing[l] = t_end[next_cell] / dt[next_cell] - swing
                since[l], beyond[l] = 0.0, 0.0
                next_cell += 1
                running += 1
            pushing |= steps[l] < lasts[l]
        if pushing or pushed:
            set_out(X, shocks, pushes, pulses)
        pushed = pushing
        before, last_before = last_before, before
        after, last_after = last_after, after
        if explicit is not None:
            advance(X, shape, shocks, 0, BLOCK - 1)
            copy(X, before, *state)
            advance(X, shape, shocks, BLOCK - 1, 1)
            copy(X, after, *state)
        if conserving is not None:
            advance_conserving(X, shape, shocks, 0, BLOCK)
        for l in range(LANES):
            cell = cell_in[l]
            if cell < 0:
                continue
            steps[l] += BLOCK
            if steps[l] <= last_swing[l]:
                since[l], beyond[l] = steps[l], X[row(BEYOND, l)]
            step = dt[cell]
            drag = damping[cell] * step
            snapped = X[row(W, l)] <= X[row(TARGET, l)]
            in_pulse = steps[l] - 1 < lasts[l]
            ended = steps[l] * step > t_end[cell] or not np.isfinite(X[row(Y, l)])
            ended |= snapped and stop_at_snap
            ended |= stop_after_pulse and not in_pulse
            if in_pulse and not ended:
                continue

            at_snap = snapped and stop_at_snap and steps[l] > BLOCK
            ends = (last_before, last_after) if at_snap else (before, after)
            found_by = ledger(*ends, X, shape, explicit, conserving, l, drag)
            beam, mass, contact, w, residual = found_by
            gross_work = X[row(GROSS_WORK, l)] / 2
            scale = 1 / gross_work if gross_work > 0 else 1.0
            found = 0
            if not in_pulse:
                worst[l] = max(worst[l], abs(residual))
                found = proven_well(X, l, beam, mass, contact, w, MARGIN * worst[l])
                ended |= not abs(residual) * scale <= OPENED * tolerance
            proven = found == 1 or (found == 2 and snapped)
            if explicit is not None:
                proven &= found == found_before[l]
                found_before[l] = found
            if not ended and not proven:
                continue
            if explicit is not None:
                guarded = whole_step_ledger(before, after, X, shape, l, drag)[4]
                if not abs(guarded) * scale <= GUARD:
                    residual = guarded
            energy_error[cell] = abs(residual) * scale
            is_whole = steps[l] >= lasts[l]
            pulse_work[cell] = X[row(WORK, l)] / (2 * step**2) if is_whole else np.nan
            t_snap[cell] = snap_time(X, l, step) if snapped else np.nan
            t_settled[cell] = (steps[l] - 1) * step if proven else np.nan
            share = (X[row(BEYOND, l)] - beyond[l]) / (steps[l] - since[l])
            is_second = found == 2 if proven else not w > X[row(SADDLE, l)]
            well[cell] = 2 if is_second else 1
            well_share[cell] = 1.0 if proven else share if is_second else 1 - share
            if in_pulse or (snapped and stop_at_snap):
                well[cell], well_share[cell] = 0, np.nan
            cell_in[l], lasts[l] = -1, 0
            running -= 1
            X[l::LANES] = 0.0


@inlined
def half_step_midpoint(X, shape, l):
    """w(L/2) from rest at the last half step, contact within the midpoint's own stiffness."""
    w = 0.0
    for i in range(len(shape)):
        d, p = X[at(P_STEP, i, len(shape), l)], X[at(P, i, len(shape), l)]
        w += X[at(MIDPOINT, i, len(shape), l)] * (p - d / 2)
    gap = X[row(GAP, l)]
    force = X[row(CONTACT, l)] * (gap if gap > 0.0 else 0.0)
    return w - X[row(RESIDUAL, l)] * force


@compiled
def keep_range(w_range, bin, l, low, high):
    """Set the least and greatest w of a bin, unless it lies before the first or after the last."""
    if 0 <= bin < w_range.shape[1]:
        w_range[0, bin, l], w_range[1, bin, l] = low, high


@compiled
def trace_all(X, shape, explicit, conserving, devices, dt, pulses, cells, w_range, instants):
    """Follow up to LANES cells as `follow_all` does, bit for bit, and keep their motion in bins.

    At instants; the conserving scheme's half way between two, as its energies.

    X: zeros; devices: each cell's row of coefficients, with target -inf, so that row W is never
        latched; dt: each cell's, us; explicit, conserving: as in `follow_all`
    pulses: as in `follow_all`
    cells: pulse_of, amplitude, f0 and damping as in `follow_all`, and width, steps of one bin, a
        multiple of SAMPLE; (cells,)
    modified in place: w_range, least and greatest w(L/2) from rest in each bin, (2, bins, cells);
        instants, at each bin's start y, all energy and the beam's (pJ), (3, bins, cells)
    """
    widen_vectors()
    pulse_of, amplitude, f0, damping, width = cells
    n_cells, shocks = width.size, np.zeros(BLOCK * LANES)
    pushes = no_pushes()
    for l in range(n_cells):
        fill(X, shape, conserving is not None, l, devices[l], damping[l], amplitude[l], dt[l])
        push(X, l, pushes, pulses, pulse_of[l], f0[l] * dt[l])
    before = X.copy()
    bin, begin = np.full(LANES, -1), np.zeros(LANES, np.int64)
    low, high = np.empty(LANES), np.empty(LANES)
    bins, first, end = w_range.shape[1], STATE * LANES, (VECTORS + SCRATCH * len(shape)) * LANES
    for step in range(0, bins * width.max(), SAMPLE):
        in_block = step % BLOCK
        if in_block == 0:
            pushes.steps[:] = step
            set_out(X, shocks, pushes, pulses)
        begins = False
        for l in range(n_cells):
            if begin[l] == step:
                begins = True
                before[l + first : end : LANES] = X[l + first : end : LANES]
        go(X, shape, explicit, conserving, shocks, in_block, 1)
        for l in range(n_cells if begins else 0):
            if begin[l] != step:
                continue
            keep_range(w_range, bin[l], l, low[l], high[l])
            bin[l] += 1
            begin[l] += width[l]
            low[l], high[l] = np.inf, -np.inf
            if bin[l] >= bins:
                continue
            y, beam, mass, contact = before[row(Y, l)], 0.0, 0.0, 0.0
            if explicit is not None:
                beam, mass, contact, _ = energies(before, X, X, shape, l)
            if conserving is not None:
                y += X[row(Y_STEP, l)] / 2
                beam, mass, contact, _ = conserved_energies(X, shape, l)
            instants[0, bin[l], l] = y
            instants[1, bin[l], l] = (beam + mass + contact) / dt[l] ** 2
            instants[2, bin[l], l] = beam / dt[l] ** 2
        for l in range(LANES):
            w = X[row(W, l)]
            if conserving is not None:
                w = half_step_midpoint(X, shape, l)
            low[l] = w if w < low[l] else low[l]
            high[l] = w if w > high[l] else high[l]
        go(X, shape, explicit, conserving, shocks, in_block + 1, SAMPLE - 1)
    for l in range(n_cells):
        keep_range(w_range, bin[l], l, low[l], high[l])

"""A user's laws in a step: damping by a function, contact and restoring force by tables.

See docs/theory.md, "A user's own laws".
"""

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import int64, types
from numba.extending import intrinsic

from ...numerics.kernels import compiled, fma, inlined, widen_vectors
from . import rows as R
from .access import numbers
from .rows import LANES, Rows
from .tables import CELLS, FINE

CONTACT, FORCE = range(2)
"""The laws in tables, each with a row of its own after that of a name."""
SAME = 1e-6
"""Change of an overlap, over the reach, below which the force is the mean of both ends."""
CLOSE = 1e-11
"""Error of an overlap, over the reach, at which the root of a step is found."""
PASSES = 40
"""Most passes for a root; almost all take three."""
STILL = 1e-9
"""Velocity, um/us, that stands for 0 in the secant of a law of damping."""
SAMPLES = 16
"""Velocities and places at which a damping is asked whether it drives."""


class LaneLaws(NamedTuple):
    """A user's laws, as kernels take them; a kernel without any takes None.

    damping: address of a function of `asked`, or 0 where the device's damper acts
    asked: C, velocity, place and drag, in rows of LANES numbers, and a row that starts with 1 after
        an error of the function
    tabled: whether contact and force are in `tables`, (tables, CELLS, 4), from `potentials`
    holds: whether there is a law of the force, in place of bending and stretch
    """

    damping: int
    asked: np.ndarray
    tabled: bool
    holds: bool
    tables: np.ndarray


@intrinsic
def ask(context, function, array):
    """Call the function at an address with the address of an array's first element."""

    def build(context, builder, signature, arguments):
        data = context.make_array(signature.args[1])(context, builder, arguments[1]).data
        kind = ir.FunctionType(ir.VoidType(), [data.type]).as_pointer()
        builder.call(builder.inttoptr(arguments[0], kind), [data])
        return context.get_dummy_value()

    return types.none(int64, array), build


@inlined
def locate(X: Rows, l: int, law: int, x: float):
    """Set the place of x in cells from the left end of a table, and cells per um there.

    law: CONTACT or FORCE; x: up to the reach on either side
    The cells are even in x / (FINE reach + |x|).
    """
    reach = X[R.REACH, l]
    inside = min(max(x, -reach), reach)
    fine = FINE * reach if reach > 0.0 else 1.0  # an empty lane has none
    inverse = 1 / (fine + abs(inside))
    per = (1 + FINE) * (CELLS / 2)
    X[R.PER + law, l] = per * fine * inverse * inverse
    X[R.PLACE + law, l] = per * (inside * inverse) + CELLS / 2


@inlined
def fetch(X: Rows, l: int, law: int, tables: np.ndarray):
    """Fetch the cubic of the place of a lane; in a loop of its own, which is not vectorised."""
    place = X[R.PLACE + law, l]
    place = place if place > 0.0 else 0.0  # or NaN
    cell = np.int64(place if place < CELLS - 1 else CELLS - 1)
    X[R.SHARE + law, l] = place - cell
    for i in range(4):
        X[R.CUBIC + 4 * law + i, l] = tables[np.int64(X[R.TABLE + law, l]), cell, i]


@inlined
def potential(X: Rows, l: int, law: int, x: float):
    """Return energy and slope of a law at x, times dt^2, by the cubic that was fetched.

    Beyond the reach the slope is constant.
    """
    square, t, reach = X[R.DT, l] * X[R.DT, l], X[R.SHARE + law, l], X[R.REACH, l]
    i = R.CUBIC + 4 * law
    a, b, c, d = X[i, l], X[i + 1, l], X[i + 2, l], X[i + 3, l]
    force = square * X[R.PER + law, l] * fma(fma(3 * d, t, 2 * c), t, b)
    energy = square * fma(fma(fma(d, t, c), t, b), t, a)
    return energy + force * (x - min(max(x, -reach), reach)), force


@inlined
def begin_laws(X: Rows, l: int, laws: LaneLaws, w: float):
    """Set the rows of laws in lane l; w: w(L/2) from rest, um."""
    X[R.YIELDS, l] = X[R.COMPLIANCE, l] - X[R.B, l] / 2
    if laws.tabled:
        X[R.CONTACT, l] = X[R.HALF_CONTACT, l] = 0.0
        begin_law(X, l, CONTACT, laws.tables, X[R.OVERLAP, l])
    if laws.holds:
        begin_law(X, l, FORCE, laws.tables, w)


@inlined
def begin_law(X: Rows, l: int, law: int, tables: np.ndarray, x: float):
    """Set energy and force of a law at x, and half the slope of the force."""
    h = SAME * X[R.REACH, l]
    X[R.GUESS + law, l], X[R.RISE + law, l] = x, 0.0
    for side in (-1.0, 1.0, 0.0):
        locate(X, l, law, x + side * h)
        fetch(X, l, law, tables)
        X[R.ENERGY + law, l], X[R.PUSH + law, l] = potential(X, l, law, x + side * h)
        X[R.RISE + law, l] += side * X[R.PUSH + law, l] / (4 * h)


@compiled
def damp(work: np.ndarray, laws: LaneLaws) -> None:
    """Set the damper of each lane to D / v of the law at the velocity v that is ahead.

    v = (3 d_y - d_y before) / 2 dt is right to second order, and the loss is positive in any case.
    """
    widen_vectors()
    X, asked = numbers(work), laws.asked
    for l in range(LANES):
        runs = X[R.DT, l] > 0.0  # an empty lane has no C
        v = (1.5 * X[R.DY, l] - 0.5 * X[R.DY_BEFORE, l]) / (X[R.DT, l] if runs else 1.0)
        asked[l], asked[LANES + l] = X[R.C, l] if runs else 1.0, v if abs(v) > STILL else STILL
        asked[2 * LANES + l] = X[R.Y, l]
    ask(laws.damping, asked)
    for l in range(LANES):
        drag = X[R.DT, l] / 2 * asked[3 * LANES + l] / asked[LANES + l]
        mass, held = X[R.M, l] + X[R.K, l] / 4, X[R.HELD, l] > 0.0
        B = 1 / (mass + drag) if mass > 0.0 else 0.0
        X[R.B, l], X[R.HELD, l] = 0.0 if held else B, B if held else 0.0
        X[R.KEEP, l], X[R.DRAG, l] = (mass - drag) * B, drag
        X[R.COMPLIANCE, l] = X[R.YIELDS, l] + X[R.B, l] / 2
        X[R.DY_BEFORE, l] = X[R.DY, l]
        # A law that drives the mass leaves nothing to prove.
        X[R.WORST, l] = np.inf if drag < 0.0 else X[R.WORST, l]


@compiled
def drives(laws: LaneLaws, damping: float, speed: float, travel: float):
    """Return whether a law of damping drives a mass within a speed, um/us, and a travel, um."""
    asked = np.zeros(5 * LANES)
    for i in range(SAMPLES):
        for l in range(LANES):
            share = (2 * l + 1) / LANES - 1
            asked[l], asked[LANES + l] = damping, speed * share * abs(share)
            asked[2 * LANES + l] = travel * (2 * i / (SAMPLES - 1) - 1)
        ask(laws.damping, asked)
        for l in range(LANES):
            if not asked[LANES + l] * asked[3 * LANES + l] >= 0.0:
                return True
    return False


@inlined
def set_out(X: Rows, l: int, law: int, guess: float):
    """Keep what is known at the last half step, and guess x at the next one."""
    X[R.FROM + law, l] = X[R.GUESS + law, l] - X[R.MISS + law, l]
    X[R.ENERGY_BEFORE + law, l] = X[R.ENERGY + law, l]
    X[R.PUSH_BEFORE + law, l] = X[R.PUSH + law, l]
    X[R.GUESS + law, l] = guess
    locate(X, l, law, guess)


@inlined
def mean_force(X: Rows, l: int, law: int):
    """Return the mean of a law from the last half step to the guess of the next one.

    Sets energy and force there, and RISE, the slope of the mean, which is kept if little has moved.
    """
    x, rise = X[R.GUESS + law, l], X[R.RISE + law, l]
    energy, force = potential(X, l, law, x)
    moved = x - X[R.FROM + law, l]
    far = abs(moved) > SAME * X[R.REACH, l]
    inverse = 1 / (moved if far else 1.0)
    gain, both = energy - X[R.ENERGY_BEFORE + law, l], force + X[R.PUSH_BEFORE + law, l]
    mean = gain * inverse if far else both / 2
    X[R.RISE + law, l] = (force - mean) * inverse if far else rise
    X[R.ENERGY + law, l], X[R.PUSH + law, l] = energy, force
    return mean


@inlined
def miss(X: Rows, l: int, law: int, error: float):
    """Set the energy at the next half step, whose x is the guess less an error."""
    X[R.ENERGY + law, l] = fma(-X[R.PUSH + law, l], error, X[R.ENERGY + law, l])
    X[R.MISS + law, l] = error


@inlined
def any_far(X: Rows):
    """Return whether the guess of any lane is far from its root."""
    far = False
    for l in range(LANES):
        far |= X[R.FAR, l] > 0.0
    return far


@compiled
def touch_by_law(work: np.ndarray, laws: LaneLaws):
    """Set P of all lanes, the mean of the law over the step, by the root of x + beta P(x) = F.

    Newton's method in a bracket: if P never falls, the root is at most g away from x, with
    g = x + beta P - F. It may fall a little, as the bracket is twice as wide.
    """
    widen_vectors()
    X = numbers(work)
    for l in range(LANES):
        # As if P rose evenly, by what it did last.
        steep = max(0.5, fma(X[R.BETA, l], X[R.RISE, l], 1.0))
        g = X[R.OVERLAP, l] - fma(-X[R.BETA, l], X[R.PUSH, l], X[R.OVERLAP_FREE, l])
        set_out(X, l, CONTACT, X[R.OVERLAP, l] - g / steep)
        X[R.LOW, l], X[R.HIGH, l] = -np.inf, np.inf
    for _ in range(PASSES):
        for l in range(LANES):
            fetch(X, l, CONTACT, laws.tables)
        improve_overlaps(X)
        if not any_far(X):
            break


@inlined
def improve_overlaps(X: Rows):
    """Improve the guesses of overlaps that are far from their roots."""
    for l in range(LANES):
        x, beta, reach, P = X[R.GUESS, l], X[R.BETA, l], X[R.REACH, l], mean_force(X, l, CONTACT)
        g = fma(beta, P, x - X[R.OVERLAP_FREE, l])
        close = not abs(g) > CLOSE * reach
        low = max(X[R.LOW, l], min(x, x - 2 * g))
        high = min(X[R.HIGH, l], max(x, x - 2 * g))
        ahead = min(max(x - g / max(0.5, fma(beta, X[R.RISE, l], 1.0)), low), high)
        X[R.GUESS, l] = guess = x if close else ahead
        locate(X, l, CONTACT, guess)
        miss(X, l, CONTACT, g)
        X[R.LOW, l], X[R.HIGH, l] = low, high
        X[R.FORCE, l], X[R.FAR, l] = P, 0.0 if close else 1.0


@compiled
def hold_by_law(work: np.ndarray, laws: LaneLaws):
    """Set P of all lanes, and R, the mean of the law of the force, which acts on the beam alone.

    Newton's method for overlap and midpoint, x + beta P + c R = F and w + c (P + R) = G, with the
    compliance c of the beam.
    """
    widen_vectors()
    X = numbers(work)
    for l in range(LANES):
        P, R_, c = X[R.PUSH, l], X[R.PUSH + FORCE, l], X[R.YIELDS, l]
        X[R.FREE, l] = X[R.OVERLAP_FREE, l] + X[R.Y, l] + X[R.Z0, l] + X[R.DY_FREE, l] / 2
        set_out(X, l, CONTACT, fma(-X[R.BETA, l], P, fma(-c, R_, X[R.OVERLAP_FREE, l])))
        set_out(X, l, FORCE, fma(-c, P + R_, X[R.FREE, l]))
    for i in range(PASSES):
        for l in range(LANES):
            fetch(X, l, CONTACT, laws.tables)
            fetch(X, l, FORCE, laws.tables)
        for l in range(LANES):
            improve_both(X, l, 1.0 if i < PASSES // 4 else 0.5)
        if not any_far(X):
            break
    for l in range(LANES):
        hold = X[R.HOLD, l]
        X[R.FORCE, l] += hold
        # The mass feels P alone.
        X[R.DY_FREE, l] = fma(-X[R.B, l], hold, X[R.DY_FREE, l])
        X[R.OVERLAP_FREE, l] = fma(X[R.B, l] / 2, hold, X[R.OVERLAP_FREE, l])


@inlined
def improve_both(X: Rows, l: int, share: float):
    """Improve the guesses of overlap and midpoint of a lane by a share of Newton's step."""
    x, w, beta, c = X[R.GUESS, l], X[R.GUESS + FORCE, l], X[R.BETA, l], X[R.YIELDS, l]
    P, hold = mean_force(X, l, CONTACT), mean_force(X, l, FORCE)
    p, r = X[R.RISE, l], X[R.RISE + FORCE, l]
    g = fma(beta, P, fma(c, hold, x - X[R.OVERLAP_FREE, l]))
    h = fma(c, P + hold, w - X[R.FREE, l])
    a, d = fma(beta, p, 1.0), fma(c, r, 1.0)
    by = share / max(0.25, fma(a, d, -c * c * p * r))
    close = not max(abs(g), abs(h)) > CLOSE * X[R.REACH, l]
    by = 0.0 if close else by
    X[R.GUESS, l] = x = fma(-by, fma(g, d, -h * c * r), x)
    X[R.GUESS + FORCE, l] = w = fma(-by, fma(h, a, -g * c * p), w)
    locate(X, l, CONTACT, x)
    locate(X, l, FORCE, w)
    X[R.FORCE, l], X[R.HOLD, l], X[R.FAR, l] = P, hold, 0.0 if close else 1.0
    miss(X, l, CONTACT, g)
    miss(X, l, FORCE, h)


@inlined
def dissipate(X: Rows):
    """Take the loss of the dampers in this step, which the device's dampers would not have."""
    for l in range(LANES):
        X[R.LOST, l] = fma(X[R.DRAG, l] / 2, X[R.SWEPT, l], X[R.LOST, l])
        X[R.SWEPT, l] = 0.0

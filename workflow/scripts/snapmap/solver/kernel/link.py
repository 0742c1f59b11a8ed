"""The weak link: a spring that the beam's midpoint meets on its way, up to its strength.

See docs/theory.md, "Weak link". Its stored energy is V(s) = k/2 <s>^2 of its compression s; from
the strength on it stays, lost. F = (V(s+) - V(s-)) / (s+ - s-).
"""

import numpy as np

from ...numerics.kernels import compiled, inlined
from . import rows as R
from .rows import LANES, numbers, vectors

ROUNDS = 100
"""Most of a root's search; it takes some ten."""
CLOSE = 4e-16
"""Of the largest length at hand: so closely the compression is found."""


@compiled
def has_links(work):
    """Whether the link of any lane is whole."""
    X, any_lane = numbers(work), False
    for l in range(LANES):
        any_lane |= X[R.LINK, l] > 0.0
    return any_lane


@compiled
def meet_links(work, shape):
    """After the contacts of a step: take the forces of links into it, in its free parts."""
    modes, met = len(shape), False
    X, V = numbers(work), vectors(work, modes)
    for l in range(LANES):
        near(X, V, modes, l)
    for l in range(LANES):
        met |= (X[R.LINK, l] > 0.0) & (max(X[R.LINK_BEFORE, l], X[R.LINK_FREE, l]) > 0.0)
    if met:
        for l in range(LANES):
            if X[R.LINK, l] > 0.0 and max(X[R.LINK_BEFORE, l], X[R.LINK_FREE, l]) > 0.0:
                load_link(X, V, modes, l)


@inlined
def near(X, V, modes, l):
    """The compression at the last half step, and at the next one if the link gave no force."""
    before, free = 0.0, 0.0
    for i in range(modes):
        before += V[R.E, i, l] * V[R.D, i, l]
        free += V[R.E, i, l] * V[R.D_FREE, i, l]
    free -= 2 * X[R.GAMMA, l] * X[R.EU, l] * X[R.Q_FREE, l] * X[R.INVERSE, l]
    reached = X[R.LINK_AT, l] - X[R.EP, l]
    X[R.LINK_BEFORE, l] = reached + before / 2
    X[R.LINK_FREE, l] = reached - free / 2 + yielding(X, l) * X[R.FORCE, l]


@inlined
def yielding(X, l):
    """By how much a force moves the midpoint at the next half step."""
    return X[R.BETA, l] - X[R.B, l] / 2


@inlined
def load_link(X, V, modes, l):
    """Find the link's force F and the contact's, P; the step goes on with P - F on the beam."""
    before, free, travel = X[R.LINK_BEFORE, l], X[R.LINK_FREE, l], X[R.LINK_TRAVEL, l]
    alone = X[R.FORCE, l]
    lowest = min(before, free - yielding(X, l) * X[R.LINK, l] * before) if before > 0.0 else 0.0
    breaks = free >= travel and too_far(X, l, alone, travel) <= 0.0
    ends = (travel, free) if breaks else (lowest, min(travel, free))
    s = root(X, l, alone, *ends)
    F = force(X, l, s)
    P = contact(X, l, F)
    X[R.FORCE, l] = P - F
    X[R.DY_FREE, l] += X[R.B, l] * F
    X[R.OVERLAP_FREE, l] -= X[R.B, l] * F / 2
    if breaks:
        share = (travel - before) / (s - before) if s > before else 0.0
        X[R.LEFT, l] = kinetic(X, V, modes, l, share)
        X[R.LOST, l] += X[R.LINK, l] * travel * travel / 2
        X[R.LINK, l] = 0.0
        # As if latched between two instants that were these half steps.
        at = X[R.LINK_AT, l]
        X[R.TARGET, l], X[R.W_BEFORE, l], X[R.W, l] = at - travel, at - before, at - s
        X[R.COUNT, l] += 1.5


@inlined
def force(X, l, s):
    """F of a compression s at the next half step."""
    before = X[R.LINK_BEFORE, l]
    begin, end = max(0.0, before), max(0.0, min(s, X[R.LINK_TRAVEL, l]))
    if begin == before and end == s:
        return X[R.LINK, l] * (begin + end) / 2
    return X[R.LINK, l] * (end - begin) * (end + begin) / (2 * (s - before))


@inlined
def contact(X, l, F):
    """P, where the link gives F; as `touch` and `switch_contacts` have it where it gives none."""
    m, beta = X[R.OVERLAP, l], X[R.BETA, l]
    ahead = X[R.OVERLAP_FREE, l] + yielding(X, l) * F
    h = X[R.HALF_CONTACT, l] * beta
    if m <= 0.0 and ahead <= 0.0:
        return 0.0
    if m >= 0.0 and h * m <= ahead:
        return X[R.HALF_CONTACT, l] * (ahead + m) / (1 + h)
    root = np.sqrt((ahead - m) ** 2 + 4 * h * m * (m if m > 0.0 else -ahead))
    x = (ahead + m - root) / 2 if m > 0.0 else (ahead + m + root) / (2 * (1 + h))
    return (ahead - x) / beta


@inlined
def too_far(X, l, alone, s):
    """By how much s is beyond the compression to which its own force leads; it grows with s."""
    F = force(X, l, s)
    gain = contact(X, l, F) - alone - F
    return s - X[R.LINK_FREE, l] - yielding(X, l) * gain


@inlined
def root(X, l, alone, low, high):
    """Where `too_far` is 0, by false position that halves what stays (Illinois)."""
    under, over = too_far(X, l, alone, low), too_far(X, l, alone, high)
    close, s, side = CLOSE * (abs(low) + abs(high) + X[R.LINK_TRAVEL, l]), high, 0
    if over <= close:
        return high
    for _ in range(ROUNDS):
        s = (low * over - high * under) / (over - under)
        s = min(max(s, low), high)
        miss = too_far(X, l, alone, s)
        if abs(miss) <= close or high - low <= close:
            break
        if miss > 0.0:
            high, over = s, miss
            under, side = (under / 2 if side == 1 else under), 1
        else:
            low, under = s, miss
            over, side = (over / 2 if side == -1 else over), -1
    return s


@inlined
def kinetic(X, V, modes, l, share):
    """The beam's kinetic energy, `share` of a step after the last half step."""
    b, total = X[R.BEAM_B, l], 0.0
    r = X[R.INVERSE, l] * (X[R.Q_FREE, l] - b / 2 * X[R.EU, l] * X[R.FORCE, l])
    for i in range(modes):
        before, pulled = V[R.D, i, l], 2 * X[R.GAMMA, l] * r * V[R.U, i, l]
        after = V[R.D_FREE, i, l] - pulled - b * X[R.FORCE, l] * V[R.E, i, l]
        squares = before * before + share * (after * after - before * before)
        total += (1 - V[R.KAPPA, i, l] / 4) * squares / 2
    return total

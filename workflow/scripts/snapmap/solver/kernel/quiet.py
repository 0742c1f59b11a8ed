"""Quiet time between blows: a run jumps to its end once what is left of the motion cannot matter.

With Phi the energy above the equilibrium under a constant acceleration, E = Phi + kinetic energy,
the damping G of each coordinate per its mass, and z from the equilibrium, let

    L = E + e (z.z' + z.G z/2),     e = min(G)/2.

Where Phi is convex, z.grad Phi >= Phi, and L' <= -e E. With w^2 the least stiffness per mass of a
coordinate, E/2 <= L <= c E, c = 1 + e max(1/w + G/w^2). Hence E falls below 2 c E e^(-e t/c). Rigid
stops only take from L.
"""

import numpy as np

from ...numerics import pieces as curve
from ...numerics.kernels import called, inlined
from . import rows as R
from .access import numbers, vectors
from .pulse import BLOCK, Pulses, PulseState
from .rows import Rows, Shape

# ASSUME: at the next blow a ring does no more than its energy can: sqrt(H) grows by sqrt(m/2) times
# the integral of |a| (`solver.bounds`), so a ring of the share s of the energy that a snap needs is
# worth the share sqrt(s) of the least blow that snaps: 1e-5, a tenth of THRESHOLD_TOLERANCE.
RING = 1e-10
"""Most energy that a jump leaves out at the next blow, over the energy that a snap needs there."""
# ASSUME: up to this share of the barrier the energy around a stable equilibrium is convex. In the
# first shape it is while N < N_1, which holds up to 1 / 8 Q^2 of the barrier.
NEAR = 1e-3
"""Most energy of a run that jumps, over the energy that a snap needs."""
WAIT = 0.05
"""Largest acceleration in a wait or a flight, over the peak; a higher one belongs to a blow."""
PASSES = 8
"""Most passes of Newton's method for an equilibrium; most take two."""
EXACT = 1e-8
"""Energy that the last pass may have gained, over RING."""


@inlined
def blocks_left(X: Rows, l: int, state: PulseState, pulses: Pulses) -> int:
    """Count the blocks from now to the end of a wait or a flight in lane l; 0 outside of one.

    The block that has just ended belongs to the piece in which it began.
    """
    if X[R.TURNS, l] != 0.0 or X[R.SLOPE, l] != 0.0 or not abs(X[R.START, l]) <= WAIT:
        return 0
    pieces, bounds, _ = pulses
    following = state.piece[l] + 1
    end = 1.0 if following == bounds[state.pulse[l] + 1] else pieces[following, curve.BEGIN]
    return max(0, int(end / X[R.X_STEP, l] - state.steps[l]) // BLOCK)


@inlined
def share_left(X: Rows, V: Rows, l: int, drag: float, steps: int) -> float:
    """Bound the share of E that is left after some steps; drag: C dt."""
    rate = min(drag / X[R.M, l], X[R.ALPHA, l]) / 2
    of_mass = np.sqrt(X[R.M, l] / X[R.K, l]) + drag / X[R.K, l]
    of_beam = (1 + X[R.ALPHA, l] / np.sqrt(V[R.KAPPA, 0, l])) / np.sqrt(V[R.KAPPA, 0, l])
    c = 1 + rate * max(of_mass, of_beam)
    power = 1 + rate * steps / (64 * c)
    for _ in range(6):  # (1 + x/64)^64 is less than e^x
        power *= power
    return 2 * c / power


@called
def jump(
    work: np.ndarray, shape: Shape, l: int, blocks: int, state: PulseState, H: float, drag: float
) -> None:
    """Leave out blocks of lane l, at whose end it rests, if no more than RING would be left.

    H: energy of the lane, times dt^2; drag: C dt
    """
    modes, steps = len(shape), blocks * BLOCK
    X, V, z = numbers(work), vectors(work, modes), np.empty(modes + 1)
    z[modes] = X[R.Y, l] - X[R.DY, l] / 2
    kinetic, push = X[R.M, l] * X[R.DY, l] ** 2 / 2, -X[R.M, l] * z[modes]
    for i in range(modes):
        d = V[R.D, i, l]
        z[i] = V[R.P, i, l] - d / 2
        kinetic += (1 - V[R.KAPPA, i, l] / 4) * d * d / 2
        push -= V[R.F, i, l] * z[i]
    most = min(NEAR, RING / share_left(X, V, l, drag, steps))
    if not kinetic <= most * (X[R.BARRIER, l] - H + kinetic) or X[R.HELD, l] != 0.0:
        return
    at_rest = equilibrium(X, V, modes, l, z)
    push += X[R.M, l] * z[modes]
    for i in range(modes):
        push += V[R.F, i, l] * z[i]
    done = -X[R.A, l] * push
    lost = H + done - at_rest
    if not abs(lost) <= most * (X[R.BARRIER, l] - at_rest):
        return
    if not -X[R.STOP_TOWARD, l] <= z[modes] <= X[R.STOP_AWAY, l]:
        return
    X[R.LOST, l] += lost
    X[R.WORK, l] += 2 * done
    X[R.GROSS_WORK, l] += abs(2 * done)
    w = rest(X, V, modes, l, z)
    state.steps[l] += steps
    X[R.COUNT, l] += steps if X[R.W, l] > X[R.TARGET, l] else 0
    X[R.BEYOND, l] += steps if X[R.SIDE, l] * w < X[R.SADDLE, l] else 0


@inlined
def rest(X: Rows, V: Rows, modes: int, l: int, z: np.ndarray) -> float:
    """Put lane l at rest at z, modes and y; returns w."""
    w, X[R.Q, l] = 0.0, 0.0
    for i in range(modes):
        V[R.P, i, l], V[R.D, i, l] = z[i], 0.0
        w += V[R.E, i, l] * z[i]
        X[R.Q, l] += (V[R.SQ0, i, l] + slope(V, modes, l, i, z)) * z[i]
    X[R.Y, l], X[R.DY, l], X[R.OVERLAP, l] = z[modes], 0.0, w - z[modes] - X[R.Z0, l]
    return w


@inlined
def slope(V: Rows, modes: int, l: int, i: int, z: np.ndarray) -> float:
    """Return component i of u = S z + S q0."""
    u = V[R.SQ0, i, l]
    for j in range(modes):
        u += V[R.S + i, j, l] * z[j]
    return u


@inlined
def equilibrium(X: Rows, V: Rows, modes: int, l: int, z: np.ndarray) -> float:
    """Move z to a stable equilibrium near it under the acceleration of lane l.

    Returns its energy, times dt^2; inf if there is none.
    """
    K, net, gained = np.empty((modes + 1, modes + 1)), np.empty(modes + 1), np.inf
    for _ in range(PASSES):
        q, x, energy = 0.0, -z[modes] - X[R.Z0, l], X[R.K, l] * z[modes] ** 2 / 2
        for i in range(modes):
            V[R.U, i, l] = u = slope(V, modes, l, i, z)
            q += (u + V[R.SQ0, i, l]) * z[i]
            x += V[R.E, i, l] * z[i]
            energy += V[R.KAPPA, i, l] * z[i] ** 2 / 2
        k = X[R.CONTACT, l] if x > 0.0 else 0.0
        x = max(0.0, x)
        if gained <= EXACT * RING * X[R.BARRIER, l]:
            return energy + X[R.AXIAL, l] * q * q / 4 + k * x * x / 2
        pull = X[R.AXIAL, l] * q
        for i in range(modes + 1):
            is_mode = i < modes
            e = V[R.E, i, l] if is_mode else -1.0
            own = V[R.KAPPA, i, l] if is_mode else X[R.K, l]
            load = V[R.F, i, l] if is_mode else X[R.M, l]
            net[i] = own * z[i] + load * X[R.A, l] + e * (k * x)
            net[i] += pull * V[R.U, i, l] if is_mode else 0.0
            for j in range(i + 1):
                K[i, j] = k * e * (V[R.E, j, l] if j < modes else -1.0) + (own if i == j else 0.0)
                if is_mode:
                    stretch = 2 * X[R.AXIAL, l] * V[R.U, i, l] * V[R.U, j, l]
                    K[i, j] += pull * V[R.S + i, j, l] + stretch
        gained = newton(K, net, z)
    return np.inf


@inlined
def newton(K: np.ndarray, net: np.ndarray, z: np.ndarray) -> float:
    """Take a step of Newton's method; returns the energy that it gains, inf if K is not positive.

    K: stiffness, of which the lower half counts; net: force against which z moves; both are lost
    """
    gained = 0.0
    # K = L D L^T, row by row, and L^-1 times the net force along with it.
    for i in range(z.size):
        for j in range(i + 1):
            for h in range(j):
                K[i, j] -= K[i, h] * K[h, h] * K[j, h]
            if j < i:
                K[i, j] /= K[j, j]
                net[i] -= K[i, j] * net[j]
        if not K[i, i] > 0.0:
            return np.inf
        gained += net[i] * net[i] / (2 * K[i, i])
    for i in range(z.size - 1, -1, -1):
        net[i] /= K[i, i]
        for j in range(i + 1, z.size):
            net[i] -= K[j, i] * net[j]
        z[i] -= net[i]
    return gained

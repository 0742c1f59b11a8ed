"""Runs that record the motion, or what is seen of it: the midpoint and the largest stress."""

import numpy as np

from ...numerics.kernels import compiled, inlined, widen_vectors
from . import rows as R
from .access import numbers, vectors
from .lanes import half_step_midpoint, leave_out
from .laws import LaneLaws
from .pulse import BLOCK, Pulses, PulseState, set_out
from .rows import LANES, Rows, Shape
from .step import advance, rebound


@compiled
def keep_motion(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    state: PulseState,
    pulses: Pulses,
    before: np.ndarray,
    after: np.ndarray,
) -> None:
    """Advance all lanes by blocks, and record the state of lane 0 before and after each step.

    state, modified in place, and pulses: as in `begin_pulse`
    before, after: (steps, rows from STATE on), modified in place
    """
    widen_vectors()
    shocks = np.zeros(BLOCK * LANES)
    for first in range(0, len(before), BLOCK):
        set_out(work, shocks, state, pulses)
        for step in range(BLOCK):
            rebound(work)
            for i in range(before.shape[1]):
                before[first + step, i] = work[(R.STATE + i) * LANES]
            advance(work, shape, laws, shocks, step, 1)
            for i in range(before.shape[1]):
                after[first + step, i] = work[(R.STATE + i) * LANES]
        state.steps[:] += BLOCK


@compiled
def keep_seen(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    state: PulseState,
    pulses: Pulses,
    rows: np.ndarray,
    midpoints: np.ndarray,
    stress: np.ndarray,
) -> None:
    """Advance all lanes by blocks, and record what is seen half way through each step.

    rows: what makes stress of coordinates and contact of a lane, for each of which it is wanted
    midpoints, stress: w(L/2) from rest, um, and the largest stress, MPa, (steps, LANES), modified
        in place
    """
    widen_vectors()
    modes = len(shape)
    X, V, shocks = numbers(work), vectors(work, modes), np.zeros(BLOCK * LANES)
    for first in range(0, len(midpoints), BLOCK):
        set_out(work, shocks, state, pulses)
        for step in range(BLOCK):
            advance(work, shape, laws, shocks, step, 1)
            for l in range(LANES):
                bent = half_step_midpoint(V, modes, l)
                midpoints[first + step, l] = bent - X[R.RESIDUAL, l] * pressed(X, l)
            for l in range(len(rows)):
                stress[first + step, l] = largest_stress(X, V, modes, l, rows[l])
        state.steps[:] += BLOCK


@compiled
def leap(work: np.ndarray, shape: Shape, state: PulseState, pulses: Pulses) -> None:
    """Let lanes jump over the rest of quiet times, each once its mass has swung to and fro in it.

    Until then a weak shock may not have shown all its travel and stress.
    """
    X = numbers(work)
    for l in range(LANES):
        if state.steps[l] < state.lasts[l]:
            swing = 2 * np.pi * np.sqrt(X[R.M, l] / X[R.K, l])
            if state.steps[l] - X[R.BEGIN, l] / X[R.X_STEP, l] > swing:
                leave_out(work, shape, l, state, pulses)


@inlined
def largest_stress(X: Rows, V: Rows, modes: int, l: int, rows: np.ndarray) -> float:
    """Return the largest tensile stress of lane l half way through the step, MPa.

    rows: (PLACES + 1, modes + 2), as in `motion.stress_rows`
    """
    places = len(rows) - 1
    stretch, contact = X[R.Q, l], pressed(X, l)
    most = 0.0
    for place in range(places):
        bent = rows[place, modes + 1] - rows[place, modes] * contact
        for i in range(modes):
            p = V[R.P, i, l] - 0.5 * V[R.D, i, l]
            bent += rows[place, i] * p
        most = max(most, abs(bent))
    return most + rows[places, modes] * stretch + rows[places, modes + 1]


@inlined
def pressed(X: Rows, l: int) -> float:
    """Return the contact force at the last half step, times dt^2."""
    overlap = X[R.OVERLAP, l]
    return X[R.CONTACT, l] * (overlap if overlap > 0.0 else 0.0) + X[R.PUSH, l]

"""Runs that record the motion or the largest stress."""

import numpy as np

from ...numerics.kernels import compiled, inlined, widen_vectors
from . import rows as R
from .access import numbers, vectors
from .lanes import half_step_midpoint, load
from .laws import LaneLaws
from .pulse import BLOCK, Pulses, PulseState, begin_pulse, no_pulse, set_out
from .rows import LANES, Rows, Shape
from .step import advance, rebound


@compiled
def follow_stress(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    devices: np.ndarray,
    dt: np.ndarray,
    pulses: Pulses,
    cells: tuple[np.ndarray, ...],
    stress: np.ndarray,
    largest: np.ndarray,
) -> None:
    """Follow up to LANES cells for the largest stress, bit for bit as runs that do not jump.

    Stress is evaluated half way between two instants, where energies are known.

    work: zeros; devices: row of coefficients of each cell, with target -inf, so that w is never
        latched; dt: us, (cells,); pulses: as in `Task`
    cells: pulse, amplitude, f0 and damping as in `Task`, and number of steps; each (cells,)
    stress: rows of `motion.stress_rows` of each cell, modified in place
    largest: largest stress so far, MPa, (cells,), modified in place
    """
    widen_vectors()
    pulse, amplitude, f0, damping, steps = cells
    modes = len(shape)
    X, V = numbers(work), vectors(work, modes)
    state, shocks = no_pulse(), np.zeros(BLOCK * LANES)
    for l in range(steps.size):
        load(work, shape, laws, l, devices[l], damping[l], amplitude[l], dt[l])
        begin_pulse(work, l, state, pulses, pulse[l], f0[l] * dt[l])
    for l in range(len(stress)):
        for place in range(stress.shape[1] - 1):
            for i in range(modes):
                stress[l, place, i] *= V[R.U, i, l]
    for step in range(steps.max()):
        if step % BLOCK == 0:
            state.steps[:] = step
            set_out(work, shocks, state, pulses)
        advance(work, shape, laws, shocks, step % BLOCK, 1)
        for l in range(len(stress)):
            if step < steps[l]:
                most = largest_stress(X, V, modes, l, stress[l])
                largest[l] = max(largest[l], most)


@compiled
def keep_block(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    shocks: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
) -> None:
    """Advance by up to a block, and record the state of lane 0 before and after each step.

    before, after: (steps, rows from STATE on), modified in place
    """
    widen_vectors()
    for step in range(before.shape[0]):
        rebound(work)
        for i in range(before.shape[1]):
            before[step, i] = work[(R.STATE + i) * LANES]
        advance(work, shape, laws, shocks, step, 1)
        for i in range(before.shape[1]):
            after[step, i] = work[(R.STATE + i) * LANES]


@compiled
def keep_midpoints(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    state: PulseState,
    pulses: Pulses,
    first: int,
    midpoints: np.ndarray,
) -> None:
    """Advance all lanes, and record w(L/2) from rest half way through each step, um.

    first: number of steps done, a multiple of BLOCK
    midpoints: (steps, LANES), modified in place
    """
    widen_vectors()
    modes = len(shape)
    X, V, shocks = numbers(work), vectors(work, modes), np.zeros(BLOCK * LANES)
    for step in range(midpoints.shape[0]):
        if step % BLOCK == 0:
            state.steps[:] = first + step
            set_out(work, shocks, state, pulses)
        rebound(work)
        advance(work, shape, laws, shocks, step % BLOCK, 1)
        for l in range(LANES):
            midpoints[step, l] = seen_midpoint(X, V, modes, l)


@inlined
def seen_midpoint(X: Rows, V: Rows, modes: int, l: int) -> float:
    """Return w(L/2) from rest of lane l half way through the step, um."""
    return half_step_midpoint(V, modes, l) - X[R.RESIDUAL, l] * pressed(X, l)


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

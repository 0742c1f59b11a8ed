"""The handout's scheme with a user's own laws of damping, contact and force in its lines."""

import numpy as np
from numba import njit

from ..numerics import pieces as curve
from .laws import Law
from .ledger import CellRun, bounced, entered, keep, opened, results
from .nodal import (
    System,
    axial_force,
    beam_loss,
    contact_energy,
    dot,
    free_energy,
    mobility,
    multiply,
)
from .stops import is_held, meet_stops

PASSES = 3
"""Iterations of a step with a law of damping, for the velocity half way through it."""
SPARE = 1.44
"""Most (omega dt)^2 that a law may add: the limit is 4, and a step at 0.8 of it leaves 1.44."""


def follow(
    system: System, run: CellRun, D: Law | None, P: Law | None, F: Law | None
) -> tuple[float, float, float]:
    """March a cell as `plain_loop.follow` does, with laws in its lines.

    D, P, F: damping, contact and force of `Laws`, or None. The ledger takes the work of P and F as
        it is; the error is infinite if one is too stiff for the step. With F nothing bends
    """
    (pieces, ends), amplitude, f0, damping, target, dt, steps, history = run
    n, y, y_before, k, a = system.load.size, 0.0, 0.0, 0, 0.0  # 1
    u, u_before, u_after = system.start.copy(), system.start.copy(), np.zeros(n)
    bending_u, geometric_u, velocity = np.zeros(n), np.zeros(n), np.zeros(n)
    force, acceleration = np.zeros(n), np.zeros(n)
    inertia, drag = system.mass / dt**2, damping / (2 * dt)
    beam_drag = system.beam_damping * dt / 2
    N = axial_force(system, u, bending_u, geometric_u)
    begun = free_energy(system, u, velocity, (y, 0.0), N)
    ledger = opened(begun + (contact_energy(system, u, y) if P is None else 0.0))
    overlap, contact, push, law_power, lawful, too_stiff = -system.gap, 0.0, 0.0, 0.0, 0.0, False
    yields = dt**2 * mobility(system)

    for step in range(steps):
        if y < -system.stop_toward or y > system.stop_away:
            at = dot(system.midpoint, (u_before + u) / 2), a
            y_before, y, pushed, taken = meet_stops(system, at, y_before, y, dt)
            ledger = bounced(ledger, pushed, taken)
        x = f0 * (step * dt)
        k = curve.at(pieces, k, len(pieces), x)
        a = amplitude * curve.sample(pieces, k, ends, x, f0 * dt)  # 2
        w_mid = dot(system.midpoint, u)
        if F is None:
            N = axial_force(system, u, bending_u, geometric_u)  # 3
        else:
            push_before, push = push, F(-w_mid)
            moved = abs(w_mid - dot(system.midpoint, u_before))
            too_stiff |= step > 0 and yields * abs(push - push_before) > SPARE * moved
        overlap_before, contact_before, overlap = overlap, contact, w_mid - y - system.gap
        if P is None:
            contact = system.penalty * max(0.0, overlap)  # 4
        else:
            contact, moved = P(system.penalty, overlap), abs(overlap - overlap_before)
            harder = abs(contact - contact_before) - system.penalty * moved
            too_stiff |= step > 0 and (yields + dt**2 / system.mass) * harder > SPARE * moved
        for i in range(n):
            if F is None:
                force[i] = N * (geometric_u[i] + system.slope_start[i]) - bending_u[i]  # 5
            else:
                force[i] = system.midpoint[i] * push
            force[i] -= system.load[i] * a + system.midpoint[i] * contact
        multiply(system.inverse_inertia, force, acceleration)
        for i in range(n):
            u_after[i] = 2 * u[i] - (1 - beam_drag) * u_before[i] + dt**2 * acceleration[i]  # 6
            u_after[i] /= 1 + beam_drag
            velocity[i] = (u_after[i] - u_before[i]) / (2 * dt)
        force_y, y_after = contact - system.spring * y - system.mass * a, 2 * y - y_before
        for _ in range(1 if D is None else PASSES):
            y_velocity = (y_after - y_before) / (2 * dt)
            if D is not None and y_velocity != 0:
                drag = D(damping, y_velocity, y) / (2 * dt * y_velocity)
            y_after = (force_y + inertia * (2 * y - y_before) + drag * y_before) / (inertia + drag)
        if is_held(system, y_before, y, force_y):
            y_after = y
        y_velocity = (y_after - y_before) / (2 * dt)
        power = -a * (system.mass * y_velocity + dot(system.load, velocity))
        loss = (damping if D is None else 2 * dt * drag) * y_velocity**2
        if system.beam_damping > 0:
            loss += beam_loss(system, velocity, force)
        ledger = entered(ledger, power, loss, dt)
        law_before, w_velocity = law_power, dot(system.midpoint, velocity)
        law_power = push * w_velocity + (0.0 if P is None else contact * (y_velocity - w_velocity))
        lawful += (law_before + law_power) * dt / 2
        if step < history.shape[0]:
            keep(history[step], u, velocity, (y, y_velocity, ledger.work, ledger.lost))
        w_after = dot(system.midpoint, u_after)
        snaps = system.side * w_after <= target or not np.isfinite(w_after)  # 8
        if snaps or step == steps - 1 or too_stiff:
            break
        u_before, u, u_after = u, u_after, u_before
        y_before, y = y, y_after
    energy = free_energy(system, u, velocity, (y, y_velocity), N)
    energy += contact_energy(system, u, y) if P is None else 0.0
    residual = np.inf if too_stiff else energy + ledger.lost - ledger.work - lawful - ledger.begun
    return results(run, step, (system.side * w_mid, system.side * w_after), ledger, residual)


follow = njit(nogil=True, error_model="numpy")(follow)  # numba cannot keep it on disk, for its laws

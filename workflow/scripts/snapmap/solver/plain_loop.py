"""The handout's scheme to the letter: central differences in a plain loop, with a user's laws."""

import numpy as np
from numba import njit

from ..numerics import pieces as curve
from ..numerics.kernels import compiled
from ..numerics.linalg import apply
from .cells import Cells
from .laws import Law, Laws, of_user
from .ledger import CellRun, Ledger, bounced, entered, keep, results
from .nodal import (
    System,
    axial_force,
    beam_loss,
    contact_energy,
    dot,
    free_energy,
    mobility,
    multiply,
    nodal_system,
)
from .settings import SECOND, Run
from .stops import is_held, meet_stops

LANES = 1  # cells that are followed side by side
PASSES = 3
"""Iterations of a step with a law of damping, for the velocity half way through it."""
SPARE = 1.44
"""Most (omega dt)^2 that a law may add: the limit is 4, and a step at 0.8 of it leaves 1.44."""


def march_cell(
    system: System,
    run: CellRun,
    damping_law: Law | None,
    contact_law: Law | None,
    force_law: Law | None,
) -> tuple[float, float, float]:
    """March a cell by central differences until side w(L/2) passes the target or steps are done.

    With u = q - q0 and the displacement y of the mass, both from rest, at t = n dt:

        N = -EA/2L (2 u.G q0 + u.G u),  P = lambda <u(L/2) - y - z0>+
        Mb (u+ - 2 u + u-)/dt^2 + alpha Mb (u+ - u-)/(2 dt) = -Kb u + N (G u + G q0) - f a - e P
        M (y+ - 2 y + y-)/dt^2 + C (y+ - y-)/(2 dt) = -M a - K y + P

    docs/theory.md, Q6, numbers the steps; stops, laws and the ledger are no part of the handout.
    system: a `System`; run: a `CellRun`
    ..._law: as in `Laws`, or None for the handout's own. The ledger takes the work of contact and
        force as it is; the error is infinite if one is too stiff for the step. With a law of the
        force nothing bends
    Returns t_snap, energy_error and pulse_work, as in `Observations`.
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
    begun += contact_energy(system, u, y) if contact_law is None else 0.0
    ledger = Ledger(begun, 0.0, 0.0, 0.0, 0.0, 0.0)
    overlap, P, push, law_power, lawful, too_stiff = -system.gap, 0.0, 0.0, 0.0, 0.0, False
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
        if force_law is None:
            N = axial_force(system, u, bending_u, geometric_u)  # 3
        else:
            push_before, push = push, force_law(-w_mid)
            moved = abs(w_mid - dot(system.midpoint, u_before))
            too_stiff |= step > 0 and yields * abs(push - push_before) > SPARE * moved
        overlap_before, P_before, overlap = overlap, P, w_mid - y - system.gap
        if contact_law is None:
            P = system.penalty * max(0.0, overlap)  # 4
        else:
            P, moved = contact_law(system.penalty, overlap), abs(overlap - overlap_before)
            harder = abs(P - P_before) - system.penalty * moved
            too_stiff |= step > 0 and (yields + dt**2 / system.mass) * harder > SPARE * moved
        for i in range(n):
            if force_law is None:
                force[i] = N * (geometric_u[i] + system.slope_start[i]) - bending_u[i]  # 5
            else:
                force[i] = system.midpoint[i] * push
            force[i] -= system.load[i] * a + system.midpoint[i] * P
        multiply(system.inverse_inertia, force, acceleration)
        for i in range(n):
            u_after[i] = 2 * u[i] - (1 - beam_drag) * u_before[i] + dt**2 * acceleration[i]  # 6
            u_after[i] /= 1 + beam_drag
            velocity[i] = (u_after[i] - u_before[i]) / (2 * dt)
        force_y, y_after = P - system.spring * y - system.mass * a, 2 * y - y_before
        for _ in range(1 if damping_law is None else PASSES):  # 7
            y_velocity = (y_after - y_before) / (2 * dt)
            if damping_law is not None and y_velocity != 0:
                drag = damping_law(damping, y_velocity, y) / (2 * dt * y_velocity)
            y_after = (force_y + inertia * (2 * y - y_before) + drag * y_before) / (inertia + drag)
        if is_held(system, y_before, y, force_y):
            y_after = y
        y_velocity = (y_after - y_before) / (2 * dt)
        power = -a * (system.mass * y_velocity + dot(system.load, velocity))
        loss = (damping if damping_law is None else 2 * dt * drag) * y_velocity**2
        if system.beam_damping > 0:
            loss += beam_loss(system, velocity, force)
        ledger = entered(ledger, power, loss, dt)
        if contact_law is not None or force_law is not None:
            law_before, w_velocity = law_power, dot(system.midpoint, velocity)
            of_contact = 0.0 if contact_law is None else P * (y_velocity - w_velocity)
            law_power = push * w_velocity + of_contact
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
    energy += contact_energy(system, u, y) if contact_law is None else 0.0
    residual = np.inf if too_stiff else energy + ledger.lost - ledger.work - lawful - ledger.begun
    return results(run, step, (system.side * w_mid, system.side * w_after), ledger, residual)


_compiled = compiled(march_cell)
_compiled_with_laws = njit(nogil=True, error_model="numpy")(march_cell)
"""The loop with laws, for which numba cannot keep it on disk."""


def follow(system: System, run: CellRun, laws: Laws | None = None) -> tuple[float, float, float]:
    """Follow a cell as `march_cell` does, with laws in its lines if there are any."""
    if laws is None:
        return _compiled(system, run, None, None, None)
    with of_user(str(laws)):
        return _compiled_with_laws(system, run, laws.damping, laws.contact, laws.force)


def starting(model, start: str) -> System:
    """Return the system of a model of a single device whose runs begin as `start` says."""
    nodes = apply(model.modal.shapes, model.rest(start)) if start == SECOND else None
    system = nodal_system(model.device, model.basis, nodes)
    if model.laws and model.laws.force:  # it includes bending
        system = system._replace(bending=0.0 * system.bending)
    return system


def march(model, cells: Cells, dt: np.ndarray, settings: Run) -> tuple[np.ndarray, ...]:
    """Follow cells to their snaps or t_end, whatever `settings.until`; nothing settles.

    model: a `Model`; cells: `Cells`, each column (cells,); dt: us, (cells,)
    Returns columns as in `kernel.lanes.Facts`, of which wells and `lowest` are unknown.
    """
    observed = np.empty((3, cells.f0.size))
    for which in np.unique(cells.device):
        picked = model.pick(which)
        system = starting(picked, settings.start)
        no_history = np.empty((0, 2 * system.load.size + 4))
        target = picked.snap_target(settings.start)
        for i in np.flatnonzero(cells.device == which):
            steps = int(np.ceil(cells.t_end[i] / dt[i]))
            pulse = cells.pulses[cells.pulse[i]].curve
            load = pulse, cells.amplitude[i], cells.f0[i], cells.damping[i]
            run = CellRun(*load, target, dt[i], steps, no_history)
            observed[:, i] = follow(system, run, model.laws)
    t_snap, energy_error, pulse_work = observed
    no_well, unknown = np.zeros(t_snap.size, np.int8), np.full(t_snap.size, np.nan)
    return t_snap, unknown, no_well, energy_error, unknown, pulse_work, unknown

"""The handout's scheme to the letter: central differences in a plain loop."""

import numpy as np

from ..numerics import pieces as curve
from ..numerics.kernels import compiled
from ..numerics.linalg import apply
from .cells import Cells
from .ledger import CellRun, bounced, entered, keep, opened, results
from .nodal import (
    System,
    axial_force,
    beam_loss,
    contact_energy,
    dot,
    free_energy,
    multiply,
    nodal_system,
)
from .settings import SECOND, Run
from .stops import is_held, meet_stops

LANES = 1  # cells that are followed side by side


@compiled
def follow(system: System, run: CellRun) -> tuple[float, float, float]:
    """March a cell by central differences until side w(L/2) passes the target or steps are done.

    With u = q - q0 and the displacement y of the mass, both from rest, at t = n dt:

        N = -EA/2L (2 u.G q0 + u.G u),  P = lambda <u(L/2) - y - z0>+
        Mb (u+ - 2 u + u-)/dt^2 + alpha Mb (u+ - u-)/(2 dt) = -Kb u + N (G u + G q0) - f a - e P
        M (y+ - 2 y + y-)/dt^2 + C (y+ - y-)/(2 dt) = -M a - K y + P

    docs/theory.md, Q6, numbers the steps; stops and the ledger are no part of the handout.
    system: a `System`; run: a `CellRun`
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
    ledger = opened(free_energy(system, u, velocity, (y, 0.0), N) + contact_energy(system, u, y))

    for step in range(steps):
        if y < -system.stop_toward or y > system.stop_away:
            at = dot(system.midpoint, (u_before + u) / 2), a
            y_before, y, pushed, taken = meet_stops(system, at, y_before, y, dt)
            ledger = bounced(ledger, pushed, taken)
        x = f0 * (step * dt)
        k = curve.at(pieces, k, len(pieces), x)
        a = amplitude * curve.sample(pieces, k, ends, x, f0 * dt)  # 2
        w_mid = dot(system.midpoint, u)
        N = axial_force(system, u, bending_u, geometric_u)  # 3
        P = system.penalty * max(0.0, w_mid - y - system.gap)  # 4
        for i in range(n):
            force[i] = N * (geometric_u[i] + system.slope_start[i]) - bending_u[i]  # 5
            force[i] -= system.load[i] * a + system.midpoint[i] * P
        multiply(system.inverse_inertia, force, acceleration)
        for i in range(n):
            u_after[i] = 2 * u[i] - (1 - beam_drag) * u_before[i] + dt**2 * acceleration[i]  # 6
            u_after[i] /= 1 + beam_drag
            velocity[i] = (u_after[i] - u_before[i]) / (2 * dt)
        force_y = P - system.spring * y - system.mass * a
        y_after = (force_y + inertia * (2 * y - y_before) + drag * y_before) / (inertia + drag)  # 7
        if is_held(system, y_before, y, force_y):
            y_after = y
        y_velocity = (y_after - y_before) / (2 * dt)

        power = -a * (system.mass * y_velocity + dot(system.load, velocity))
        loss = damping * y_velocity**2
        if system.beam_damping > 0:
            loss += beam_loss(system, velocity, force)
        ledger = entered(ledger, power, loss, dt)
        if step < history.shape[0]:
            keep(history[step], u, velocity, (y, y_velocity, ledger.work, ledger.lost))
        w_after = dot(system.midpoint, u_after)
        if system.side * w_after <= target or step == steps - 1 or not np.isfinite(w_after):  # 8
            break
        u_before, u, u_after = u, u_after, u_before
        y_before, y = y, y_after
    energy = free_energy(system, u, velocity, (y, y_velocity), N) + contact_energy(system, u, y)
    residual = energy + ledger.lost - ledger.work - ledger.begun
    return results(run, step, (system.side * w_mid, system.side * w_after), ledger, residual)


def starting(model, start: str) -> System:
    """Return the system of a model of a single device whose runs begin as `start` says."""
    nodes = apply(model.modal.shapes, model.rest(start)) if start == SECOND else None
    return nodal_system(model.device, model.basis, nodes)


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
            observed[:, i] = follow(system, CellRun(*load, target, dt[i], steps, no_history))
    t_snap, energy_error, pulse_work = observed
    no_well, unknown = np.zeros(t_snap.size, np.int8), np.full(t_snap.size, np.nan)
    return t_snap, unknown, no_well, energy_error, unknown, pulse_work, unknown

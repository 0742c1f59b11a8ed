"""The handout's scheme to the letter: central differences in a plain loop."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..beam.basis import Basis
from ..beam.modal import pulse_load, settled
from ..device.device import Device
from ..numerics import pieces as curve
from ..numerics.kernels import compiled, fma
from ..numerics.linalg import apply, solve_all
from ..values.kinds import Number
from .laws import of_user
from .settings import SECOND

LANES = 1  # cells that are followed side by side
PASSES = 3
"""Iterations of a step with a law of damping, for the velocity half way through it."""
SPARE = 1.44
"""Most (omega dt)^2 that a law may add: the limit is 4, and a step at 0.8 of it leaves 1.44."""


class System(NamedTuple):
    """Coefficients of eqs. (2), (4) and (5) in n nodal unknowns; units um, ng, us.

    inertia, inverse_inertia, bending, geometric: (n, n); load, midpoint: (n,), as in `Basis`
    slope_start: (n,), G q0, of the shape at rest
    axial: E A / (2 L), uN/um
    mass, spring, penalty: M (ng), K (uN/um), lambda (uN/um)
    gap: z0, between mass and midpoint at rest, um
    beam_damping: rate alpha of the force -alpha Mb du/dt on the beam, 1/us
    stop_toward, stop_away: travel of the mass up to a stop, um; restitution: of both stops
    start: (n,), u at the begin of a run; side: 1, or -1 for runs from the second shape
    """

    inertia: np.ndarray
    inverse_inertia: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Number
    mass: Number
    spring: Number
    penalty: Number
    gap: Number
    beam_damping: Number
    stop_toward: Number
    stop_away: Number
    restitution: Number
    start: np.ndarray
    side: float


def nodal_system(device: Device, basis: Basis, start: np.ndarray | None = None) -> System:
    """Collect the coefficients of a device with a penalty contact, on a basis of its beam.

    start: u of the second shape, (n,), if a run begins there
    """
    scaled = settled(basis, device.beam).scaled_to(device.beam)
    return System(
        inertia=scaled.mass,
        inverse_inertia=solve_all(scaled.mass, np.eye(scaled.load.size)),
        bending=scaled.bending,
        geometric=scaled.geometric,
        slope_start=apply(scaled.geometric, scaled.start),
        load=pulse_load(device, scaled.load, scaled.midpoint),
        midpoint=scaled.midpoint,
        axial=device.beam.axial_stiffness,
        mass=device.mass,
        spring=device.spring,
        penalty=device.contact,
        gap=device.gap,
        beam_damping=device.beam.damping,
        stop_toward=device.stop_toward,
        stop_away=device.stop_away,
        restitution=device.restitution,
        start=np.zeros(scaled.load.size) if start is None else start,
        side=1.0 if start is None else -1.0,
    )


@compiled
def dot(a, b):
    """Return a . b."""
    total = 0.0
    for i in range(a.size):
        total = fma(a[i], b[i], total)
    return total


@compiled
def multiply(matrix, vector, result):
    """Set result to matrix vector, in place."""
    for i in range(vector.size):
        total = 0.0
        for j in range(vector.size):
            total = fma(matrix[i, j], vector[j], total)
        result[i] = total


@compiled
def beam_stresses(system, u, bending_u, geometric_u):
    """Set bending_u = Kb u and geometric_u = G u; returns N = -EA/2L (2 u.G q0 + u.G u), uN."""
    quadratic = 0.0
    for i in range(u.size):
        bending_row, geometric_row = 0.0, 0.0
        for j in range(u.size):
            bending_row = fma(system.bending[i, j], u[j], bending_row)
            geometric_row = fma(system.geometric[i, j], u[j], geometric_row)
        bending_u[i], geometric_u[i] = bending_row, geometric_row
        quadratic += u[i] * (geometric_row + 2 * system.slope_start[i])
    return -system.axial * quadratic


@compiled
def total_energy(system, u, velocity, y, y_velocity, compression, penalty):
    """Return kinetic, bending, axial, spring and contact energy in total, pJ; penalty: uN/um."""
    product = np.empty(u.size)
    multiply(system.inertia, velocity, product)
    beam = dot(velocity, product) / 2 + compression**2 / (4 * system.axial)
    multiply(system.bending, u, product)
    beam += dot(u, product) / 2
    mass = system.mass * y_velocity**2 / 2 + system.spring * y**2 / 2
    overlap = max(0.0, dot(system.midpoint, u) - y - system.gap)
    return beam + mass + penalty * overlap**2 / 2


@compiled
def potential(system, w_mid, a, z):
    """Return the energy of the mass at z: in its spring, in contact with w_mid, in the field -a."""
    overlap = max(0.0, w_mid - z - system.gap)
    return system.spring * z**2 / 2 + system.penalty * overlap**2 / 2 + system.mass * a * z


@compiled
def reflect(system, stop, w_mid, a, middle, velocity):
    """Return the place and velocity, after its reflection, of a mass that has passed a stop.

    middle, velocity: half a step back, before the stop; w_mid: midpoint then; a: of the frame
    """
    at_stop, e = potential(system, w_mid, a, stop), system.restitution
    falls = 2 * (potential(system, w_mid, a, middle) - at_stop) / system.mass
    if velocity**2 + falls <= 0 and (middle - stop) * velocity < 0:
        return middle, velocity  # the mass turns before the stop
    left = e**2 * max(0.0, velocity**2 + falls)
    place = stop - e * (middle - stop)
    climbs = 2 * (potential(system, w_mid, a, place) - at_stop) / system.mass
    if left < climbs:
        place, left, climbs = stop, 0.0, 0.0
    return place, -np.copysign(np.sqrt(left - climbs), velocity)


@compiled
def is_held(system, y_before, y, force):
    """Tell whether a mass that rests on a stop is pressed there, by its force without damping."""
    rests = y == y_before and (y == -system.stop_toward or y == system.stop_away)
    return rests and force * y >= 0.0


@compiled
def meet_stops(system, w_mid, a, y_before, y, dt):
    """Correct y of the last two instants, if the mass is beyond a stop, as if it had bounced.

    Returns both, the work of the pulse between the old and the new place, and the loss, pJ.
    """
    pushed, taken = 0.0, 0.0
    for side, travel in ((-1.0, system.stop_toward), (1.0, system.stop_away)):
        middle, velocity = (y_before + y) / 2, (y - y_before) / dt
        if side * y > travel and side * velocity > 0:
            place, turned = reflect(system, side * travel, w_mid, a, middle, velocity)
            falls = potential(system, w_mid, a, middle) - potential(system, w_mid, a, place)
            pushed += system.mass * a * (middle - place)
            taken += max(0.0, system.mass * (velocity**2 - turned**2) / 2 + falls)
            y_before, y = place - turned * dt / 2, place + turned * dt / 2
    return y_before, y, pushed, taken


def follow(
    system, pulse, amplitude, f0, damping, target, dt, steps, history, D=None, P=None, F=None
):
    """March a cell by central differences until side w(L/2) passes `target` or `steps` are done.

    With u = q - q0 and the displacement y of the mass, both from rest, at t = n dt:

        N = -EA/2L (2 u.G q0 + u.G u),  P = lambda <u(L/2) - y - z0>+
        Mb (u+ - 2 u + u-)/dt^2 + alpha Mb (u+ - u-)/(2 dt) = -Kb u + N (G u + G q0) - f a - e P
        M (y+ - 2 y + y-)/dt^2 + C (y+ - y-)/(2 dt) = -M a - K y + P

    pulse: pieces and ends, as `Pulse.curve` has them, over x = f0 t
    amplitude: N g, um/us^2; f0: 1/us; damping: C, uN us/um; target: w(L/2) from rest, um
    history: (samples, 2 n + 4), modified in place: u, du/dt, y, dy/dt, work of the pulse and
        energy lost (pJ), at as many of the first instants as it holds
    D, P, F: damping, contact and force of `Laws`; None for the device's, and the compiler drops
        the code of the others. The ledger takes their work as it is; the error is infinite if P or
        F is too stiff for the step
    Returns t_snap, energy_error and pulse_work, as in `Observations`.
    """
    n = system.load.size
    u, u_before, u_after = system.start.copy(), system.start.copy(), np.zeros(n)
    velocity = np.zeros(n)
    bending_u, geometric_u = np.zeros(n), np.zeros(n)
    force, acceleration = np.zeros(n), np.zeros(n)
    y, y_before = 0.0, 0.0
    inertia, drag = system.mass / dt**2, damping / (2 * dt)
    beam_drag = system.beam_damping * dt / 2
    power, work, gross_work, loss, lost = 0.0, 0.0, 0.0, 0.0, 0.0
    t_snap, residual, pulse_work = np.nan, 0.0, np.nan
    penalty = system.penalty if P is None else 0.0
    overlap, contact, push, lawful, law_power, too_stiff = -system.gap, 0.0, 0.0, 0.0, 0.0, False
    multiply(system.inverse_inertia, system.midpoint, acceleration)
    mobility = dt**2 * dot(system.midpoint, acceleration)
    pieces, ends = pulse
    k, a = 0, 0.0
    compression = beam_stresses(system, u, bending_u, geometric_u)
    begun = total_energy(system, u, velocity, y, 0.0, compression, penalty)

    for step in range(steps):
        if y < -system.stop_toward or y > system.stop_away:
            w_half = dot(system.midpoint, (u_before + u) / 2)
            y_before, y, pushed, taken = meet_stops(system, w_half, a, y_before, y, dt)
            work, gross_work, lost = work + pushed, gross_work + abs(pushed), lost + taken
        x = f0 * (step * dt)
        k = curve.at(pieces, k, len(pieces), x)
        a = amplitude * curve.sample(pieces, k, ends, x, f0 * dt)
        w_mid = dot(system.midpoint, u)
        if P is None:
            contact = system.penalty * max(0.0, w_mid - y - system.gap)
        else:
            overlap_before, contact_before, overlap = overlap, contact, w_mid - y - system.gap
            contact, moved = P(system.penalty, overlap), abs(overlap - overlap_before)
            harder = abs(contact - contact_before) - system.penalty * moved
            too_stiff |= step > 0 and (mobility + dt**2 / system.mass) * harder > SPARE * moved
        if F is None:
            compression = beam_stresses(system, u, bending_u, geometric_u)
        else:
            push_before, push = push, F(-w_mid)
            moved = abs(w_mid - dot(system.midpoint, u_before))
            too_stiff |= step > 0 and mobility * abs(push - push_before) > SPARE * moved
        for i in range(n):
            if F is None:
                force[i] = compression * (geometric_u[i] + system.slope_start[i]) - bending_u[i]
            else:
                force[i] = system.midpoint[i] * push
            force[i] -= system.load[i] * a + system.midpoint[i] * contact
        multiply(system.inverse_inertia, force, acceleration)
        for i in range(n):
            u_after[i] = 2 * u[i] - (1 - beam_drag) * u_before[i] + dt**2 * acceleration[i]
            u_after[i] /= 1 + beam_drag
            velocity[i] = (u_after[i] - u_before[i]) / (2 * dt)
        force_y = contact - system.spring * y - system.mass * a
        if D is None:
            y_after = (force_y + inertia * (2 * y - y_before) + drag * y_before) / (inertia + drag)
        else:
            y_after = 2 * y - y_before
            for _ in range(PASSES):
                y_velocity = (y_after - y_before) / (2 * dt)
                if y_velocity != 0:
                    drag = D(damping, y_velocity, y) / (2 * dt * y_velocity)
                y_after = force_y + inertia * (2 * y - y_before) + drag * y_before
                y_after /= inertia + drag
        if is_held(system, y_before, y, force_y):
            y_after = y
        y_velocity = (y_after - y_before) / (2 * dt)

        power_before, loss_before = power, loss
        power = -a * (system.mass * y_velocity + dot(system.load, velocity))
        loss = (damping if D is None else 2 * dt * drag) * y_velocity**2
        if system.beam_damping > 0:
            multiply(system.inertia, velocity, force)
            loss += system.beam_damping * dot(velocity, force)
        work += (power_before + power) * dt / 2
        gross_work += abs(power) * dt
        lost += (loss_before + loss) * dt / 2
        if P is not None or F is not None:
            law_before, w_velocity = law_power, dot(system.midpoint, velocity)
            law_power = push * w_velocity
            law_power += 0.0 if P is None else contact * (y_velocity - w_velocity)
            lawful += (law_before + law_power) * dt / 2
        if step < history.shape[0]:
            history[step, :n], history[step, n : 2 * n] = u, velocity
            history[step, 2 * n :] = y, y_velocity, work, lost

        w_after = dot(system.midpoint, u_after)
        snapped = system.side * w_after <= target
        if snapped or step == steps - 1 or not np.isfinite(w_after) or too_stiff:
            energy = total_energy(system, u, velocity, y, y_velocity, compression, penalty)
            residual = np.inf if too_stiff else energy + lost - work - lawful - begun
            if step + 1 >= curve.lasts(ends[1], f0 * dt):
                pulse_work = work + power * dt / 2
            if snapped:
                ahead = system.side * w_mid - target
                t_snap = (step + ahead / (system.side * (w_mid - w_after))) * dt
            break
        u_before, u, u_after = u, u_after, u_before
        y_before, y = y, y_after
    error = abs(residual) / gross_work if gross_work > 0 else abs(residual)
    return t_snap, error, pulse_work


follow_laws = njit(nogil=True, error_model="numpy")(follow)
"""`follow` with laws, which numba cannot keep on disk: a process compiles each set of them once."""
follow = compiled(follow)


def follower(laws):
    """Return `follow` with the laws bound to it, if there are any."""
    if laws is None:
        return follow

    def follow_by(*run):
        with of_user(str(laws)):
            return follow_laws(*run, laws.damping, laws.contact, laws.force)

    return follow_by


def starting(model, start):
    """Return the system of a model of a single device whose runs begin as `start` says."""
    nodes = apply(model.modal.shapes, model.rest(start)) if start == SECOND else None
    system = nodal_system(model.device, model.basis, nodes)
    if model.laws and model.laws.force:  # it includes bending
        system = system._replace(bending=0.0 * system.bending)
    return system


def march(model, cells, dt, settings):
    """Follow cells to their snaps or t_end, whatever `settings.until`; nothing settles.

    model: a `Model`; cells: `Cells`, each column (cells,); dt: us, (cells,)
    Returns columns as in `kernel.lanes.Facts`, of which wells and `lowest` are unknown.
    """
    observed, run = np.empty((3, cells.f0.size)), follower(model.laws)
    for which in np.unique(cells.device):
        picked = model.pick(which)
        system = starting(picked, settings.start)
        no_history = np.empty((0, 2 * system.load.size + 4))
        target = picked.snap_target(settings.start)
        for i in np.flatnonzero(cells.device == which):
            steps = int(np.ceil(cells.t_end[i] / dt[i]))
            pulse = cells.pulses[cells.pulse[i]].curve
            load = pulse, cells.amplitude[i], cells.f0[i], cells.damping[i]
            observed[:, i] = run(system, *load, target, dt[i], steps, no_history)
    t_snap, energy_error, pulse_work = observed
    no_well, unknown = np.zeros(t_snap.size, np.int8), np.full(t_snap.size, np.nan)
    return t_snap, unknown, no_well, energy_error, unknown, pulse_work, unknown

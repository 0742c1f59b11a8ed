"""The one time loop of every modal model: explicit central differences, one cell per SIMD lane.

All state and coefficients of the cells in flight stand in one flat array X, row r of lane l at
X[r * LANES + l]: only so does the compiler see that rows never alias, and vectorises over lanes.
Each lane has coefficients of its own, so cells of different devices share a call, and no lane's
result depends on its neighbours. Times in X are counted in steps, forces are times dt^2.

A function compiled for k modes gets them as `shape`, a tuple of k numbers, whose length the
compiler knows. All kernels stand in this one file: numba's cache does not see edits elsewhere.
"""

import numpy as np
from numba import njit

from .modal import contact_stiffness

LANES = 16
BLOCK = 128
"""Steps between two looks at the lanes; the pulse's recurrence is restarted at each look."""

# Rows of one number: the state at instant n; the device's; the cell's.
Y, Y_STEP, PULSE, PULSE_STEP, PULSE_LEFT, W_BEFORE, W, COUNT, WORK, GROSS_WORK, LOST = range(11)
AXIAL, RESIDUAL, CONTACT, MASS, SPRING, TARGET = range(11, 17)
AMPLITUDE, TURN, KEEP, PUSH = range(17, 21)
# Vectors of k rows, from row VECTORS on: the state and scratch; the device's; S, k vectors.
VECTORS = 21
P, P_STEP, SCRATCH, STIFFNESS, SLOPE_START, LOAD, MIDPOINT, GEOMETRIC = range(8)

# Fused multiply-adds are allowed and nothing else: NaN stays visible, sums keep their order.
FAST = {"fastmath": {"contract"}, "error_model": "numpy", "nogil": True, "cache": True}
EXACT = {"error_model": "numpy", "nogil": True, "cache": True}


@njit(inline="always")
def at(vector, i, modes, l):
    """Place in X of component i of a vector, lane l."""
    return (VECTORS + vector * modes + i) * LANES + l


@njit(inline="always")
def stretch(X, l, modes, first, last):
    """scratch_i = (S p + S q0)_i; returns their share of p.S p + 2 p.S q0."""
    quadratic = 0.0
    for i in range(first, last):
        slope = X[at(SLOPE_START, i, modes, l)]
        total = slope
        for j in range(modes):
            total += X[at(GEOMETRIC + i, j, modes, l)] * X[at(P, j, modes, l)]
        X[at(SCRATCH, i, modes, l)] = total
        quadratic += X[at(P, i, modes, l)] * (total + slope)
    return quadratic


@njit(inline="always")
def move(X, l, modes, first, last, axial, contact, a):
    """p_i+ = 2 p_i - p_i- + dt^2 force_i; returns their share of load.(p+ - p-)."""
    swept = 0.0
    for i in range(first, last):
        p = X[at(P, i, modes, l)]
        before = X[at(P_STEP, i, modes, l)]
        after = before + axial * X[at(SCRATCH, i, modes, l)]
        after -= X[at(STIFFNESS, i, modes, l)] * p
        after -= X[at(MIDPOINT, i, modes, l)] * contact
        after -= X[at(LOAD, i, modes, l)] * a
        X[at(P_STEP, i, modes, l)] = after
        X[at(P, i, modes, l)] = p + after
        swept += X[at(LOAD, i, modes, l)] * (before + after)
    return swept


@njit(**FAST)
def advance(X, shape, steps):
    """Advance every lane by `steps` steps of the modal form of eqs. (2), (4) and (5).

    N = -EA/2L (p.S p + 2 p.S q0),  w = e.p - c P,  P = <e.p - y>+ / (1/lambda + c)
    p+ - 2 p + p- = dt^2 (-kappa p + N (S p + S q0) - f a - e P)
    M (y+ - 2 y + y-) + C dt/2 (y+ - y-) = dt^2 (-M a - K y + P)

    w is latched, with the value before, at the first instant at or below the target.
    """
    modes = len(shape)
    # LLVM unrolls a short loop and gives up on a long one, and only what is unrolled vectorises
    # over lanes: so the loops over modes are cut in four.
    cut_1, cut_2, cut_3 = modes // 4, modes // 2, 3 * modes // 4
    for _ in range(steps):
        for l in range(LANES):
            pulse = X[PULSE * LANES + l]
            left = X[PULSE_LEFT * LANES + l]
            a = X[AMPLITUDE * LANES + l] * pulse if left > 0.0 else 0.0
            pulse_step = X[PULSE_STEP * LANES + l] + X[TURN * LANES + l] * (1.0 - pulse)
            X[PULSE_STEP * LANES + l] = pulse_step
            X[PULSE * LANES + l] = pulse + pulse_step
            X[PULSE_LEFT * LANES + l] = left - 1.0

            quadratic = stretch(X, l, modes, 0, cut_1) + stretch(X, l, modes, cut_1, cut_2)
            quadratic += stretch(X, l, modes, cut_2, cut_3) + stretch(X, l, modes, cut_3, modes)
            axial = -X[AXIAL * LANES + l] * quadratic
            w = 0.0
            for i in range(modes):
                w += X[at(MIDPOINT, i, modes, l)] * X[at(P, i, modes, l)]
            y = X[Y * LANES + l]
            contact = X[CONTACT * LANES + l] * (w - y)
            contact = contact if contact > 0.0 else 0.0

            w_last = X[W * LANES + l]
            above = w_last > X[TARGET * LANES + l]
            w_now = w - X[RESIDUAL * LANES + l] * contact
            X[W_BEFORE * LANES + l] = w_last if above else X[W_BEFORE * LANES + l]
            X[W * LANES + l] = w_now if above else w_last
            X[COUNT * LANES + l] += 1.0 if above else 0.0

            swept = move(X, l, modes, 0, cut_1, axial, contact, a)
            swept += move(X, l, modes, cut_1, cut_2, axial, contact, a)
            swept += move(X, l, modes, cut_2, cut_3, axial, contact, a)
            swept += move(X, l, modes, cut_3, modes, axial, contact, a)
            mass = X[MASS * LANES + l]
            before = X[Y_STEP * LANES + l]
            pull = contact - X[SPRING * LANES + l] * y - mass * a
            after = X[KEEP * LANES + l] * before + X[PUSH * LANES + l] * pull
            X[Y_STEP * LANES + l] = after
            X[Y * LANES + l] = y + after

            work = -a * (swept + mass * (before + after))
            X[WORK * LANES + l] += work
            X[GROSS_WORK * LANES + l] += abs(work)
            X[LOST * LANES + l] += (before + after) ** 2


@njit(**EXACT)
def state_size(modes):
    """How much of X, from its start, holds all that a step changes."""
    return (VECTORS + SCRATCH * modes) * LANES


@njit(**EXACT)
def fill(X, shape, l, coefficients, damping, amplitude, f0, dt):
    """Put a cell at rest into lane l."""
    X[l::LANES] = 0.0
    scalars = TARGET + 1 - AXIAL
    vectors = VECTORS + STIFFNESS * len(shape)
    for i in range(coefficients.size):
        row = AXIAL + i if i < scalars else vectors + i - scalars
        X[row * LANES + l] = coefficients[i]
    drag = damping * dt / 2
    mass = X[MASS * LANES + l]
    X[AMPLITUDE * LANES + l] = amplitude / 2 * dt**2
    X[TURN * LANES + l] = 4 * np.sin(np.pi * f0 * dt) ** 2
    X[PULSE_LEFT * LANES + l] = np.ceil(1 / (f0 * dt))
    X[KEEP * LANES + l] = (mass - drag) / (mass + drag)
    X[PUSH * LANES + l] = 1 / (mass + drag)


@njit(**EXACT)
def restart_pulse(X, l, angle_step, steps):
    """Set 1 - cos(2 pi f0 t) and its last increment afresh, at t = steps dt."""
    angle = angle_step * steps
    X[PULSE * LANES + l] = 2 * np.sin(angle / 2) ** 2
    X[PULSE_STEP * LANES + l] = 2 * np.sin(angle_step / 2) * np.sin(angle - angle_step / 2)


@njit(**EXACT)
def ledger(X_before, X, shape, l, drag):
    """Energy, work of the pulse, its gross work and what C took, all times dt^2, pJ us^2.

    At the instant of X_before, one step before X, so that velocities are centred.
    """
    modes = len(shape)
    quadratic, kinetic, potential, w = 0.0, 0.0, 0.0, 0.0
    for i in range(modes):
        p = X_before[at(P, i, modes, l)]
        slope = 2 * X[at(SLOPE_START, i, modes, l)]
        for j in range(modes):
            slope += X[at(GEOMETRIC + i, j, modes, l)] * X_before[at(P, j, modes, l)]
        quadratic += p * slope
        w += X[at(MIDPOINT, i, modes, l)] * p
        velocity = (X_before[at(P_STEP, i, modes, l)] + X[at(P_STEP, i, modes, l)]) / 2
        kinetic += velocity**2 / 2
        potential += X[at(STIFFNESS, i, modes, l)] * p**2 / 2
    y = X_before[Y * LANES + l]
    velocity = (X_before[Y_STEP * LANES + l] + X[Y_STEP * LANES + l]) / 2
    kinetic += X[MASS * LANES + l] * velocity**2 / 2
    potential += X[AXIAL * LANES + l] * quadratic**2 / 4 + X[SPRING * LANES + l] * y**2 / 2
    potential += X[CONTACT * LANES + l] * max(0.0, w - y) ** 2 / 2
    work = (X_before[WORK * LANES + l] + X[WORK * LANES + l]) / 4
    lost = drag * (X_before[LOST * LANES + l] + X[LOST * LANES + l]) / 8
    return kinetic + potential, work, X[GROSS_WORK * LANES + l] / 2, lost


@njit(**EXACT)
def snap_time(X, l, dt):
    """Time at which w passed the target, linear between the two instants around it."""
    before, after = X[W_BEFORE * LANES + l], X[W * LANES + l]
    fraction = (before - X[TARGET * LANES + l]) / (before - after)
    return (X[COUNT * LANES + l] - 2 + fraction) * dt


@njit(**EXACT)
def follow_all(
    X, shape, devices, dt, device_of, amplitude, f0, damping, t_end, t_snap, energy_error
):
    """Follow every cell until its snap or past t_end, refilling each lane as it falls free.

    X: work array; devices: (n_devices, coefficients), dt: (n_devices,), us
    device_of, amplitude (um/us^2), f0 (1/us), damping (C, uN us/um), t_end (us): (cells,)
    t_snap (us, NaN if not seen), energy_error (residual of the energy ledger over the
    gross work of the pulse, not finite after a blow-up): (cells,), modified in place
    """
    cells = t_snap.size
    cell_in = np.full(LANES, -1)
    steps = np.zeros(LANES, np.int64)
    next_cell, running = 0, 0
    X[:] = 0.0
    X_before = X[: state_size(len(shape))].copy()
    while next_cell < cells or running > 0:
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < cells:
                device = device_of[next_cell]
                load = damping[next_cell], amplitude[next_cell], f0[next_cell]
                fill(X, shape, l, devices[device], *load, dt[device])
                cell_in[l], steps[l] = next_cell, 0
                next_cell += 1
                running += 1
            if X[PULSE_LEFT * LANES + l] > 0:
                cell = cell_in[l]
                restart_pulse(X, l, 2 * np.pi * f0[cell] * dt[device_of[cell]], steps[l])
        advance(X, shape, BLOCK - 1)
        X_before[:] = X[: X_before.size]
        advance(X, shape, 1)
        for l in range(LANES):
            cell = cell_in[l]
            if cell < 0:
                continue
            steps[l] += BLOCK
            step = dt[device_of[cell]]
            w = X[W * LANES + l]
            snapped = w <= X[TARGET * LANES + l]
            if not snapped and np.isfinite(w) and steps[l] * step <= t_end[cell]:
                continue
            energy, work, gross_work, lost = ledger(X_before, X, shape, l, damping[cell] * step)
            residual = abs(energy + lost - work)
            energy_error[cell] = residual / gross_work if gross_work > 0 else residual
            t_snap[cell] = snap_time(X, l, step) if snapped else np.nan
            cell_in[l] = -1
            running -= 1
            X[l::LANES] = 0.0


def follow_lanes(modes, devices, dt, device_of, amplitude, f0, damping, t_end):
    """Follow cells of one or several devices; returns (t_snap, energy_error).

    devices: (n_devices, coefficients), rows made by `device_coefficients`, each of `modes` modes
    The other arguments and the results are those of `follow_all`.
    """
    t_snap, energy_error = np.empty(f0.size), np.empty(f0.size)
    cells = device_of, amplitude, f0, damping, t_end
    follow_all(_work_array(modes), (0,) * modes, devices, dt, *cells, t_snap, energy_error)
    return t_snap, energy_error


def follow_one(modes, device, dt, amplitude, f0, damping, steps, stride):
    """Follow one cell as `follow_all` does, bit for bit, and keep every `stride`th instant.

    device: its row of coefficients; stride: a divisor of BLOCK
    Returns p and dp/dt, (samples, modes); y, dy/dt, the pulse's work (pJ) and the integral of
    (dy/dt)^2 (um^2/us), (samples,)
    """
    X, shape, size = _work_array(modes), (0,) * modes, state_size(modes)
    fill(X, shape, 0, device, damping, amplitude, f0, dt)
    before, after = [], []
    for step in range(0, steps, stride):
        if step % BLOCK == 0:
            restart_pulse(X, 0, 2 * np.pi * f0 * dt, step)
        before.append(X[:size:LANES].copy())
        advance(X, shape, 1)
        after.append(X[:size:LANES].copy())
        advance(X, shape, stride - 1)
    before, after = np.array(before), np.array(after)
    middle = (before + after) / 2
    p, p_step = (slice(VECTORS + v * modes, VECTORS + (v + 1) * modes) for v in (P, P_STEP))
    return (
        before[:, p],
        middle[:, p_step] / dt,
        before[:, Y],
        middle[:, Y_STEP] / dt,
        middle[:, WORK] / (2 * dt**2),
        middle[:, LOST] / (4 * dt),
    )


def device_coefficients(modal, device, dt, target):
    """One device's row of coefficients, in the order of the rows of X, with forces times dt^2.

    target: w(L/2) - rise at which a run counts as snapped, um; -inf for never
    """
    contact = contact_stiffness(device, modal.residual)
    return np.concatenate(
        [
            [modal.axial * dt**2, modal.residual / dt**2, contact * dt**2],
            [device.mass, device.spring * dt**2, target],
            modal.stiffness * dt**2,
            modal.slope_start,
            modal.load,
            modal.midpoint,
            modal.geometric.ravel(),
        ]
    )


def _work_array(modes):
    """Zeros for X, from the start of a cache line, where wide vector loads are fastest."""
    padded = np.zeros((VECTORS + (GEOMETRIC + modes) * modes) * LANES + 8)
    return padded[(-padded.ctypes.data // 8) % 8 :][: padded.size - 8]

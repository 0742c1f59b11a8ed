"""The SIMD kernels, called for the cells of a model."""

import numpy as np

from ..beam.modal import contact_stiffness
from .record import Form, Motion
from .simd_kernel import (
    BEAM_SWEPT,
    BLOCK,
    GEOMETRIC,
    LANES,
    P_STEP,
    SCRATCH,
    STATE,
    SWEPT,
    VECTORS,
    WORK,
    Y_STEP,
    P,
    Y,
    advance,
    advance_conserving,
    fill,
    follow_all,
    restart_pulse,
    trace_all,
)


def march(model, cells, settings):
    """Follow cells, each with the device that it names; returns the facts of `follow_all`.

    model: a `Model`; cells: `Cells`, each column (cells,)
    """
    n_cells, modes = cells.f0.size, model.modes
    facts = *(np.empty(n_cells) for _ in range(2)), np.empty(n_cells, np.int8), np.empty(n_cells)
    rows, dt = coefficients(model, snap_target(model.device)), np.atleast_1d(model.dt)
    asked = settings.until == "snap", settings.energy_tolerance
    X, shape = _work_array(modes), (0,) * modes
    follow_all(X, shape, _conserving(model), rows, dt, tuple(cells), *asked, facts)
    return facts


def trace(model, device, cells, bins):
    """Follow up to LANES cells, each through `bins` bins of its own width.

    device: index of each cell's; cells: as in `trace_all`; returns w_range and instants from there
    """
    n_cells = cells[0].size
    w_range = np.empty((2, bins, n_cells))
    w_range[0], w_range[1] = np.inf, -np.inf
    instants = np.empty((3, bins, n_cells))
    X, shape, rows = _work_array(model.modes), (0,) * model.modes, coefficients(model, -np.inf)
    dt = np.atleast_1d(model.dt)[device]
    trace_all(X, shape, _conserving(model), rows[device], dt, cells, w_range, instants)
    return w_range, instants


def record(model, amplitude, f0, damping, steps, stride):
    """Follow one cell as `follow_all` does, bit for bit, and keep every `stride`th instant.

    model: of one device; stride: a divisor of BLOCK; returns Motion and Form
    """
    modal, modes, dt = model.modal, model.modes, model.dt
    X, shape = _work_array(modes), (0,) * modes
    state = slice(STATE * LANES, (VECTORS + SCRATCH * modes) * LANES, LANES)
    go = advance if model.scheme == "explicit" else advance_conserving
    fill(X, shape, 0, coefficients(model, -np.inf)[0], damping, amplitude, f0, dt)
    before, after = [], []
    for step in range(0, steps, stride):
        if step % BLOCK == 0:
            restart_pulse(X, 0, f0 * dt, step)
        before.append(X[state].copy())
        go(X, shape, 1)
        after.append(X[state].copy())
        go(X, shape, stride - 1)
    before, after = np.array(before), np.array(after)
    middle = (before + after) / 2
    vectors = VECTORS - STATE + modes * np.array([P, P_STEP])
    p, p_step = (slice(first, first + modes) for first in vectors)
    lost = damping * middle[:, SWEPT - STATE]
    lost += model.device.beam.damping * middle[:, BEAM_SWEPT - STATE]
    motion = Motion(
        time=np.arange(len(before)) * stride * dt,
        u=before[:, p],
        u_velocity=middle[:, p_step] / dt,
        y=before[:, Y - STATE],
        y_velocity=middle[:, Y_STEP - STATE] / dt,
        work=middle[:, WORK - STATE] / (2 * dt**2),
        lost=lost / (4 * dt),
    )
    inertia, bending = np.eye(modes), np.diag(modal.stiffness)
    return motion, Form(inertia, bending, *modal[1:3], modal.midpoint, modal.residual)


def coefficients(model, target):
    """A row for each device, in the order of the rows of X, with forces times dt^2.

    model: a `Model`; target: w(L/2) - rise at which a run counts as snapped, um; -inf for never
    """
    device, modal, barrier, square = model.device, model.modal, model.barrier, model.dt * model.dt
    numbers = [
        *(modal.axial * square, modal.residual / square),
        *(contact_stiffness(device, modal.residual) * square, device.mass, device.spring * square),
        *(target, barrier.energy * square, barrier.midpoint, device.beam.damping * model.dt),
    ]
    vectors = (np.reshape(square, (-1, 1)) * modal.stiffness, *modal[2:5])
    n, k = np.size(square), model.modes
    columns = [np.broadcast_to(number, n)[:, np.newaxis] for number in numbers]
    columns += [np.reshape(vector, (n, k)) for vector in vectors]
    return np.concatenate([*columns, np.reshape(modal.geometric, (n, k * k))], axis=1)


def _conserving(model):
    return True if model.scheme == "conserving" else None


def snap_target(device):
    """w2 - rise, um."""
    return device.beam.second_equilibrium - device.beam.rise


def _work_array(modes):
    """Zeros for X, from the start of a cache line, where wide vector loads are fastest."""
    padded = np.zeros((VECTORS + (GEOMETRIC + modes) * modes) * LANES + 8)
    return padded[(-padded.ctypes.data // 8) % 8 :][: padded.size - 8]

"""The SIMD kernels, called for the cells of a model."""

import numpy as np

from ..beam.modal import contact_stiffness
from ..pulse import table
from .record import Form, Motion
from .schemes import CONSERVING, EXPLICIT
from .simd_kernel import (
    BEAM_SWEPT,
    BLOCK,
    GEOMETRIC,
    LANES,
    P_STEP,
    SCRATCH,
    STATE,
    STRETCH,
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
    no_pushes,
    push,
    set_out,
    trace_all,
)


def march(model, cells, dt, settings):
    """Follow cells, each with the device that it names; returns the facts of `follow_all`.

    model: a `Model`; cells: `Cells`, each column (cells,); dt: us, (cells,)
    """
    n_cells, modes = cells.f0.size, model.modes
    t_snap, t_settled, *others = (np.empty(n_cells) for _ in range(5))
    facts = t_snap, t_settled, np.empty(n_cells, np.int8), *others
    rows, pulses = coefficients(model, snap_target(model)), table(settings.pulses)
    ends = settings.until in ("snap", "edge", "pulse"), settings.until == "pulse"
    asked = ends, settings.energy_tolerance
    X, shape = work_array(modes), (0,) * modes
    follow_all(X, shape, *_schemes(model), rows, pulses, (*cells, dt), *asked, facts)
    return facts


def trace(model, device, dt, pulses, cells, bins):
    """Follow up to LANES cells, each through `bins` bins of its own width.

    device: index of each cell's; dt: us, (cells,)
    pulses: those that the cells name; cells: as in `trace_all`
    Returns w_range and instants from there
    """
    n_cells = cells[0].size
    w_range, instants = np.empty((2, bins, n_cells)), np.empty((3, bins, n_cells))
    X, shape, rows = work_array(model.modes), (0,) * model.modes, coefficients(model, -np.inf)
    asked = table(pulses), cells
    trace_all(X, shape, *_schemes(model), rows[device], dt, *asked, w_range, instants)
    return w_range, instants


def record(model, pulse, amplitude, f0, damping, dt, steps, stride):
    """Follow one cell as `follow_all` does, bit for bit, and keep every `stride`th step.

    model: of one device; dt: us; stride: a divisor of BLOCK; returns Motion and Form
    """
    modal, modes, at_half = model.modal, model.modes, model.scheme == CONSERVING
    before, after = _pairs(model, (damping, amplitude), (pulse, f0), dt, steps, stride)
    middle = (before + after) / 2
    places, moving = (middle, after) if at_half else (before, middle)
    shrink = 1 / np.sqrt(1 + dt * dt * modal.stiffness / 4) if at_half else np.ones(modes)
    p, p_step = (VECTORS - STATE + modes * v + np.arange(modes) for v in (P, P_STEP))
    lost = damping * moving[SWEPT - STATE]
    lost += model.device.beam.damping * moving[BEAM_SWEPT - STATE]
    u, y = shrink * places[p].T, places[Y - STATE]
    form = Form(
        np.eye(modes), np.diag(modal.stiffness), *modal[1:3], modal.midpoint, modal.residual
    )
    motion = Motion(
        time=(np.arange(before.shape[1]) * stride + at_half / 2) * dt,
        u=u,
        u_velocity=shrink * moving[p_step].T / dt,
        y=y,
        y_velocity=moving[Y_STEP - STATE] / dt,
        stretch=after[STRETCH - STATE] if at_half else form.stretch(u),
        work=moving[WORK - STATE] / (2 * dt**2),
        lost=lost / (4 * dt),
    )
    return motion, form


def _pairs(model, load, shock, dt, steps, stride):
    """The state of one cell at every `stride`th instant, and one step on; (rows, samples)."""
    modes, (pulse, f0) = model.modes, shock
    X, shape = work_array(modes), (0,) * modes
    state = slice(STATE * LANES, (VECTORS + SCRATCH * modes) * LANES, LANES)
    go = advance if model.scheme == EXPLICIT else advance_conserving
    fill(X, shape, model.scheme == CONSERVING, 0, coefficients(model, -np.inf)[0], *load, dt)
    before, after, shocks = [], [], np.zeros(BLOCK * LANES)
    pulses, pushes = table([pulse]), no_pushes()
    push(X, 0, pushes, pulses, 0, f0 * dt)
    for step in range(0, steps, stride):
        in_block = step % BLOCK
        if in_block == 0:
            pushes.steps[:] = step
            set_out(X, shocks, pushes, pulses)
        before.append(X[state].copy())
        go(X, shape, shocks, in_block, 1)
        after.append(X[state].copy())
        go(X, shape, shocks, in_block + 1, stride - 1)
    return np.array(before).T, np.array(after).T


def coefficients(model, target):
    """A row for each device, in the order of the rows of X, with forces times dt^2.

    model: a `Model`; target: w(L/2) from rest at which a run counts as snapped, um; -inf for never
    """
    device, modal, barrier = model.device, model.modal, model.barrier
    proves_below = np.where(model.proves, barrier.energy, 0.0)
    numbers = [
        *(modal.axial, modal.residual, contact_stiffness(device, modal.residual), device.mass),
        *(device.spring, target, proves_below, barrier.midpoint, device.gap),
        device.beam.damping,
    ]
    vectors = modal.stiffness, *modal[2:5]
    n, k = len(device), model.modes
    columns = [np.broadcast_to(number, n)[:, np.newaxis] for number in numbers]
    columns += [np.reshape(vector, (n, k)) for vector in vectors]
    return np.concatenate([*columns, np.reshape(modal.geometric, (n, k * k))], axis=1)


def _schemes(model):
    """As kernels take it, `explicit` and `conserving`: None but for the one taken."""
    return (None, True) if model.scheme == CONSERVING else (True, None)


def snap_target(model):
    """Where the midpoint snaps, from where it rests, um."""
    return model.barrier.second - model.barrier.first


def work_array(modes):
    """Zeros for X, from the start of a cache line, where wide vector loads are fastest."""
    padded = np.zeros((VECTORS + (GEOMETRIC + modes) * modes) * LANES + 8)
    return padded[(-padded.ctypes.data // 8) % 8 :][: padded.size - 8]

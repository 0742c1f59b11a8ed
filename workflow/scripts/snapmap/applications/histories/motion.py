"""The motion of one cell at every step, by the loop of its model."""

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...numerics.linalg import dot, multiply
from ...pulse.pulse import Pulse, table
from ...solver.kernel import rows as R
from ...solver.kernel.lanes import load
from ...solver.kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out
from ...solver.kernel.trace import keep_block
from ...solver.lane_laws import raise_error
from ...solver.ledger import CellRun
from ...solver.models import Model
from ...solver.plain_loop import follow, starting
from ...solver.settings import FIRST
from ...solver.simd_loop import WINDOW, coefficients, empty_lanes


class Motion(NamedTuple):
    """Samples over time of the beam's n coordinates u, the mass's displacement y, and the ledger.

    The plain loop samples at the steps; the kernel samples at rest and then half way between
    steps, where it knows its energies.

    time: us
    u, u_velocity: (samples, n); the other arrays are (samples,)
    stretch: u.G u + 2 u.G q0, um
    work, lost: work of the pulse, and energy lost to damping, pJ
    """

    time: np.ndarray
    u: np.ndarray
    u_velocity: np.ndarray
    y: np.ndarray
    y_velocity: np.ndarray
    stretch: np.ndarray
    work: np.ndarray
    lost: np.ndarray


class Form(NamedTuple):
    """Matrices and vectors of the coordinates u of a `Motion`, named as in `ModalBeam`."""

    inertia: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    midpoint: np.ndarray
    residual: float
    shapes: np.ndarray


def record(
    model: Model,
    pulse: Pulse,
    amplitude: float,
    f0: float,
    damping: float,
    dt: float,
    steps: int,
    start: str = FIRST,
) -> tuple[Form, Iterator[Motion]]:
    """Follow one cell, bit for bit as a run with `until` "moved", and record every step.

    model: of one device; dt: us
    Returns the Form, and an iterable of a Motion for each window of steps.
    """
    if model.name == "reference":
        return _by_plain_loop(model, pulse, amplitude, f0, damping, dt, steps, start)
    form, motions = _by_kernel(model, pulse, amplitude, f0, damping, dt, steps, start)
    return form, chain([_at_rest(form, model.rest(start))], motions)


def _at_rest(form, modes):
    """The Motion of the instant 0, which the kernel leaves out."""
    u, zero = np.reshape(modes, (1, -1)), np.zeros(1)
    stretch = dot(u, multiply(u, form.geometric) + 2 * form.slope_start)
    return Motion(zero, u, 0 * u, zero, zero, stretch, work=zero, lost=zero)


def _by_kernel(model, pulse, amplitude, f0, damping, dt, steps, start):
    modal, lanes, pulses, state = model.modal, empty_lanes(model), table([pulse]), no_pulse()
    load(*lanes, 0, coefficients(model, -np.inf, start)[0], damping, amplitude, dt)
    begin_pulse(lanes[0], 0, state, pulses, 0, f0 * dt)
    shrink = lanes[0][:: R.LANES][R.VECTORS + R.U * model.modes :][: model.modes].copy()
    form = Form(
        inertia=np.diag(1 / (shrink * shrink) - dt * dt * modal.stiffness / 4),
        bending=np.diag(modal.stiffness),
        geometric=modal.geometric,
        slope_start=modal.slope_start,
        midpoint=modal.midpoint,
        residual=modal.residual,
        shapes=modal.shapes,
    )
    windows = _pairs(model, lanes, pulses, state, steps)
    return form, (_motion(model, damping, dt, shrink, *window) for window in windows)


def _motion(model, damping, dt, shrink, first, before, after):
    """The Motion of a window of `_pairs`; shrink: coordinates u over those of the kernel."""
    modes, middle = model.modes, (before + after) / 2
    p, p_step = (R.VECTORS - R.STATE + modes * v + np.arange(modes) for v in (R.P, R.D))
    lost = damping * after[R.SWEPT - R.STATE]
    lost += model.device.beam.damping * after[R.BEAM_SWEPT - R.STATE]
    return Motion(
        time=(first + np.arange(middle.shape[1]) + 0.5) * dt,
        u=shrink * middle[p].T,
        u_velocity=shrink * after[p_step].T / dt,
        y=middle[R.Y - R.STATE],
        y_velocity=after[R.DY - R.STATE] / dt,
        stretch=after[R.Q - R.STATE],
        work=after[R.WORK - R.STATE] / (2 * dt**2),
        lost=lost / (4 * dt) + after[R.LOST - R.STATE] / dt**2,
    )


def _pairs(model, lanes, pulses, pulse_state, steps):
    """Yield the first step of each window, and the states around its steps, (rows, steps)."""
    shocks, rows = np.zeros(BLOCK * R.LANES), R.VECTORS + R.U * model.modes - R.STATE
    for first in range(0, steps, WINDOW):
        before, after = np.empty((2, min(WINDOW, steps - first), rows))
        for step in range(0, len(before), BLOCK):
            pulse_state.steps[:] = first + step
            set_out(lanes[0], shocks, pulse_state, pulses)
            block = slice(step, step + BLOCK)
            keep_block(*lanes, shocks, before[block], after[block])
        raise_error(model.laws, lanes[2])
        yield first, before.T, after.T


def _by_plain_loop(model, pulse, amplitude, f0, damping, dt, steps, start):
    system, n = starting(model, start), model.basis.load.size
    history = np.zeros((steps, 2 * n + 4))
    run = CellRun(pulse.curve, amplitude, f0, damping, -np.inf, dt, steps, history)
    follow(system, run)
    form = Form(
        inertia=system.inertia,
        bending=system.bending,
        geometric=system.geometric,
        slope_start=system.slope_start,
        midpoint=system.midpoint,
        residual=0.0,
        shapes=np.eye(n),
    )
    time, u, u_velocity = np.arange(steps) * dt, history[:, :n], history[:, n : 2 * n]
    y, y_velocity, work, lost = history[:, 2 * n :].T
    stretch = dot(u, multiply(u, form.geometric) + 2 * form.slope_start)
    return form, [Motion(time, u, u_velocity, y, y_velocity, stretch, work, lost)]

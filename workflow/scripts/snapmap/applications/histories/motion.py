"""The motion of one cell at every step, by the loop of its model."""

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...numerics.linalg import dot, multiply
from ...solver.cells import Cells
from ...solver.kernel import rows as R
from ...solver.kernel.trace import keep_motion
from ...solver.ledger import CellRun
from ...solver.models import Model
from ...solver.plain_loop import follow, starting
from ...solver.settings import FIRST
from ...solver.simd_loop import begin, in_windows, may_jump


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
    model: Model, cells: Cells, dt: np.ndarray, start: str = FIRST, jumps: bool = False
) -> tuple[Form, Iterator[Motion]]:
    """Follow one cell to its end, bit for bit as a run with `until` "shown", and record every step.

    model: of one device; cells: the cell; dt: us, (1,)
    jumps: whether to leave out quiet time, except by the plain loop
    Returns the Form, and an iterable of a Motion for each window of steps.
    """
    steps = np.ceil(cells.t_end / dt).astype(np.int64)
    if model.name == "reference":
        return _by_plain_loop(model, cells, dt.item(), steps.item(), start)
    modal, (lanes, (shrink, *_)) = model.modal, begin(model, cells, dt, start)
    form = Form(
        inertia=np.diag(1 / (shrink * shrink) - dt * dt * modal.stiffness / 4),
        bending=np.diag(modal.stiffness),
        geometric=modal.geometric,
        slope_start=modal.slope_start,
        midpoint=modal.midpoint,
        residual=modal.residual,
        shapes=modal.shapes,
    )

    def keep(size):
        states = np.empty((2, size, R.VECTORS + R.U * model.modes - R.STATE))
        keep_motion(*lanes, *states)
        return states

    windows = in_windows(model, lanes, steps, keep, jumps and may_jump(model, cells))
    parts = (
        (first.item(), *states[:, : (steps - first).item()].swapaxes(1, 2))
        for first, states in windows
    )
    motions = (_motion(model, cells.damping, dt, shrink, *part) for part in parts)
    return form, chain([_at_rest(form, model.rest(start))], motions)


def _at_rest(form, modes):
    """The Motion of the instant 0, which the kernel leaves out."""
    u, zero = np.reshape(modes, (1, -1)), np.zeros(1)
    stretch = dot(u, multiply(u, form.geometric) + 2 * form.slope_start)
    return Motion(zero, u, 0 * u, zero, zero, stretch, work=zero, lost=zero)


def _motion(model, damping, dt, shrink, first, before, after):
    """The Motion of a window; before, after: states around its steps, (rows, steps)."""
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


def _by_plain_loop(model, cells, dt, steps, start):
    system, n = starting(model, start), model.basis.load.size
    amplitude, f0, damping = (column.item() for column in cells[2:5])
    history = np.zeros((steps, 2 * n + 4))
    run = CellRun(cells.pulses[0].curve, amplitude, f0, damping, -np.inf, dt, steps, history)
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

"""The SIMD kernels, called for the cells of a model."""

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np

from ..beam.basis import PLACES
from ..beam.modal import contact_stiffness
from ..beam.stress import stress_of
from ..pulse.pulse import table
from .cells import Form, Motion, no_observations
from .kernel import rows as R
from .kernel.lanes import Facts, Task, follow_all, load
from .kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out
from .kernel.trace import follow_stress, keep_block, keep_midpoints
from .settings import FIRST, SECOND

SIDE = {FIRST: 1.0, SECOND: -1.0}
"""By which w is multiplied, so that the midpoint of every run begins above its target."""
WINDOW = 64 * BLOCK
"""Steps of a record that are in memory at once."""


def march(model, cells, dt, settings):
    """Follow cells, each with the device that it names; returns `Facts`.

    model: a `Model`; cells: `Cells`, each column (cells,); dt: us, (cells,); settings: `Settings`
    """
    nothing = no_observations(cells.f0.shape)
    facts = Facts(*(getattr(nothing, key) for key in Facts._fields))
    task = Task(
        devices=_coefficients(model, settings.start),
        pulses=table(cells.pulses),
        device=cells.device,
        pulse=cells.pulse,
        amplitude=cells.amplitude,
        f0=cells.f0,
        damping=cells.damping,
        t_end=cells.t_end,
        dt=dt,
        stop_at_snap=settings.until in ("snap", "edge", "pulse"),
        stop_after_pulse=settings.until == "pulse",
        tolerance=settings.energy_tolerance,
        facts=facts,
    )
    follow_all(*empty_lanes(model), task)
    return facts


@lru_cache(maxsize=1)
def _coefficients(model, start):
    """Keep the last coefficients of runs that may snap, as a batch is followed many times."""
    return coefficients(model, model.snap_target(start), start)


def largest_stress(model, cells, dt, steps, rows, start=FIRST):
    """Follow up to LANES cells, each for its steps, for the largest stress; MPa, (cells,).

    dt: us, (cells,); rows: of the cells, (cells, ...), as `stress_rows` has them of their devices
    """
    rows, largest = rows.copy(), np.full(dt.size, -np.inf)
    rows[:, :-1, model.modes] /= (dt * dt)[:, np.newaxis]
    devices = coefficients(model, -np.inf, start)[cells.device]
    loads = *cells[1:5], steps
    follow_stress(*empty_lanes(model), devices, dt, table(cells.pulses), loads, rows, largest)
    return largest


def midpoints(model, cells, dt, steps, start=FIRST):
    """Follow up to LANES cells; yield first step and w(L/2) from rest of one WINDOW after another.

    dt: us, (cells,); steps: of all; w: half way through each step, um, (steps, cells)
    """
    lanes, state, pulses = empty_lanes(model), no_pulse(), table(cells.pulses)
    rows = coefficients(model, -np.inf, start)
    for l in range(dt.size):
        load(*lanes, l, rows[cells.device[l]], cells.damping[l], cells.amplitude[l], dt[l])
        begin_pulse(lanes[0], l, state, pulses, cells.pulse[l], cells.f0[l] * dt[l])
    for first in range(0, steps, WINDOW):
        w = np.empty((min(WINDOW, steps - first), R.LANES))
        keep_midpoints(*lanes, state, pulses, first, w)
        yield first, w[:, : dt.size]


def stress_rows(model):
    """Tabulate what gives the stress of each device's beam, (devices, PLACES + 1, modes + 2).

    Rows of bending, MPa per coordinate, per contact force and at rest; a last one of the axial
    stress, per stretch and at rest
    """
    tables = np.zeros((len(model.device), PLACES + 1, model.modes + 2))
    for i, rows in enumerate(tables):
        picked = model.pick(i)
        form = stress_of(picked.device.beam, picked.basis, picked.modal.shapes)
        rows[:-1] = np.column_stack([form.bending, form.residual, form.rest])
        rows[-1, -2:] = picked.modal.axial / form.area, form.tension
    return tables


def record(model, pulse, amplitude, f0, damping, dt, steps, start=FIRST):
    """Follow one cell as `follow_all` does, bit for bit, and show every step of it.

    model: of one device; dt: us; returns Form, and Motion of one WINDOW after another
    """
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
    """Motion of a window of `_pairs`; shrink: coordinates over those of the kernel."""
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
        yield first, before.T, after.T


def coefficients(model, target, start=FIRST):
    """Build a row for each device, in the order of the rows of X, with forces times dt^2.

    model: a `Model`; start: as in `Settings`
    target: where a run counts as snapped, as from `Model.snap_target`; -inf for never
    """
    device, modal, barrier = model.device, model.modal, model.barrier
    side, n, k = SIDE[start], len(device), model.modes
    numbers = {
        R.AXIAL: modal.axial,
        R.RESIDUAL: modal.residual,
        R.CONTACT: contact_stiffness(device, modal.residual),
        R.M: device.mass,
        R.K: device.spring,
        R.TARGET: target,
        R.BARRIER: barrier.energy,
        R.SADDLE: side * barrier.midpoint,
        R.Z0: device.gap,
        R.ALPHA: device.beam.damping,
        R.STOP_TOWARD: device.stop_toward,
        R.STOP_AWAY: device.stop_away,
        R.RESTITUTION: device.restitution,
        R.SIDE: side,
    }
    vectors = modal.stiffness, modal.slope_start, modal.load, modal.midpoint  # KAPPA, SQ0, F, E
    columns = [np.broadcast_to(numbers[row], n)[:, np.newaxis] for row in sorted(numbers)]
    columns += [np.reshape(vector, (n, k)) for vector in vectors]
    columns += [np.reshape(modal.geometric, (n, k * k)), np.reshape(model.rest(start), (n, k))]
    return np.concatenate(columns, axis=1)


def in_lanes(follow, lengths, threads):
    """Call `follow` for LANES cells at a time, by indices in order of their lengths, (cells,)."""
    # Lanes run together to the end of the longest: those of one call should be of one length.
    order = np.argsort(lengths, kind="stable")
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(R.LANES, order.size, R.LANES))))


def empty_lanes(model):
    """Make the work array and the shape that the kernels of a model take, empty."""
    padded = np.zeros((R.VECTORS + (R.S + model.modes) * model.modes) * R.LANES + 8)
    # Wide vector loads are fastest from the start of a cache line.
    X = padded[(-padded.ctypes.data // 8) % 8 :][: padded.size - 8]
    return X, (0,) * model.modes

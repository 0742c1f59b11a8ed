"""A lane's life: a cell is loaded into it, looked at after each block, judged, and makes room."""

from typing import NamedTuple

import numpy as np

from ...numerics.kept_kernels import compiled, inlined
from . import rows as R
from .energy import ledger, proven_well
from .pulse import begin_pulse
from .rows import LANES, at, row

MARGIN = 2.0
"""A proof must hold by this many times the largest residual of the energy ledger seen so far."""
ROUNDING = 1e-12
"""And by this share of the barrier: what rounding does to both, and more; docs/rigour.md."""
ADDED = 0.25
"""Inertia, over the stiffness times dt^2, that means of linear forces over three instants add."""
OPENED = 4.0
"""A run is given up at the look at which its ledger misses by this many times the tolerance."""


class Facts(NamedTuple):
    """What is found of each cell, (cells,); modified in place.

    t_snap, t_settled: us, NaN if not seen
    well: 1 or 2, the side of the saddle at the end; 0 where the run ended before its pulse or at
        its snap
    energy_error: residual of the energy ledger over the gross work of the pulse, not finite after
        a blow-up
    well_share: share of the mass's last swing spent on that side, 1 if proven; NaN for well 0
    pulse_work: of the whole pulse, pJ; NaN if the run ended before
    """

    t_snap: np.ndarray
    t_settled: np.ndarray
    well: np.ndarray
    energy_error: np.ndarray
    well_share: np.ndarray
    pulse_work: np.ndarray


class Task(NamedTuple):
    """Cells to follow, and what for.

    devices: their coefficients, (n_devices, coefficients), as `simd_loop.coefficients` has them
    pulses: as in `numerics.pieces`, over x = f0 t: the pieces of all, (pieces, 6), where each one's
        begin and end, (pulses + 1,), and what it begins and ends with, (pulses, 2)
    device, pulse: the number of each cell's; amplitude: um/us^2; f0: 1/us; damping: C, uN us/um;
        t_end, dt: us; (cells,)
    stop_at_snap, stop_after_pulse: whether a run ends there, too
    tolerance: of the ledger, over the gross work of the pulse; a run that exceeds it is given up
    """

    devices: np.ndarray
    pulses: tuple[np.ndarray, np.ndarray, np.ndarray]
    device: np.ndarray
    pulse: np.ndarray
    amplitude: np.ndarray
    f0: np.ndarray
    damping: np.ndarray
    t_end: np.ndarray
    dt: np.ndarray
    stop_at_snap: bool
    stop_after_pulse: bool
    tolerance: float
    facts: Facts


class Look(NamedTuple):
    """What a look at a lane shows.

    in_pulse: whether the pulse still acts; snapped: whether the midpoint has been at the target
    well: the one proven, or 0; w: where the energy is known; residual: of the ledger
    """

    in_pulse: bool
    snapped: bool
    well: int
    w: float
    residual: float


@inlined
def begin(X, shape, l, task, state, cell):
    """Begin to follow a cell in lane l."""
    device, dt = task.devices[task.device[cell]], task.dt[cell]
    load(X, shape, l, device, task.damping[cell], task.amplitude[cell], dt)
    begin_pulse(X, l, state, task.pulses, task.pulse[cell], task.f0[cell] * dt)
    swing = 2 * np.pi * np.sqrt(X[row(R.MASS, l)] / X[row(R.SPRING, l)])
    X[row(R.LAST_SWING, l)] = task.t_end[cell] / dt - swing


@compiled
def load(X, shape, l, device, damping, amplitude, dt):
    """Put a cell at rest into lane l.

    device: as `simd_loop.coefficients` has it; damping: C, uN us/um; amplitude: um/us^2; dt: us
    """
    X[l::LANES] = 0.0
    drag = damping * dt / 2
    for name in range(R.AXIAL, R.RESTITUTION + 1):
        X[row(name, l)] = device[name]
    for name in (R.AXIAL, R.CONTACT, R.SPRING, R.BARRIER):
        X[row(name, l)] *= dt * dt
    X[row(R.RESIDUAL, l)] /= dt * dt
    X[row(R.BEAM_DAMPING, l)] *= dt
    load_modes(X, shape, l, device[R.RESTITUTION + 1 :], dt * dt)
    X[row(R.OVERLAP, l)] = 0.0 - X[row(R.GAP, l)]
    X[row(R.AMPLITUDE, l)] = amplitude * dt**2
    mass = X[row(R.MASS, l)] + ADDED * X[row(R.SPRING, l)]
    X[row(R.KEEP, l)] = (mass - drag) / (mass + drag)
    X[row(R.MOBILITY, l)] = 1 / (mass + drag)
    beam_drag = X[row(R.BEAM_DAMPING, l)] / 2
    X[row(R.BEAM_KEEP, l)] = (1 - beam_drag) / (1 + beam_drag)
    X[row(R.BEAM_MOBILITY, l)] = b = 1 / (1 + beam_drag)
    ee = 0.0
    for i in range(len(shape)):
        ee += X[at(R.MIDPOINT, i, len(shape), l)] ** 2
    X[row(R.HALF_CONTACT, l)] = X[row(R.CONTACT, l)] / 2
    X[row(R.TENSION, l)] = gamma = b * X[row(R.AXIAL, l)] / 2
    X[row(R.SOFTENING, l)] = b * gamma / 2
    X[row(R.COMPLIANCE, l)] = (b * ee + X[row(R.MOBILITY, l)]) / 2


@inlined
def load_modes(X, shape, l, of_modes, square):
    """The vectors of a device, in coordinates in which every mode has mass 1.

    A mode is heavier by kappa dt^2/4: its coordinate is stretched by 1/s,
    s^2 = 1/(1 + kappa dt^2/4); square: dt^2
    """
    modes = len(shape)
    for i in range(modes):
        stiffness = square * of_modes[i]
        s = 1 / np.sqrt(1 + ADDED * stiffness)
        X[at(R.STIFFNESS, i, modes, l)] = stiffness * (s * s)
        for v in range(R.SLOPE_START, R.GEOMETRIC):
            X[at(v, i, modes, l)] = s * of_modes[(v - R.STIFFNESS) * modes + i]
        X[at(R.SCRATCH, i, modes, l)] = s
    for i in range(modes):
        for j in range(modes):
            element = of_modes[(R.GEOMETRIC - R.STIFFNESS + i) * modes + j]
            both = X[at(R.SCRATCH, i, modes, l)] * X[at(R.SCRATCH, j, modes, l)]
            X[at(R.GEOMETRIC + i, j, modes, l)] = both * element


@inlined
def look(X, shape, l, cell, state, task):
    """Whether the run in lane l is over, after a block; then its facts are written."""
    steps, dt = state.steps[l], task.dt[cell]
    if steps <= X[row(R.LAST_SWING, l)]:
        X[row(R.SINCE, l)], X[row(R.BEYOND_SINCE, l)] = steps, X[row(R.BEYOND, l)]
    snapped = X[row(R.W, l)] <= X[row(R.TARGET, l)]
    in_pulse = steps - 1 < state.lasts[l]
    stopped = snapped and task.stop_at_snap
    ended = steps * dt > task.t_end[cell] or not np.isfinite(X[row(R.Y, l)]) or stopped
    ended |= task.stop_after_pulse and not in_pulse
    if in_pulse and not ended:
        return False

    drag, gross_work = task.damping[cell] * dt, X[row(R.GROSS_WORK, l)] / 2
    scale, well = 1 / gross_work if gross_work > 0 else 1.0, 0
    beam, mass, contact, w, residual = ledger(X, shape, l, drag)
    if not in_pulse:
        worst = max(X[row(R.WORST, l)], abs(residual))
        X[row(R.WORST, l)] = worst
        margin = MARGIN * worst + ROUNDING * X[row(R.BARRIER, l)]
        well = proven_well(X, l, (beam, mass, contact, w), margin)
        ended |= not abs(residual) * scale <= OPENED * task.tolerance
    if not (well == 1 or snapped):
        well = 0
    if not ended and well == 0:
        return False
    task.facts.energy_error[cell] = abs(residual) * scale
    judge(X, l, cell, state, task, Look(in_pulse, snapped, well, w, residual))
    return True


@inlined
def judge(X, l, cell, state, task, seen):
    """Write the facts of the cell in lane l, whose run is over."""
    facts, steps, dt = task.facts, state.steps[l], task.dt[cell]
    is_whole, proven = steps >= state.lasts[l], seen.well != 0
    facts.pulse_work[cell] = X[row(R.WORK, l)] / (2 * dt**2) if is_whole else np.nan
    facts.t_snap[cell] = snap_time(X, l, dt) if seen.snapped else np.nan
    ends_at_snap = seen.snapped and task.stop_at_snap
    facts.t_settled[cell] = (steps - 1) * dt if proven and not ends_at_snap else np.nan
    if seen.in_pulse or ends_at_snap:
        facts.well[cell], facts.well_share[cell] = 0, np.nan
        return
    share = (X[row(R.BEYOND, l)] - X[row(R.BEYOND_SINCE, l)]) / (steps - X[row(R.SINCE, l)])
    is_second = seen.well == 2 if proven else not seen.w > X[row(R.SADDLE, l)]
    facts.well[cell] = 2 if is_second else 1
    facts.well_share[cell] = 1.0 if proven else share if is_second else 1 - share


@inlined
def snap_time(X, l, dt):
    """Time at which w passed the target, linear between the two instants around it."""
    before, after = X[row(R.W_BEFORE, l)], X[row(R.W, l)]
    fraction = (before - X[row(R.TARGET, l)]) / (before - after)
    return (X[row(R.COUNT, l)] - 2 + fraction) * dt


@inlined
def make_room(X, l, state):
    """Leave lane l empty, at rest and without a shock."""
    state.lasts[l] = 0
    X[l::LANES] = 0.0

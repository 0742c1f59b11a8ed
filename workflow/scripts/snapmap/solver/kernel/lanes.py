"""Cells in lanes: loaded, checked by their energies after each block, and replaced when done."""

from typing import NamedTuple

import numpy as np

from ...numerics.kernels import called, compiled, inlined, sine, widen_vectors
from . import rows as R
from .access import numbers, vectors
from .laws import CONTACT, FORCE, LaneLaws, begin_laws, drives
from .pulse import BLOCK, Pulses, PulseState, begin_pulse, no_pulse, set_out
from .quiet import blocks_left, jump
from .rows import LANES, Rows, Shape
from .step import advance

Parts = tuple[float, float, float, float]
"""Energies of beam, mass and contact, and w."""
MARGIN = 2.0
"""Margin of a proof over the largest residual of the energy ledger so far."""
ROUNDING = 1e-12
"""Further margin of a proof over the barrier, larger than errors of rounding."""
EXACT = 2.0
"""Radians per step up to which a free mode swings exactly; faster modes swing too slowly."""
CALM_ENERGY = 1.0
"""Energy of a beam over its barrier below which a run that has snapped takes long steps again."""
OPENED = 4.0
"""Residual of the ledger over its tolerance at which a run is given up."""


class Facts(NamedTuple):
    """Observations of a kernel, as in `Observations`; (cells,), modified in place.

    They are listed here again, as kernels on disk are named by the sources of this folder: a change
    of `Observations` would go unnoticed.
    """

    t_snap: np.ndarray
    t_settled: np.ndarray
    well: np.ndarray
    energy_error: np.ndarray
    well_share: np.ndarray
    pulse_work: np.ndarray
    lowest: np.ndarray


class Task(NamedTuple):
    """Cells to follow, when to stop, and room for their facts.

    devices: (devices, coefficients), as `coefficients` returns them
    pulses: pieces, bounds and ends, as `pulse.table` returns them, over x = f0 t
    device, ..., t_end: as in `Cells`; dt: step, us; each (cells,)
    dt_excited, dt_calm: step of a cell that has snapped, us, (cells,); see CALM_ENERGY
    stop_at_snap: whether a run ends there too
    tolerance: of the ledger, over the gross work of the pulse; see OPENED
    """

    devices: np.ndarray
    pulses: Pulses
    device: np.ndarray
    pulse: np.ndarray
    amplitude: np.ndarray
    f0: np.ndarray
    damping: np.ndarray
    t_end: np.ndarray
    dt: np.ndarray
    dt_excited: np.ndarray
    dt_calm: np.ndarray
    stop_at_snap: bool
    tolerance: float
    facts: Facts


@compiled
def load(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    l: int,
    device: np.ndarray,
    damping: float,
    amplitude: float,
    dt: float,
) -> None:
    """Put a cell at rest into lane l, in coordinates in which every mode has mass 1.

    The scheme gives a mode the inertia G = g + kappa dt^2/4, with g = (x/2 cot x/2)^2 and x = omega
    dt, at most EXACT; so its coordinate is stretched by 1/s = sqrt(G).
    laws: `LaneLaws` or None; device: row of `coefficients`
    damping: C, uN us/um; amplitude: um/us^2; dt: us
    """
    work[l::LANES] = 0.0
    modes = len(shape)
    X, V = numbers(work), vectors(work, modes)
    drag, square, of_modes = damping * dt / 2, dt * dt, device[R.SIDE + 1 :]
    for name in range(R.AXIAL, R.SIDE + 1):
        X[name, l] = device[name]
    for name in (R.AXIAL, R.CONTACT, R.K, R.BARRIER, R.BARRIER_APART):
        X[name, l] *= square
    X[R.RESIDUAL, l] /= square
    X[R.ALPHA, l] *= dt
    X[R.C, l], X[R.DT, l] = damping, dt
    for i in range(modes):
        stiffness = square * of_modes[i]
        s = shrinking(stiffness)
        V[R.KAPPA, i, l] = stiffness * (s * s)
        for v in range(R.SQ0, R.S):
            V[v, i, l] = s * of_modes[(v - R.KAPPA) * modes + i]
        V[R.U, i, l] = s
    for i in range(modes):
        for j in range(modes):
            element = of_modes[(R.S - R.KAPPA + i) * modes + j]
            both = V[R.U, i, l] * V[R.U, j, l]
            V[R.S + i, j, l] = both * element
        V[R.P, i, l] = of_modes[(R.S - R.KAPPA + modes) * modes + i] / V[R.U, i, l]
    X[R.AMPLITUDE, l] = amplitude * square
    mass = X[R.M, l] + X[R.K, l] / 4
    X[R.KEEP, l] = (mass - drag) / (mass + drag)
    X[R.B, l] = 1 / (mass + drag)
    beam_drag = X[R.ALPHA, l] / 2
    X[R.BEAM_KEEP, l] = (1 - beam_drag) / (1 + beam_drag)
    X[R.BEAM_B, l] = b = 1 / (1 + beam_drag)
    ee = 0.0
    for i in range(modes):
        ee += V[R.E, i, l] ** 2
    X[R.HALF_CONTACT, l] = X[R.CONTACT, l] / 2
    X[R.GAMMA, l] = gamma = b * X[R.AXIAL, l] / 2
    X[R.SOFTENING, l] = b * gamma / 2
    X[R.COMPLIANCE, l] = (b * ee + X[R.B, l]) / 2
    begin(X, V, modes, l, laws)


@inlined
def shrinking(stiffness: float) -> float:
    """Return s of `load`; stiffness: of a mode, times dt^2."""
    half = min(np.sqrt(stiffness), EXACT) / 2
    root = half * sine(half / (2 * np.pi) + 0.25) / sine(half / (2 * np.pi))
    return 1 / np.sqrt(root * root + stiffness / 4)


@inlined
def begin(X: Rows, V: Rows, modes: int, l: int, laws: LaneLaws | None) -> None:
    """Set the state of lane l that follows from its modes P, which are at rest."""
    w = 0.0
    for i in range(modes):
        u = 2 * V[R.SQ0, i, l]
        for j in range(modes):
            u += V[R.S + i, j, l] * V[R.P, j, l]
        X[R.Q, l] += u * V[R.P, i, l]
        w += V[R.E, i, l] * V[R.P, i, l]
    X[R.OVERLAP, l] = w - X[R.Z0, l]
    if laws is not None:
        begin_laws(X, l, laws, w)
    X[R.W, l] = X[R.LOWEST, l] = X[R.SIDE, l] * w
    X[R.AT_START, l] = total(X, V, modes, l)


@inlined
def check_lane(
    X: Rows,
    V: Rows,
    modes: int,
    l: int,
    laws: LaneLaws | None,
    cell: int,
    state: PulseState,
    task: Task,
) -> bool:
    """Return whether the run in lane l is over, after a block; if it is, write its facts."""
    steps, dt = state.steps[l], X[R.DT, l]
    if steps <= X[R.LAST_SWING, l]:
        X[R.SINCE, l], X[R.BEYOND_SINCE, l] = steps, X[R.BEYOND, l]
    snapped = X[R.W, l] <= X[R.TARGET, l]
    in_pulse = steps - 1 < state.lasts[l]
    stopped = snapped and task.stop_at_snap
    ended = steps * dt > task.t_end[cell] or not np.isfinite(X[R.Y, l]) or stopped
    if in_pulse and not ended:
        return False

    drag, gross_work = task.damping[cell] * dt, X[R.GROSS_WORK, l] / 2
    scale, well = 1 / gross_work if gross_work > 0 else 1.0, 0
    beam, mass, contact, w, residual = ledger(X, V, modes, l, drag)
    if not in_pulse:
        worst = max(X[R.WORST, l], abs(residual))
        X[R.WORST, l] = worst
        margin = MARGIN * worst + ROUNDING * X[R.BARRIER, l]
        well = proven_well(X, l, (beam, mass, contact, w), margin)
        if laws is not None and laws.damping != 0 and well != 0:
            energy = beam + mass + contact + margin
            speed = np.sqrt(2 * energy / X[R.M, l]) / dt
            if drives(laws, task.damping[cell], speed, np.sqrt(2 * energy / X[R.K, l])):
                X[R.WORST, l], well = np.inf, 0
        ended |= not abs(residual) * scale <= OPENED * task.tolerance
    if not (well == 1 or snapped):
        well = 0
    if not ended and well == 0:
        return False

    # Facts are unpacked only here: references to their arrays take 7 % of a run.
    facts, proven = task.facts, well != 0
    facts.energy_error[cell] = abs(residual) * scale
    facts.pulse_work[cell] = X[R.WORK, l] / (2 * dt**2) if steps >= state.lasts[l] else np.nan
    # Linear between the two instants around the target, in steps of before the snap.
    before, after = X[R.W_BEFORE, l], X[R.W, l]
    passed = X[R.COUNT, l] - 2 + (before - X[R.TARGET, l]) / (before - after)
    facts.t_snap[cell] = passed * task.dt[cell] if snapped else np.nan
    facts.t_settled[cell] = (steps - 1) * dt if proven and not stopped else np.nan
    facts.lowest[cell] = X[R.LOWEST, l]
    facts.well[cell], facts.well_share[cell] = 0, np.nan
    if not in_pulse and not stopped:
        share = (X[R.BEYOND, l] - X[R.BEYOND_SINCE, l]) / (steps - X[R.SINCE, l])
        is_second = well == 2 if proven else not X[R.SIDE, l] * w > X[R.SADDLE, l]
        facts.well[cell] = 2 if is_second else 1
        facts.well_share[cell] = 1.0 if proven else share if is_second else 1 - share
    return True


@inlined
def half_step_midpoint(V: Rows, modes: int, l: int) -> float:
    """Return e.p at the last half step."""
    w = 0.0
    for i in range(modes):
        d, p = V[R.D, i, l], V[R.P, i, l]
        w += V[R.E, i, l] * (p - d / 2)
    return w


@inlined
def energies(X: Rows, V: Rows, modes: int, l: int) -> Parts:
    """Return the energies of beam, mass and contact, whose sum `advance` conserves, and w.

    They hold at the last half step, where products of two instants replace squares.
    """
    beam = X[R.AXIAL, l] * X[R.Q, l] ** 2 / 4 + X[R.ENERGY + FORCE, l]
    for i in range(modes):
        d, p = V[R.D, i, l], V[R.P, i, l]
        beam += d * d / 2 + V[R.KAPPA, i, l] * p * (p - d) / 2
    d, y = X[R.DY, l], X[R.Y, l]
    middle = y - d / 2
    mass = X[R.M, l] * d * d / 2 + X[R.K, l] * middle * middle / 2
    w = half_step_midpoint(V, modes, l)
    contact = X[R.CONTACT, l] * max(0.0, X[R.OVERLAP, l]) ** 2 / 2 + X[R.ENERGY + CONTACT, l]
    return beam, mass, contact, w


@inlined
def half_step_stretch(V: Rows, modes: int, l: int) -> float:
    """Return q at the last half step, as in `advance`."""
    q = 0.0
    for i in range(modes):
        u = V[R.SQ0, i, l]
        for j in range(modes):
            u += V[R.S + i, j, l] * V[R.P, j, l]
        q += (V[R.P, i, l] - V[R.D, i, l]) * u + V[R.P, i, l] * V[R.SQ0, i, l]
    return q


@inlined
def total(X: Rows, V: Rows, modes: int, l: int) -> float:
    """Return the sum of `energies`."""
    beam, mass, contact, _ = energies(X, V, modes, l)
    return beam + mass + contact


@inlined
def ledger(X: Rows, V: Rows, modes: int, l: int, drag: float) -> tuple[float, ...]:
    """Return `energies`, and energy + losses - work of the pulse - energy at start; drag: C dt."""
    beam, mass, contact, w = energies(X, V, modes, l)
    swept = drag * X[R.SWEPT, l] + X[R.ALPHA, l] * X[R.BEAM_SWEPT, l]
    energy = beam + mass + contact + X[R.LOST, l]
    return beam, mass, contact, w, energy + swept / 4 - X[R.WORK, l] / 2 - X[R.AT_START, l]


@inlined
def proven_well(X: Rows, l: int, parts: Parts, margin: float) -> int:
    """Return the well that the beam can never leave without a shock, or 0 if that is open.

    Well 1 is that of the start, 2 the other. Energy only falls after the pulse. The beam cannot
    leave if all energy is below the barrier; nor can it leave the well below the saddle if its own
    energy is below the barrier and the mass on its spring cannot swing as low as the saddle.

    parts: as `energies` returns them; margin: energy by which a proof must hold
    """
    beam, mass, contact, w = parts
    barrier, side = X[R.BARRIER, l], X[R.SIDE, l]
    saddle, well = side * X[R.SADDLE, l], 1 if side * w > X[R.SADDLE, l] else 2
    if beam + mass + contact + margin < barrier:
        return well
    lowest_mass = -np.sqrt(2 * (mass + margin) / X[R.K, l])
    if beam + margin < X[R.BARRIER_APART, l] and w < saddle < lowest_mass + X[R.Z0, l]:
        return well
    return 0


@called
def change_step(
    work: np.ndarray,
    shape: Shape,
    laws: LaneLaws | None,
    l: int,
    dt: float,
    cell: int,
    state: PulseState,
    task: Task,
) -> None:
    """Go on with lane l in steps of dt, us, or a little shorter, from its last half step.

    There p, y and the overlap stay, and so do all energies but that of the stretch: in a step that
    turns a mode by x it moves as tan(x/2), with kappa = 4 sin^2(x/2).
    """
    X, V, modes = numbers(work), vectors(work, len(shape)), len(shape)
    device, old, was = task.devices[task.device[cell]], np.empty(R.VECTORS), X[R.DT, l]
    if laws is not None:
        begin_laws(X, l, laws, half_step_midpoint(V, modes, l))
    stored, motion, steps = total(X, V, modes, l), np.empty((2, modes)), 0
    for row in range(R.VECTORS):
        old[row] = X[row, l]
    for i in range(modes):
        s, kappa = shrinking(was * was * device[R.SIDE + 1 + i]), V[R.KAPPA, i, l]
        motion[0, i] = s * (V[R.P, i, l] - V[R.D, i, l] / 2)
        motion[1, i] = s * V[R.D, i, l] * np.sqrt((4 - kappa) / kappa)
    # A run that begins is at rest and may begin anew.
    if state.steps[l] > 0:
        halfway = (state.steps[l] - 0.5) * was
        steps = int(np.ceil(halfway / dt + 0.5))
        dt = halfway / (steps - 0.5)

    load(work, shape, laws, l, device, task.damping[cell], task.amplitude[cell], dt)
    begin_pulse(work, l, state, task.pulses, task.pulse[cell], task.f0[cell] * dt)
    state.steps[l], share = steps, dt / was
    for row in (R.LAST_SWING, R.SINCE, R.BEYOND_SINCE, R.BEYOND):
        X[row, l] = old[row] / share
    for row in (R.SWEPT, R.BEAM_SWEPT, R.DY, R.DY_BEFORE):
        X[row, l] = old[row] * share
    for row in (R.WORST, R.AT_START, R.WORK, R.GROSS_WORK, R.LOST):
        X[row, l] = old[row] * share**2
    for row in (R.LOWEST, R.OVERLAP, R.W, R.W_BEFORE, R.COUNT):
        X[row, l] = old[row]
    X[R.Y, l] = old[R.Y] - old[R.DY] / 2 + X[R.DY, l] / 2
    for i in range(modes):
        s, kappa = shrinking(dt * dt * device[R.SIDE + 1 + i]), V[R.KAPPA, i, l]
        V[R.D, i, l] = motion[1, i] / s * np.sqrt(kappa / (4 - kappa))
        V[R.P, i, l] = motion[0, i] / s + V[R.D, i, l] / 2
    X[R.Q, l] = half_step_stretch(V, modes, l)
    if laws is not None:
        begin_laws(X, l, laws, half_step_midpoint(V, modes, l))
    X[R.AT_START, l] += total(X, V, modes, l) - stored * share**2


@inlined
def take_back(work: np.ndarray, l: int, begun: np.ndarray, state: PulseState) -> None:
    """Take lane l back to the begin of the last block, but for its snap, which stays observed.

    begun: rows of the work array from STATE to before U, as the block began
    """
    X = numbers(work)
    w, w_before, count = X[R.W, l], X[R.W_BEFORE, l], X[R.COUNT, l]
    # Copied one by one: to compile an assignment of a slice takes numba seconds.
    for place in range(l, begun.size, LANES):
        work[R.STATE * LANES + place] = begun[place]
    X[R.W, l], X[R.W_BEFORE, l], X[R.COUNT, l] = w, w_before, count
    X[R.DY_BEFORE, l] = X[R.DY, l]
    state.steps[l] -= BLOCK


@called
def leave_out(work: np.ndarray, shape: Shape, l: int, state: PulseState, pulses: Pulses) -> None:
    """Let lane l jump over quiet time, after a block within its pulse."""
    X, V = numbers(work), vectors(work, len(shape))
    blocks = blocks_left(X, l, state, pulses)
    if blocks > 0:
        H = total(X, V, len(shape), l)
        jump(work, shape, l, blocks, state, H, X[R.C, l] * X[R.DT, l])


@compiled
def follow_all(
    work: np.ndarray, shape: Shape, laws: LaneLaws | None, leaps: tuple[()] | None, task: Task
) -> None:
    """Follow all cells of a `Task`, each until its well is proven or t_end is past.

    Once a cell has snapped its steps are `dt_excited`, and `dt_calm` while its beam is calm.

    leaps: () if runs leave out quiet time, else None, by whose type they are compiled without it
    """
    widen_vectors()
    work[:] = 0.0
    X, V = numbers(work), vectors(work, len(shape))
    cell_in, state, shocks = np.full(LANES, -1), no_pulse(), np.zeros(BLOCK * LANES)
    next_cell, running, was_shocked = 0, 0, False
    lively = work[R.STATE * LANES : (R.VECTORS + R.U * len(shape)) * LANES]
    begun = lively.copy()
    while next_cell < task.dt.size or running > 0:
        is_shocked = False
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < task.dt.size:
                cell_in[l] = cell = next_cell
                device, dt = task.devices[task.device[cell]], task.dt[cell]
                load(work, shape, laws, l, device, task.damping[cell], task.amplitude[cell], dt)
                begin_pulse(work, l, state, task.pulses, task.pulse[cell], task.f0[cell] * dt)
                swing = 2 * np.pi * np.sqrt(X[R.M, l] / X[R.K, l])
                X[R.LAST_SWING, l] = task.t_end[cell] / dt - swing
                next_cell += 1
                running += 1
            is_shocked |= state.steps[l] < state.lasts[l]
        if is_shocked or was_shocked:
            set_out(work, shocks, state, task.pulses)
        was_shocked = is_shocked
        for place in range(begun.size):
            begun[place] = lively[place]
        advance(work, shape, laws, shocks, 0, BLOCK)
        for l in range(LANES):
            cell = cell_in[l]
            if cell < 0:
                continue
            state.steps[l] += BLOCK
            if check_lane(X, V, len(shape), l, laws, cell, state, task):
                # An empty lane is at rest and without a shock.
                work[l::LANES] = 0.0
                cell_in[l], state.lasts[l] = -1, 0
                running -= 1
                continue
            is_short, was_short, dt = False, X[R.SHORT, l] == 1.0, task.dt[cell]
            if X[R.W, l] <= X[R.TARGET, l] and task.dt_excited[cell] < dt:
                # The snap is seen up to a block late, and the energy that it frees later.
                is_late = state.steps[l] * X[R.DT, l] > (X[R.COUNT, l] + BLOCK) * dt
                energy = energies(X, V, len(shape), l)[0]
                is_short = not (is_late and energy < CALM_ENERGY * X[R.BARRIER, l])
            if is_short and not was_short:
                take_back(work, l, begun, state)
                change_step(work, shape, laws, l, task.dt_excited[cell], cell, state, task)
                X[R.SHORT, l] = 1.0
            elif was_short and not is_short:
                change_step(work, shape, laws, l, task.dt_calm[cell], cell, state, task)
            elif leaps is not None and state.steps[l] < state.lasts[l]:
                leave_out(work, shape, l, state, task.pulses)

"""Cells followed for their motion, kept in bins."""

from typing import NamedTuple

import numpy as np

from ...numerics.kernels import compiled, inlined, widen_vectors
from . import rows as R
from .lanes import energies, half_step_midpoint, load
from .pulse import BLOCK, begin_pulse, no_pulse, set_out
from .rows import LANES, numbers, vectors
from .step import advance, rebound

# ASSUME: a trace looks at every fourth instant; the ringing of w has some forty to a period.
SAMPLE = 4
"""Steps between two looks at w for a trace; a divisor of BLOCK."""


class Bins(NamedTuple):
    """What a trace keeps; modified in place.

    w_range: least and greatest w(L/2) from rest in each bin, (2, bins, cells)
    instants: at each bin's start y, all energy and the beam's (pJ), (3, bins, cells)
    bin, begin: of each lane the number of its bin, and the step at which the next one begins
    low, high: w in that bin so far; (LANES,)
    stress: largest of each cell, MPa, (cells,)
    """

    w_range: np.ndarray
    instants: np.ndarray
    bin: np.ndarray
    begin: np.ndarray
    low: np.ndarray
    high: np.ndarray
    stress: np.ndarray


@compiled
def trace_all(work, shape, devices, dt, pulses, cells, stress, kept):
    """Follow up to LANES cells as `follow_all` does, bit for bit, and keep their motion in bins.

    Half way between two instants, where energies are known.

    work: zeros; devices: each cell's row of coefficients, with target -inf, so that row W is never
        latched; dt: each cell's, us; pulses: as in `Task`
    cells: pulse, amplitude, f0 and damping as in `Task`, and width, steps of one bin, a multiple
        of SAMPLE; (cells,)
    stress: of each cell as in `simd_loop.stress_rows`, modified in place; of no cell if left out
    kept: w_range, instants and stress, as in `Bins`; modified in place
    """
    widen_vectors()
    pulse, amplitude, f0, damping, width = cells
    modes = len(shape)
    X, V = numbers(work), vectors(work, modes)
    state, shocks = no_pulse(), np.zeros(BLOCK * LANES)
    for l in range(width.size):
        load(work, shape, l, devices[l], damping[l], amplitude[l], dt[l])
        begin_pulse(work, l, state, pulses, pulse[l], f0[l] * dt[l])
    for l in range(len(stress)):
        for place in range(stress.shape[1] - 1):
            for i in range(modes):
                stress[l, place, i] *= V[R.U, i, l]
    y, number, begin = np.empty(LANES), np.full(LANES, -1), np.zeros(LANES, np.int64)
    bins = Bins(*kept[:2], number, begin, np.empty(LANES), np.empty(LANES), kept[2])
    for step in range(0, kept[0].shape[1] * width.max(), SAMPLE):
        in_block = step % BLOCK
        if in_block == 0:
            state.steps[:] = step
            set_out(work, shocks, state, pulses)
        rebound(work)
        for l in range(width.size):
            y[l] = X[R.Y, l]
        advance(work, shape, shocks, in_block, 1)
        for l in range(width.size):
            if begin[l] == step:
                begin_bin(X, V, modes, l, bins, dt[l], y[l])
                begin[l] += width[l]
        widen(X, V, modes, bins.low, bins.high)
        for ahead in range(SAMPLE):
            if ahead > 0:
                advance(work, shape, shocks, in_block + ahead, 1)
            for l in range(len(stress)):
                if bins.bin[l] < bins.instants.shape[1]:
                    most = largest_stress(X, V, modes, l, stress[l])
                    bins.stress[l] = max(bins.stress[l], most)
    for l in range(width.size):
        keep_range(bins, l)


@compiled
def keep_block(work, shape, shocks, before, after):
    """Advance by a block and keep lane 0 before and after each step, (steps, rows), in place."""
    widen_vectors()
    for step in range(before.shape[0]):
        rebound(work)
        for i in range(before.shape[1]):
            before[step, i] = work[(R.STATE + i) * LANES]
        advance(work, shape, shocks, step, 1)
        for i in range(before.shape[1]):
            after[step, i] = work[(R.STATE + i) * LANES]


@compiled
def keep_midpoints(work, shape, state, pulses, first, midpoints):
    """Advance all lanes and keep w(L/2) from rest half way through each step, (steps, LANES).

    first: steps done, a multiple of BLOCK; midpoints: modified in place
    """
    widen_vectors()
    modes = len(shape)
    X, V, shocks = numbers(work), vectors(work, modes), np.zeros(BLOCK * LANES)
    for step in range(midpoints.shape[0]):
        if step % BLOCK == 0:
            state.steps[:] = first + step
            set_out(work, shocks, state, pulses)
        rebound(work)
        advance(work, shape, shocks, step % BLOCK, 1)
        for l in range(LANES):
            midpoints[step, l] = seen_midpoint(X, V, modes, l)


@inlined
def begin_bin(X, V, modes, l, bins, dt, y):
    """Keep the bin of lane l, and begin the next one; y: before the step."""
    keep_range(bins, l)
    bins.bin[l] += 1
    bins.low[l], bins.high[l] = np.inf, -np.inf
    bin = bins.bin[l]
    if bin < bins.instants.shape[1]:
        beam, mass, contact, _ = energies(X, V, modes, l)
        bins.instants[0, bin, l] = y + X[R.DY, l] / 2
        bins.instants[1, bin, l] = (beam + mass + contact) / dt**2
        bins.instants[2, bin, l] = beam / dt**2


@inlined
def widen(X, V, modes, low, high):
    """Take w of every lane into the range of its bin."""
    for l in range(LANES):
        w = seen_midpoint(X, V, modes, l)
        low[l] = w if w < low[l] else low[l]
        high[l] = w if w > high[l] else high[l]


@inlined
def seen_midpoint(X, V, modes, l):
    """w(L/2) from rest of lane l half way through the step, um."""
    return half_step_midpoint(V, modes, l) - X[R.RESIDUAL, l] * pressed(X, l)


@inlined
def largest_stress(X, V, modes, l, rows):
    """The largest tensile stress of lane l half way through the step, MPa.

    rows: bending at each place, per coordinate, per contact force and at rest; and axial, per
    stretch and at rest
    """
    places = len(rows) - 1
    stretch, contact = X[R.Q, l], pressed(X, l)
    most = 0.0
    for place in range(places):
        bent = rows[place, modes + 1] - rows[place, modes] * contact
        for i in range(modes):
            p = V[R.P, i, l] - 0.5 * V[R.D, i, l]
            bent += rows[place, i] * p
        most = max(most, abs(bent))
    return most + rows[places, modes] * stretch + rows[places, modes + 1]


@inlined
def pressed(X, l):
    """The contact force at the last half step, times dt^2."""
    overlap = X[R.OVERLAP, l]
    return X[R.CONTACT, l] * (overlap if overlap > 0.0 else 0.0)


@inlined
def keep_range(bins, l):
    """Set the least and greatest w of a bin, unless it lies before the first or after the last."""
    bin = bins.bin[l]
    if 0 <= bin < bins.w_range.shape[1]:
        bins.w_range[0, bin, l], bins.w_range[1, bin, l] = bins.low[l], bins.high[l]

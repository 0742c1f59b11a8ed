"""What rounding does to the energies of the kernel: its own lines, in floats and in balls."""

from types import FunctionType, SimpleNamespace
from typing import NamedTuple

import numpy as np
from flint import arb

from snapmap.pulse import table
from snapmap.solver import simd_loop
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.energy import energies
from snapmap.solver.kernel.lanes import load
from snapmap.solver.kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.kernel.step import advance

from . import passes


class Look(NamedTuple):
    """Of one look at a run, over the barrier; balls.

    energy: of the state, exact; told: what the kernel computes of it; drift: by what the energy of
        the last step changed beyond what damping and pulse did; equation: energy of the
        differential equation at that state
    """

    energy: arb
    told: arb
    drift: arb
    equation: arb


def in_python(function):
    """A kernel's function for any numbers: Python itself cannot call what is inlined."""
    own = function.py_func
    used = {
        name: own.__globals__[name] for name in own.__code__.co_names if name in own.__globals__
    }
    called = {name: in_python(one) for name, one in used.items() if hasattr(one, "py_func")}
    return FunctionType(own.__code__, {**own.__globals__, **called})


ENERGIES = in_python(energies)


def states(model, pulse, cell, steps):
    """X one step before each look, and at it; cell: amplitude (um/us^2), f0 (1/us), C and dt."""
    amplitude, f0, damping, dt = cell
    lanes, pulses, state = simd_loop.empty_lanes(model), table([pulse]), no_pulse()
    X, shocks = lanes[0], np.zeros(BLOCK * LANES)
    load(*lanes, 0, simd_loop.coefficients(model, -np.inf)[0], damping, amplitude, dt)
    begin_pulse(X, 0, state, pulses, 0, f0 * dt)
    for step in range(0, steps, BLOCK):
        state.steps[:] = step
        set_out(X, shocks, state, pulses)
        advance(*lanes, shocks, 0, BLOCK - 1)
        before = X.copy()
        advance(*lanes, shocks, BLOCK - 1, 1)
        yield before, X.copy()


def form_of(X, modes):
    """The modal form and the barrier that the rows of lane 0 hold, in the units of the kernel."""

    def vector(name):
        return X[[(R.VECTORS + name * modes + i) * LANES for i in range(modes)]]

    geometric = np.array([vector(R.GEOMETRIC + i) for i in range(modes)])
    numbers = vector(R.STIFFNESS), vector(R.SLOPE_START), vector(R.MIDPOINT), X[R.AXIAL * LANES]
    keys = "stiffness", "slope_start", "midpoint", "axial"
    form = SimpleNamespace(**dict(zip(keys, numbers, strict=True)), geometric=geometric)
    held = SimpleNamespace(energy=X[R.BARRIER * LANES], midpoint=X[R.SADDLE * LANES])
    return form, held


def looks(model, pulse, cell, steps):
    """`Look`s at a run without stops; and over the barrier what encloses it."""
    shape, found = (0,) * model.modes, []
    for before, after in states(model, pulse, cell, steps):
        seen = _seen(before, after, shape, cell[2] * cell[3])
        barrier = arb(float(after[R.BARRIER * LANES]))
        found.append(Look(*(value / barrier for value in seen)))
    return found, passes.floor(*form_of(after, model.modes)) / barrier


def _seen(before, after, shape, drag):
    told = arb(float(sum(ENERGIES(after, shape, 0)[:3])))
    first, last = _balls(before), _balls(after)
    for X in (first, last):
        _remember(X, len(shape))
    kept = [sum(ENERGIES(X, shape, 0)[:3], arb(0)) for X in (first, last)]
    drift = kept[1] - kept[0] + _taken(first, last, len(shape), arb(float(drag)))
    last[R.STRETCH * LANES] = _stretch_between(last, len(shape), False)
    equation = sum(ENERGIES(last, shape, 0)[:3], arb(0))
    return kept[1], told, drift, equation


def _balls(X):
    return {i: arb(float(X[i])) for i in range(0, X.size, LANES)}


def _component(X, name, i, modes):
    return X[(R.VECTORS + name * modes + i) * LANES]


def _remember(X, modes):
    """What a state holds twice, stretch and overlap at the half step, from its positions."""
    w = arb(0)
    for i in range(modes):
        p, d, e = (_component(X, name, i, modes) for name in (R.P, R.P_STEP, R.MIDPOINT))
        w += e * (p - d / 2)
    y = X[R.Y * LANES] - X[R.Y_STEP * LANES] / 2
    X[R.OVERLAP * LANES] = w - y - X[R.GAP * LANES]
    X[R.STRETCH * LANES] = _stretch_between(X, modes, True)


def _stretch_between(X, modes, of_both):
    """p.S p+ + (p + p+).S q0 of two instants, or of the mean of them the stretch itself."""
    ends = []
    for i in range(modes):
        p, d = (_component(X, name, i, modes) for name in (R.P, R.P_STEP))
        ends.append((p - d, p) if of_both else (p - d / 2, p - d / 2))
    total = arb(0)
    for i, (a, b) in enumerate(ends):
        total += (a + b) * _component(X, R.SLOPE_START, i, modes)
        for j, (c, f) in enumerate(ends):
            total += _component(X, R.GEOMETRIC + i, j, modes) * (a * f + b * c) / 2
    return total


def _taken(first, last, modes, drag):
    """By damping, less the work of the pulse, in the step between two states; drag: C dt."""
    swept = arb(0)
    work = last[R.MASS * LANES] * (first[R.Y_STEP * LANES] + last[R.Y_STEP * LANES])
    for i in range(modes):
        way = _component(first, R.P_STEP, i, modes) + _component(last, R.P_STEP, i, modes)
        work += _component(last, R.LOAD, i, modes) * way
        swept += way * way
    way = first[R.Y_STEP * LANES] + last[R.Y_STEP * LANES]
    lost = drag * way * way + last[R.BEAM_DAMPING * LANES] * swept
    return lost / 4 + last[R.SHOCK * LANES] * work / 2

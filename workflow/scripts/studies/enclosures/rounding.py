"""What rounding does to the energies of the kernel: its own lines, in floats and in balls."""

from types import FunctionType, SimpleNamespace
from typing import NamedTuple

import numpy as np
from flint import arb

from snapmap.pulse import table
from snapmap.solver import simd_loop
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.lanes import energies, load
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
    """X and V one step before each look, and at it; cell: amplitude (um/us^2), f0, C and dt."""
    amplitude, f0, damping, dt = cell
    lanes, pulses, state = simd_loop.empty_lanes(model), table([pulse]), no_pulse()
    X, shocks = lanes[0], np.zeros(BLOCK * LANES)
    load(*lanes, 0, simd_loop.coefficients(model, -np.inf)[0], damping, amplitude, dt)
    begin_pulse(X, 0, state, pulses, 0, f0 * dt)
    for step in range(0, steps, BLOCK):
        state.steps[:] = step
        set_out(X, shocks, state, pulses)
        advance(*lanes, shocks, 0, BLOCK - 1)
        before = X[::LANES].copy()
        advance(*lanes, shocks, BLOCK - 1, 1)
        yield _views(before, model.modes), _views(X[::LANES].copy(), model.modes)


def _views(rows, modes):
    """X and V of lane 0."""
    return rows[: R.VECTORS, np.newaxis], rows[R.VECTORS :].reshape(R.S + modes, modes, 1)


def form_of(X, V):
    """The modal form and the barrier that the rows hold, in the units of the kernel."""
    V, X = V[..., 0], X[:, 0]
    numbers = {"stiffness": V[R.KAPPA], "slope_start": V[R.SQ0], "midpoint": V[R.E]}
    form = SimpleNamespace(**numbers, axial=X[R.AXIAL], geometric=V[R.S :])
    return form, SimpleNamespace(energy=X[R.BARRIER], midpoint=X[R.SADDLE])


def looks(model, pulse, cell, steps):
    """`Look`s at a run without stops; and over the barrier what encloses it."""
    found = []
    for before, after in states(model, pulse, cell, steps):
        seen = _seen(before, after, cell[2] * cell[3])
        barrier = arb(float(after[0][R.BARRIER, 0]))
        found.append(Look(*(value / barrier for value in seen)))
    return found, passes.floor(*form_of(*after)) / barrier


def _seen(before, after, drag):
    told = arb(float(_energy(*after)))
    first, last = _balls(before), _balls(after)
    for state in (first, last):
        _remember(*state)
    kept = [_energy(*state) for state in (first, last)]
    drift = kept[1] - kept[0] + _taken(first, last, arb(float(drag)))
    last[0][R.Q, 0] = _stretch_between(last[1], False)
    return kept[1], told, drift, _energy(*last)


def _energy(X, V):
    return sum(ENERGIES(X, V, V.shape[1], 0)[:3])


def _balls(state):
    return tuple(np.vectorize(lambda value: arb(float(value)), otypes="O")(part) for part in state)


def _remember(X, V):
    """What a state holds twice, stretch and overlap at the half step, from its positions."""
    y, w = X[R.Y, 0] - X[R.DY, 0] / 2, np.sum(V[R.E] * (V[R.P] - V[R.D] / 2))
    X[R.OVERLAP, 0] = w - y - X[R.Z0, 0]
    X[R.Q, 0] = _stretch_between(V, True)


def _stretch_between(V, of_both):
    """p.S p+ + (p + p+).S q0 of two instants, or of the mean of them the stretch itself."""
    p, d = V[R.P, :, 0], V[R.D, :, 0]
    a, b = (p - d, p) if of_both else (p - d / 2, p - d / 2)
    return np.sum(a * np.sum(V[R.S :, :, 0] * b, axis=1)) + np.sum((a + b) * V[R.SQ0, :, 0])


def _taken(first, last, drag):
    """By damping, less the work of the pulse, in the step between two states; drag: C dt."""
    (X, V), (X_before, V_before) = last, first
    y, p = X_before[R.DY, 0] + X[R.DY, 0], V_before[R.D, :, 0] + V[R.D, :, 0]
    work = X[R.M, 0] * y + np.sum(V[R.F, :, 0] * p)
    lost = drag * y * y + X[R.ALPHA, 0] * np.sum(p * p)
    return lost / 4 + X[R.A, 0] * work / 2

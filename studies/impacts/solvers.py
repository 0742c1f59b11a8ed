"""Solvers of the ensembles of problems.py; each makes a function that returns x[0] at t_end."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from snapmap.device.device import Device, batch
from snapmap.pulse.pulse import Pulse
from snapmap.solver.cells import Cells
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.pulse import BLOCK, set_out
from snapmap.solver.kernel.step import advance
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import FIRST
from snapmap.solver.simd_loop import begin

from .problems import BALL, WAY, Problem

BISECTIONS = 50
"""Number of bisections with which the plain loop finds an impact."""
ALONE = {"gap": 1e4, "contact": 1.0}
"""Values of a device whose mass never meets the beam."""
LOOSE = 1e-16
"""Spring of a falling ball over the handout's."""
CYCLES = 20.0
"""Number of sines in a pulse, longer than any trajectory."""

Solve = Callable[..., np.ndarray]
"""A function of a tolerance and a longest step, or of a step, that returns x[0] at t_end."""


def by_scipy(problem: Problem) -> Solve:
    """Solve by DOP853 of `solve_ivp`, restarted after each impact, with a compiled rate."""
    rate = njit(problem.rate(np))

    def guard(t, x, q):
        return problem.guard(x, q)

    def follow(x, q, t_end, tolerance, longest):
        t, options = 0.0, {"events": guard, "rtol": tolerance, "atol": tolerance}
        options["max_step"] = longest
        while t < t_end:
            run = solve_ivp(rate, (t, t_end), x, "DOP853", args=(q,), **options)
            t, x = run.t[-1], run.y[:, -1]
            if run.status == 1:
                x, q = problem.reset(x, q)
                if abs(x[1]) < problem.rest:
                    break
        return x[0]

    def solve(tolerance, longest):
        each = zip(problem.start, problem.q, problem.t_end, strict=True)
        return np.array([follow(x, tuple(q), t_end, tolerance, longest) for x, q, t_end in each])

    guard.terminal, guard.direction = True, -1
    return solve


def by_plain_loop(problem: Problem) -> Solve:
    """Solve by Runge and Kutta's fourth order in fixed steps, compiled; impacts by bisection."""
    follow = plain_loop(problem)
    return lambda dt: follow(problem.start, problem.q, problem.t_end, dt)


def plain_loop(problem: Problem) -> Callable:
    """Compile the loop; it returns x[0] at the end of each trajectory, (n,)."""
    rate, guard, reset = (njit(f) for f in (problem.rate(np), problem.guard, problem.reset))
    rest = problem.rest

    @njit
    def step(t, x, q, h, new):
        slope, middle = np.zeros(x.size), np.zeros(x.size)
        for i in range(x.size):
            new[i] = x[i]
        for at, weight in ((0.0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1.0, 1 / 6)):
            for i in range(x.size):
                middle[i] = x[i] + at * h * slope[i]
            for i, change in enumerate(rate(t + at * h, middle, q)):
                slope[i] = change
                new[i] += weight * h * change

    @njit
    def follow(x, q, t_end, dt):
        t, new = 0.0, np.empty_like(x)
        while t < t_end:
            h = min(dt, t_end - t)
            step(t, x, q, h, new)
            if guard(new, q) >= 0.0:
                t += h
                x, new = new, x
                continue
            low = 0.0
            for _ in range(BISECTIONS):
                middle = (low + h) / 2
                step(t, x, q, middle, new)
                if guard(new, q) < 0.0:
                    h = middle
                else:
                    low = middle
            step(t, x, q, h, new)
            t += h
            after, parameters = reset(new, q)
            for i in range(x.size):
                x[i] = after[i]
            for i in range(q.size):
                q[i] = parameters[i]
            if abs(x[1]) < rest:
                break
        return x[0]

    @njit
    def follow_all(start, parameters, t_end, dt):
        ends = np.empty(t_end.size)
        for n in range(t_end.size):
            ends[n] = follow(start[n].copy(), parameters[n].copy(), t_end[n], dt)
        return ends

    return follow_all


def by_kernel(problem: Problem, device: Device) -> Solve:
    """Solve by our kernel in fixed steps: a mass before a stop, with the beam out of reach."""
    omega = device.mass_frequency
    e = problem.q[:, -1]
    frequency = problem.q[:, 0] * omega / (2 * np.pi)
    spring, stop = device.spring, WAY
    pulse = Pulse("sine", np.array([[0.0, 0.0, 0.0, CYCLES, 0.0, 1.0]]))
    if problem.name == BALL:
        spring, stop, pulse = spring * LOOSE, 1.0, Pulse("constant", np.eye(1, 6, 1))
        frequency = CYCLES / (2 * problem.t_end) * omega
    held = replace(device, stop_toward=stop, spring=spring, **ALONE)
    devices = batch([replace(held, restitution=share) for share in e.tolist()])
    model = build_model(devices, Cosines(modes=1))
    shocks = np.zeros(e.size, np.int64), np.full(e.size, omega**2), frequency / CYCLES
    cells = Cells(np.arange(e.size), *shocks, np.zeros(e.size), problem.t_end, (pulse,))

    def solve(steps):
        dt = problem.t_end / omega / (steps + 0.5)
        places = []
        for some in np.split(np.arange(e.size), range(R.LANES, e.size, R.LANES)):
            lanes, _ = begin(model, cells.take(some), dt[some], FIRST)
            shocks = np.zeros(BLOCK * R.LANES)
            for first in range(0, steps + 1, BLOCK):
                lanes.state.steps[:] = first
                set_out(lanes.work, shocks, lanes.state, lanes.pulses)
                advance(*lanes[:3], shocks, 0, min(BLOCK, steps + 1 - first))
            Y = lanes.work[: R.VECTORS * R.LANES].reshape(R.VECTORS, R.LANES)[:, : some.size]
            places.append(Y[R.Y] - Y[R.DY] / 2)
        return np.concatenate(places) + (stop if problem.name == BALL else 0.0)

    return solve

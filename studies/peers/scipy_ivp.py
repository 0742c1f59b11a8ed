"""SciPy's solve_ivp, one cell at a time, with a rate compiled by numba."""

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from snapmap.solver.laws import Laws

from .equations import Equations, Follow, shocks


def by_scipy(
    equations: Equations, method: str, tolerance: float, laws: Laws | None = None
) -> Follow:
    """Make a function that follows cells in the pulse and after it; the snap is an event.

    laws: in place of the device's own forces
    """
    rate, w = compile_rate(equations, laws)
    target, size = equations.target, 2 * equations.modes + 2

    def snaps(t, x, *_):
        return w(x) - target

    def follow(amplitude, f0, damping, t_end):
        x, start = np.zeros(size), 0.0
        for stop, a in ((1 / f0, amplitude), (t_end, 0.0)):
            options = {"args": (a, f0, damping), "events": snaps, "rtol": tolerance}
            run = solve_ivp(rate, (start, stop), x, method, **options)
            if run.t_events[0].size:
                return run.t_events[0][0]
            x, start = run.y[:, -1].copy(), stop
        return np.nan

    snaps.terminal, snaps.direction = True, -1
    return lambda cells: np.array([follow(*cell) for cell in zip(*shocks(cells), strict=True)])


def compile_rate(equations: Equations, laws: Laws | None = None):
    """Compile the rate of x = (p, y, p', y') in a pulse, and w(L/2) from rest.

    laws: in place of the device's own forces
    Returns rate(t, x, amplitude, f0, damping), and w(x).
    """
    stiffness, slope_start, load, midpoint, geometric = equations[:5]
    axial, residual, penalty, gap, mass, spring, _ = equations[5:]
    k, laws = equations.modes, laws or Laws()
    drag = laws.damping or njit(lambda C, velocity, place: C * velocity)
    push = laws.contact or njit(lambda stiffness, overlap: stiffness * max(0.0, overlap))
    force = laws.force

    @njit
    def press(x):
        return push(penalty, midpoint @ x[:k] - x[k] - gap)

    @njit
    def w(x):
        return midpoint @ x[:k] - residual * press(x)

    @njit
    def hold(p):
        s = geometric @ p + slope_start
        return -axial * p @ (s + slope_start) * s - stiffness * p

    @njit
    def hold_by_law(p):
        return midpoint * force(-(midpoint @ p))

    held = hold_by_law if force else hold

    @njit
    def rate(t, x, amplitude, f0, damping):
        p, P = x[:k], press(x)
        a = amplitude / 2 * (1 - np.cos(2 * np.pi * f0 * t))
        slope = np.empty_like(x)
        slope[: k + 1] = x[k + 1 :]
        slope[k + 1 : -1] = held(p) - load * a - midpoint * P
        slope[-1] = (P - spring * x[k] - drag(damping, x[-1], x[k])) / mass - a
        return slope

    rate(0.0, np.zeros(2 * k + 2), 0.0, 0.0, 0.0)
    return rate, w

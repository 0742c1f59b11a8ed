"""The loop that a good researcher would write: central differences, compiled by numba."""

import numpy as np
from numba import njit

from .equations import Equations, Follow, shocks


def by_numba(equations: Equations, dt: float) -> Follow:
    """Make a function that follows cells in steps of dt, us."""
    return lambda cells: follow_all(equations, dt, *shocks(cells))


@njit(fastmath=True)
def follow_all(equations, dt, amplitude, f0, damping, t_end):
    """Follow cells, (n,), one by one."""
    stiffness, slope_start, load, midpoint, geometric = equations[:5]
    axial, residual, penalty, gap, mass, spring, target = equations[5:]
    k, t_snap = load.size, np.full(f0.size, np.nan)
    for cell in range(f0.size):
        p, p_before, s, y, y_before, w = np.zeros(k), np.zeros(k), np.zeros(k), 0.0, 0.0, 0.0
        drag, inertia = damping[cell] / (2 * dt), mass / dt**2
        for step in range(int(np.ceil(t_end[cell] / dt))):
            turn = f0[cell] * step * dt
            a = amplitude[cell] / 2 * (1 - np.cos(2 * np.pi * turn)) if turn < 1 else 0.0
            w_beam, stretch = 0.0, 0.0
            for i in range(k):
                bent = 0.0
                for j in range(k):
                    bent += geometric[i, j] * p[j]
                s[i] = bent + slope_start[i]
                stretch += p[i] * (s[i] + slope_start[i])
                w_beam += midpoint[i] * p[i]
            P = penalty * max(0.0, w_beam - y - gap)
            w_before, w = w, w_beam - residual * P
            if w <= target:
                t_snap[cell] = (step - 1 + (w_before - target) / (w_before - w)) * dt
                break
            for i in range(k):
                force = -axial * stretch * s[i] - stiffness[i] * p[i] - load[i] * a
                p_after = 2 * p[i] - p_before[i] + dt * dt * (force - midpoint[i] * P)
                p_before[i], p[i] = p[i], p_after
            force = P - spring * y - mass * a + drag * y_before
            y, y_before = (force + inertia * (2 * y - y_before)) / (inertia + drag), y
    return t_snap

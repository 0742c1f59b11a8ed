"""The judge: Runge and Kutta's fourth order in short steps that end where the contact switches."""

import numpy as np
from numba import njit

from .equations import Equations, Follow, shocks

BISECTIONS = 40
"""Number of bisections that find where the contact switches."""


def by_short_steps(equations: Equations, dt: float) -> Follow:
    """Make a function that follows cells in steps of at most dt, us."""
    return lambda cells: follow_all(equations, dt, shocks(cells))


@njit
def follow_all(equations, dt, columns):
    """Follow cells, each of the columns (n,), one by one."""
    t_snap = np.empty(columns[0].size)
    for i in range(t_snap.size):
        amplitude, f0, damping, t_end = [column[i] for column in columns]
        t_snap[i] = follow(equations, dt, (amplitude, f0, damping), t_end)
    return t_snap


@njit
def follow(equations, dt, shock, t_end):
    """Follow a cell from rest to its snap or to t_end."""
    x = np.zeros(2 * equations.load.size + 2)
    new, slope, middle = np.empty_like(x), np.zeros_like(x), np.empty_like(x)
    work, t, pulse_end = (new, slope, middle), 0.0, 1 / shock[1]
    # Without a gap the contact is closed at first if the mass is faster than the beam.
    closed = equations.gap == 0.0 and equations.midpoint @ equations.load < 1.0
    while t < t_end:
        end = min(t + dt, pulse_end if t < pulse_end else t_end)
        advance(equations, shock, closed, t, x, end - t, work)
        switches = (overlap(equations, new) > 0.0) != closed
        if switches:
            low, high = 0.0, end - t
            for _ in range(BISECTIONS):
                h = (low + high) / 2
                advance(equations, shock, closed, t, x, h, work)
                if (overlap(equations, new) > 0.0) != closed:
                    high = h
                else:
                    low = h
            advance(equations, shock, closed, t, x, high, work)
            end = t + high
        before, after = height(equations, x), height(equations, new)
        if after <= 0.0:
            return t + (end - t) * before / (before - after)
        x[:] = new
        t, closed = end, closed != switches
    return np.nan


@njit
def advance(equations, shock, closed, t, x, h, work):
    """Step from x, (2 k + 2,), by h with the contact closed or open throughout; sets work[0]."""
    new, slope, middle = work
    new[:] = x
    for at, weight in ((0.0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1.0, 1 / 6)):
        for i in range(x.size):
            middle[i] = x[i] + at * h * slope[i] if at else x[i]
        set_slope(equations, shock, closed, t + at * h, middle, slope)
        for i in range(x.size):
            new[i] += weight * h * slope[i]


@njit
def set_slope(equations, shock, closed, t, x, slope):
    """Set the rate of x = (p, y, p', y') by the equations."""
    k, (amplitude, f0, damping) = equations.load.size, shock
    a = amplitude / 2 * (1 - np.cos(2 * np.pi * f0 * t)) if f0 * t < 1.0 else 0.0
    P = equations.penalty * overlap(equations, x) if closed else 0.0
    axial_force = 0.0
    for i in range(k):
        s = equations.slope_start[i]
        for j in range(k):
            s += equations.geometric[i, j] * x[j]
        slope[k + 1 + i] = s
        axial_force -= equations.axial * x[i] * (s + equations.slope_start[i])
    for i in range(k):
        slope[i] = x[k + 1 + i]
        restoring = axial_force * slope[k + 1 + i] - equations.stiffness[i] * x[i]
        slope[k + 1 + i] = restoring - equations.load[i] * a - equations.midpoint[i] * P
    slope[k] = x[-1]
    slope[-1] = (P - equations.spring * x[k] - damping * x[-1]) / equations.mass - a


@njit
def overlap(equations, x):
    """Return midpoint.p - y - gap, um."""
    k, over = equations.load.size, 0.0
    for i in range(k):
        over += equations.midpoint[i] * x[i]
    return over - x[k] - equations.gap


@njit
def height(equations, x):
    """Return w(L/2) above the target of the snap, um."""
    over = overlap(equations, x)
    pressed = equations.residual * equations.penalty * max(0.0, over)
    return over + x[equations.load.size] + equations.gap - pressed - equations.target

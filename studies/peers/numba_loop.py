"""The loop that a good researcher would write: central differences by numba, cells side by side."""

import numpy as np
from numba import njit

from .equations import Equations, Follow, shocks

LANES, BLOCK = 16, 64
"""Cells side by side, over which the compiler vectorises; steps between two looks at them."""


def by_numba(equations: Equations, dt: float) -> Follow:
    """Make a function that follows cells in steps of dt, us."""
    return lambda cells: follow_all(equations, dt, *shocks(cells))


@njit(fastmath=True, error_model="numpy")
def follow_all(equations, dt, amplitude, f0, damping, t_end):
    """Follow cells, (n,), each in a lane that takes another cell when its own has ended."""
    stiffness, slope_start, load, midpoint, geometric = equations[:5]
    axial, residual, penalty, gap, mass, spring, target = equations[5:]
    k, t_snap, inertia = load.size, np.full(f0.size, np.nan), mass / dt**2
    p, p_before, s = np.zeros((3, k, LANES))
    y, y_before, w, w_before, w_beam, P, a, stretch, half, drag = np.zeros((10, LANES))
    cosine, sine, cosine_step, sine_step, pulse_end = np.zeros((5, LANES))
    step, cell, waiting, running = np.zeros(LANES), np.full(LANES, -1), 0, 0
    while True:
        for l in range(LANES):
            if cell[l] < 0 and waiting < f0.size:
                cell[l], half[l], step[l] = waiting, amplitude[waiting] / 2, 0.0
                drag[l], pulse_end[l] = damping[waiting] / (2 * dt), 1 / (f0[waiting] * dt)
                turn = 2 * np.pi * f0[waiting] * dt
                cosine_step[l], sine_step[l], cosine[l], sine[l] = np.cos(turn), np.sin(turn), 1, 0
                p[:, l] = p_before[:, l] = 0.0
                y[l] = y_before[l] = w[l] = w_before[l] = 0.0
                waiting, running = waiting + 1, running + 1
        if running == 0:
            return t_snap
        for _ in range(BLOCK):
            for l in range(LANES):
                a[l] = half[l] * (1 - cosine[l]) if step[l] < pulse_end[l] else 0.0
                turned = cosine[l] * cosine_step[l] - sine[l] * sine_step[l]
                sine[l] = sine[l] * cosine_step[l] + cosine[l] * sine_step[l]
                cosine[l] = turned
                stretch[l] = w_beam[l] = 0.0
            for i in range(k):
                for l in range(LANES):
                    s[i, l] = slope_start[i]
                for j in range(k):
                    for l in range(LANES):
                        s[i, l] += geometric[i, j] * p[j, l]
                for l in range(LANES):
                    stretch[l] += p[i, l] * (s[i, l] + slope_start[i])
                    w_beam[l] += midpoint[i] * p[i, l]
            for l in range(LANES):
                P[l] = penalty * max(0.0, w_beam[l] - y[l] - gap)
                above = w[l] > target  # else it has snapped, and w and step stay as they are
                w_before[l] = w[l] if above else w_before[l]
                w[l] = w_beam[l] - residual * P[l] if above else w[l]
                step[l] += 1.0 if above else 0.0
            for i in range(k):
                for l in range(LANES):
                    force = -axial * stretch[l] * s[i, l] - stiffness[i] * p[i, l] - load[i] * a[l]
                    change = dt * dt * (force - midpoint[i] * P[l])
                    p_after = 2 * p[i, l] - p_before[i, l] + change
                    p_before[i, l], p[i, l] = p[i, l], p_after
            for l in range(LANES):
                force = P[l] - spring * y[l] - mass * a[l] + drag[l] * y_before[l]
                y_after = (force + inertia * (2 * y[l] - y_before[l])) / (inertia + drag[l])
                y_before[l], y[l] = y[l], y_after
        for l in range(LANES):
            if cell[l] >= 0 and (w[l] <= target or step[l] * dt >= t_end[cell[l]]):
                if w[l] <= target:
                    passed = step[l] - 2 + (w_before[l] - target) / (w_before[l] - w[l])
                    t_snap[cell[l]] = passed * dt if passed * dt <= t_end[cell[l]] else np.nan
                cell[l], running = -1, running - 1

"""A whole solver of your own: SciPy's solve_ivp drops the mass alone, on its spring."""

from scipy.integrate import solve_ivp

DEPTH = 20.0  # um from rest, where it is caught, which counts as the snap


def solver(cell, step):
    M, K, C = cell.device.mass, cell.device.spring, cell.damping

    def rate(t, state):
        y, v = state
        return v, -cell.acceleration(t) - (K * y + C * v) / M

    def falls(t, state):
        return state[0] + DEPTH

    falls.terminal = True
    how = {"rtol": 1e-6, "max_step": 20 * step, "events": falls}
    run = solve_ivp(rate, (0, cell.t_end), (0, 0), **how)
    return run.t_events[0][0] if run.t_events[0].size else None

"""Equations (2), (4) and (5) in modes, with stops, by SciPy."""

import numpy as np
from scipy.integrate import solve_ivp

from snapmap.beam.modal import contact_stiffness


def time_of_snap(model, pulse, N, f0, C, t_end):
    """When the beam snaps, an event, as are stops; NaN: never."""
    device, modal = model.device, model.modal
    k, way = modal.load.size, {-1: device.stop_toward, 1: device.stop_away}
    contact = contact_stiffness(device, modal.residual)
    target = model.barrier.second - model.barrier.first

    def forces(x):
        w = modal.midpoint @ x[:k]
        return w, contact * max(0.0, w - x[k] - device.gap)

    def rate(t, x):
        (_, P), p, y, rates = forces(x), x[:k], x[k], x[k + 1 :]
        a = N * device.gravity * pulse.at(np.array([f0 * t]))[0]
        slope = modal.geometric @ p + modal.slope_start
        axial = -modal.axial * p @ (slope + modal.slope_start)
        force = axial * slope - modal.stiffness * p - modal.load * a - modal.midpoint * P
        own = (P - device.spring * y - C * rates[-1]) / device.mass - a
        return np.concatenate([rates, force, [own]])

    def at_stop(side):
        def event(_, x):
            return side * x[k] - way[side]

        event.terminal, event.direction = True, 1
        return event

    def snap(_, x):
        w, P = forces(x)
        return w - modal.residual * P - target

    snap.terminal = True
    t, x = 0.0, np.zeros(2 * k + 2)
    events = [*(at_stop(side) for side in way if np.isfinite(way[side])), snap]
    while t < t_end:
        run = solve_ivp(rate, (t, t_end), x, "DOP853", events=events, rtol=1e-9, max_step=0.2)
        if run.t_events[-1].size:
            return run.t_events[-1][0]
        t, x = run.t[-1], run.y[:, -1].copy()
        x[-1] *= -device.restitution if run.status == 1 else 1.0
    return np.nan

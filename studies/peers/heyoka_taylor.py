"""heyoka: Taylor series, cells in the lanes of a batch; contact and snap are events."""

import numpy as np

from .equations import Equations, Follow, shocks

EARLY = 0.02
"""Time, us, from which heyoka runs: at 0 mass and beam touch at rest, an event without a sign."""
CHUNK = 1000
"""Steps between two looks at the lanes, of which those that are done take new cells."""
SNAPPED = -1
"""Outcome of a lane that its first event has ended; `propagate_until` counts them down from -1."""


def by_heyoka(equations: Equations, tolerance: float) -> Follow:
    """Make a function that follows cells in as many lanes as heyoka suggests.

    An event switches the contact: a `max` would open and close it at the ends of steps alone.
    """
    import heyoka

    heyoka.set_logger_level_critical()  # it warns of events that it may have missed

    def switch(lanes, sign, lane):
        lanes.pars[3, lane] = equations.penalty if sign > 0 else 0.0
        return True

    rates, over, height = system(equations)
    falling = heyoka.event_direction.negative
    width = heyoka.recommended_simd_size()
    integrator = heyoka.taylor_adaptive_batch(
        rates,
        np.zeros((len(rates), width)),
        pars=np.zeros((4, width)),
        tol=tolerance,
        t_events=[
            heyoka.t_event_batch(height, direction=falling),
            heyoka.t_event_batch(over, callback=switch),
        ],
    )
    return lambda cells: follow(integrator, equations, shocks(cells))


def system(equations: Equations):
    """Write the equations in heyoka's terms: rates, the overlap, and w(L/2) above the target.

    Parameters are half of the amplitude, 2 pi f0, C, and the penalty, or 0 in open contact.
    """
    import heyoka

    k = range(equations.modes)
    half, turn, damping, penalty = (heyoka.par[i] for i in range(4))
    p, v = (heyoka.make_vars(*(f"{name}{i}" for i in k)) for name in "pv")
    y, y_rate = heyoka.make_vars("y", "y_rate")
    a, start = half * (1.0 - heyoka.cos(turn * heyoka.time)), equations.slope_start
    s = [heyoka.sum([equations.geometric[i, j] * p[j] for j in k]) + start[i] for i in k]
    axial_force = -equations.axial * heyoka.sum([p[i] * (s[i] + start[i]) for i in k])
    w_beam = heyoka.sum([equations.midpoint[i] * p[i] for i in k])
    over = w_beam - y - equations.gap
    P = penalty * over
    rates = [(p[i], v[i]) for i in k]
    for i in k:
        force = axial_force * s[i] - equations.stiffness[i] * p[i] - equations.load[i] * a
        rates.append((v[i], force - equations.midpoint[i] * P))
    pull = (P - equations.spring * y - damping * y_rate) / equations.mass
    rates += [(y, y_rate), (y_rate, pull - a)]
    return rates, over, w_beam - equations.residual * P - equations.target


def follow(integrator, equations: Equations, columns) -> np.ndarray:
    """Follow cells, each of the columns (n,), those of the longest pulses first."""
    amplitude, f0, damping, t_end = columns
    t_snap, waiting = np.full(f0.size, np.nan), [*np.argsort(-f0, kind="stable")]
    time, stop = np.zeros((2, integrator.batch_size))
    cell_of = np.full(integrator.batch_size, -1)

    def refill(lane):
        cell_of[lane] = cell = waiting.pop() if waiting else -1
        if cell < 0:
            stop[lane] = time[lane]
            return
        integrator.reset_cooldowns(lane)
        integrator.pars[:, lane] = amplitude[cell] / 2, 2 * np.pi * f0[cell], damping[cell], 0.0
        integrator.state[:, lane] = begun(equations, amplitude[cell] * (np.pi * f0[cell]) ** 2)
        time[lane], stop[lane] = EARLY, 1 / f0[cell]

    for lane in range(cell_of.size):
        refill(lane)
    while (cell_of >= 0).any():
        integrator.set_time(time)
        integrator.propagate_until(stop, max_steps=CHUNK)
        time[:] = integrator.time
        for lane in np.flatnonzero(cell_of >= 0):
            cell = cell_of[lane]
            if int(integrator.propagate_res[lane][0]) == SNAPPED:
                t_snap[cell] = time[lane]
                refill(lane)
            elif time[lane] >= t_end[cell]:
                refill(lane)
            elif time[lane] >= stop[lane]:
                integrator.pars[0, lane], stop[lane] = 0.0, t_end[cell]
    return t_snap


def begun(equations: Equations, growth: float) -> np.ndarray:
    """Return (p, p', y, y') at EARLY, by the first terms of series for a = growth t^2."""
    shares = np.append(equations.load, 1.0)
    places, speeds = (-growth * EARLY**n * shares / m for n, m in ((4, 12), (3, 3)))
    return np.concatenate([places[:-1], speeds[:-1], places[-1:], speeds[-1:]])

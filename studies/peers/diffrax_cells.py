"""diffrax: jax over cells side by side, Tsit5 with steps by a tolerance; the snap is an event."""

import numpy as np

from .equations import Equations, Follow, shocks

FIRST_STEP, MOST_STEPS = 0.01, 100_000
"""First step, us, and most steps of a cell."""


def by_diffrax(equations: Equations, tolerance: float) -> Follow:
    """Make a function that follows cells side by side."""
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    rate, height = rate_of(equations)
    control = {"rtol": tolerance, "atol": 1e-3 * tolerance}

    def follow(amplitude, f0, damping, t_end):
        steps = diffrax.PIDController(**control, jump_ts=(1 / f0)[None])
        run = diffrax.diffeqsolve(
            diffrax.ODETerm(rate),
            diffrax.Tsit5(),
            0.0,
            t_end,
            FIRST_STEP,
            jax.numpy.zeros(2 * equations.modes + 2),
            args=(amplitude, f0, damping),
            stepsize_controller=steps,
            event=diffrax.Event(lambda t, x, args, **_: height(x) < 0.0),
            max_steps=MOST_STEPS,
            throw=False,
        )
        snapped = run.result == diffrax.RESULTS.event_occurred
        return jax.numpy.where(snapped, run.ts[-1], jax.numpy.nan)

    side_by_side = jax.jit(jax.vmap(follow))
    return lambda cells: np.asarray(side_by_side(*shocks(cells)))


def rate_of(equations: Equations):
    """Return the rate of x = (p, y, p', y'), and w(L/2) above the target, in jax."""
    import jax.numpy as jnp

    stiffness, slope_start, load, midpoint, geometric = map(jnp.asarray, equations[:5])
    axial, residual, penalty, gap, mass, spring, target = equations[5:]
    k = equations.modes

    def press(x):
        return penalty * jnp.maximum(0.0, midpoint @ x[:k] - x[k] - gap)

    def height(x):
        return midpoint @ x[:k] - residual * press(x) - target

    def rate(t, x, shock):
        amplitude, f0, damping = shock
        p, P = x[:k], press(x)
        a = jnp.where(f0 * t < 1.0, amplitude / 2 * (1 - jnp.cos(2 * jnp.pi * f0 * t)), 0.0)
        s = geometric @ p + slope_start
        axial_force = -axial * (p @ (s + slope_start))
        p_slope = axial_force * s - stiffness * p - load * a - midpoint * P
        y_slope = (P - spring * x[k] - damping * x[-1]) / mass - a
        return jnp.concatenate([x[k + 1 :], p_slope, y_slope[None]])

    return rate, height

"""The problems of README.md: ensembles of small systems with impacts whose answers are known."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType

import numpy as np
from scipy.optimize import brentq

from ..common import few

BALL, RIGID = "bouncing ball", "impact oscillator"
BOUNDS, ALLOWED = (1e-3, 1e-6), 0.05
"""Largest errors of x[0] at t_end, loose and tight; share of trajectories that may miss a bound, as
some graze."""
REST = 1e-4
"""A solver may stop a ball that leaves the floor with a lower speed."""
SIDE, FEWEST = 16, 3
"""Trajectories along each of two parameters, in all and in a small run."""
WAY = 0.5
"""Distance from the oscillator at rest to its stop."""
T_END = 30.0
"""Time for which the oscillators are followed."""
LOOK = 0.005
"""Time step of the search for an impact in a closed form."""
STIFFNESS = 100.0
"""Stiffness of the soft stop over that of the spring."""
VALVE_DAMPING, PRELOAD, FLOW, VALVE_RESTITUTION = 1.25, 10.0, 20.0, 0.8


@dataclass(frozen=True, eq=False)
class Problem:
    """Trajectories x' = rate(t, x, q), reset wherever guard(x, q) falls through 0.

    rate: makes it from a module with sin and sqrt, numpy or jax.numpy
    reset: returns x and q after an impact
    start: (n, dimension); q: (n, parameters); t_end: (n,); exact: x[0] at t_end, (n,)
    rest: a trajectory ends at an impact after which |x[1]| is below it
    """

    name: str
    rate: Callable[[ModuleType], Callable]
    guard: Callable
    reset: Callable
    start: np.ndarray
    q: np.ndarray
    t_end: np.ndarray
    exact: np.ndarray
    rest: float = 0.0

    def some(self, which: slice) -> "Problem":
        """Return the problem of some trajectories."""
        columns = {key: getattr(self, key)[which] for key in ("start", "q", "t_end", "exact")}
        return replace(self, **columns)

    def is_met(self, answers: np.ndarray, level: int) -> bool:
        """Tell whether no more answers than ALLOWED miss a bound, by its number."""
        return np.mean(~(np.abs(answers - self.exact) <= BOUNDS[level])) <= ALLOWED


def grid(*axes: np.ndarray) -> np.ndarray:
    """Return all combinations of values on axes, (n, axes)."""
    return np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)


def spaced(low: float, high: float, count: int = SIDE) -> np.ndarray:
    """Return evenly spaced values, fewer in a small run."""
    return np.linspace(low, high, few(count, FEWEST))


def make_ball() -> Problem:
    """Make a ball that falls from height 1; its bounces have a limit in time, Zeno's."""

    def rate(math):
        return lambda t, x, q: (x[1], -1.0)

    def guard(x, q):
        return x[0]

    def reset(x, q):
        return (x[0], -q[0] * x[1]), (q[0],)

    q = grid(spaced(0.5, 0.9), spaced(0.6, 1.1))
    zeno = np.sqrt(2) * (1 + q[:, 0]) / (1 - q[:, 0])
    exact = [ball_height(e, share * end) for (e, share), end in zip(q, zeno, strict=True)]
    start = np.tile([1.0, 0.0], (len(q), 1))
    t_end, e = q[:, 1] * zeno, q[:, :1]
    return Problem(BALL, rate, guard, reset, start, e, t_end, np.array(exact), REST)


def ball_height(e: float, t: float) -> float:
    """Return the height at t; bounce n is at sqrt(2) (1 + 2 (e + ... + e^n)), n from 0."""
    bounce, speed = np.sqrt(2), np.sqrt(2)
    if t < bounce:
        return 1 - t * t / 2
    while (speed := e * speed) > 1e-15:
        if t < bounce + 2 * speed:
            return (t - bounce) * (speed - (t - bounce) / 2)
        bounce += 2 * speed
    return 0.0


def make_oscillator() -> Problem:
    """Make a mass on a spring before a rigid stop, driven by a sine from rest."""

    def rate(math):
        return lambda t, x, q: (x[1], -x[0] - math.sin(q[0] * t))

    def guard(x, q):
        return x[0] + WAY

    def reset(x, q):
        return (x[0], -q[1] * x[1]), (q[0], q[1])

    q = grid(spaced(0.9, 2.6), spaced(0.7, 0.9))
    exact = [by_pieces(omega, lambda v, m, e=e: (-e * v, 0)) for omega, e in q]
    return Problem(RIGID, rate, guard, reset, *_from_rest(q), np.array(exact))


def make_bilinear() -> Problem:
    """Make the oscillator before a soft stop, a stiff spring; q[1] is 1 in contact, else 0."""

    def rate(math):
        def stiff(t, x, q):
            pressed = q[1] * STIFFNESS * (x[0] + WAY)
            return x[1], -x[0] - pressed - math.sin(q[0] * t)

        return stiff

    def guard(x, q):
        return (1.0 - 2.0 * q[1]) * (x[0] + WAY)

    def reset(x, q):
        return (x[0], x[1]), (q[0], 1.0 - q[1])

    q = np.stack([spaced(1.1, 2.6, SIDE * SIDE), np.zeros(few(SIDE * SIDE, FEWEST))], axis=1)
    exact = [by_pieces(omega, lambda v, m: (v, 1 - m)) for omega, _ in q]
    return Problem("bilinear oscillator", rate, guard, reset, *_from_rest(q), np.array(exact))


def _from_rest(q):
    return np.zeros((len(q), 2)), q, np.full(len(q), T_END)


def by_pieces(omega: float, meet: Callable) -> float:
    """Return an oscillator's place at T_END by its closed form, from impact to impact.

    meet: function of velocity and contact, 0 or 1, before an impact that returns those after it
    """
    t, x, v, m = 0.0, 0.0, 0.0, 0
    while True:
        motion = partial(_free, omega, t, x, v, m)
        times = np.append(np.arange(t, T_END, LOOK), T_END)
        side = (1 - 2 * m) * (motion(times)[0] + WAY)
        beyond = np.flatnonzero(side[1:] < 0) + 1
        if not beyond.size:
            return motion(T_END)[0]
        last = beyond[0] - 1
        bracket = times[last] if last else t + 1e-9, times[last + 1]
        t = brentq(lambda s, motion=motion: motion(s)[0] + WAY, *bracket, xtol=1e-15)
        x, v = motion(t)
        v, m = meet(v, m)


def _free(omega, t0, x0, v0, m, t):
    """Place and velocity of x'' + (1 + k m) x = -sin(omega t) - k m WAY, from (x0, v0) at t0."""
    square = 1 + STIFFNESS * m
    root, rest, drive = np.sqrt(square), -STIFFNESS * m * WAY / square, -1 / (square - omega**2)
    A = x0 - rest - drive * np.sin(omega * t0)
    B = (v0 - drive * omega * np.cos(omega * t0)) / root
    c, s = np.cos(root * (t - t0)), np.sin(root * (t - t0))
    x = rest + drive * np.sin(omega * t) + A * c + B * s
    return x, drive * omega * np.cos(omega * t) + root * (B * c - A * s)


def make_valve() -> Problem:
    """Make the relief valve of Hős and Champneys, MPGOS's example; x[2] begins at the preload.

    It has no closed form: its answers are NaN.
    """

    def rate(math):
        def valve(t, x, q):
            pushed = x[2] - x[0] - PRELOAD - VALVE_DAMPING * x[1]
            return x[1], pushed, FLOW * (q[0] - x[0] * math.sqrt(x[2]))

        return valve

    def guard(x, q):
        return x[0]

    def reset(x, q):
        return (x[0], -VALVE_RESTITUTION * x[1], x[2]), (q[0],)

    q = spaced(0.2, 7.0, SIDE * SIDE)[:, np.newaxis]
    start, t_end = np.tile([0.2, 0.0, PRELOAD], (len(q), 1)), np.full(len(q), 10.0)
    return Problem("relief valve", rate, guard, reset, start, q, t_end, np.full(len(q), np.nan))

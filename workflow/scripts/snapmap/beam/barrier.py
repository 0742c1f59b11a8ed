"""The barrier between the beam's two shapes."""

from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam, Value
from ..numerics.linalg import apply, dot, eigh, is_positive, solve
from .basis import Basis
from .modal import unit_form, unit_modes
from .prestress import first_midpoint, kinds_of

PASSES = 3
"""Equilibria that may be the lowest pass."""
FAR = 1e6
LEAST_APART, BISECTIONS = 1e-30, 80
"""Of N from the second load, relative; and halvings of the ratio of two bounds."""
NEWTON_STEPS, CONVERGED = 10, 1e-8
"""Most steps, and a relative step so small that the next would be lost in rounding."""


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes; numbers, or arrays (devices,).

    energy: of the beam there, above its shape at rest, pJ
    midpoint: w(L/2) there, from that at rest, um
    second: w(L/2) in the second shape, um; of a beam that has none because it is free to tilt, that
        of a guided one
    first: w(L/2) in the shape at rest, um
    """

    energy: Value
    midpoint: Value
    second: Value
    first: Value


def find_barrier(beam: Beam, basis: Basis, modes: int | None = None) -> Barrier:
    """Find the lowest equilibrium that is no minimum: every way out of a well passes as high.

    Below its energy each well is closed, and w(L/2) on either side of its midpoint tells which
    well the beam is in: among all shapes with that midpoint none has less energy than the saddle.
    A model that has no stable second shape has a barrier of energy 0: one too coarse, close to
    Q = 4/sqrt(3), or a beam that is free to tilt out of it.
    """
    # With rise, span, rho A and EI as units few values tell one beam from another.
    kinds, kind = kinds_of(beam)
    modal = unit_form(basis, modes, kinds)._replace(axial=6 * kinds.Q * kinds.Q)
    if kinds.as_made and not basis.tilt.any():
        guesses, own = _lowest_equilibria(modal, unit_buckling(basis, modes)), None
    else:
        guesses, own = _lowest_pass(modal)
    p, each = guesses.reshape(-1, guesses.shape[-1]), np.repeat(np.arange(kinds.Q.size), PASSES)
    p = _polish(modal, each, p)
    form = _of(modal, each)
    is_pass = np.isfinite(p).all(axis=-1) & ~is_positive(np.nan_to_num(_hessian(form, p)))
    energies = np.where(is_pass, _energy(form, p), np.inf).reshape(-1, PASSES)
    midpoints = dot(form.midpoint, p).reshape(-1, PASSES)
    lowest = np.argmin(energies, axis=-1)[:, np.newaxis]
    energy = np.take_along_axis(energies, lowest, axis=-1)[kind, 0]
    midpoint = np.take_along_axis(midpoints, lowest, axis=-1)[kind, 0]
    exists = np.isfinite(energy)
    unit = beam.stiffness_unit * beam.made_rise * beam.made_rise
    second = np.atleast_1d(beam.second_equilibrium)
    first = first_midpoint(basis, beam)
    if own is not None and basis.tilt.any():
        stays = first + dot(modal.midpoint, own)[kind] * beam.made_rise
        second = np.where(exists, stays, second)
    barrier = np.where(exists, energy, 0.0) * unit, np.where(exists, midpoint, 0.0) * beam.made_rise
    found = *barrier, second, first
    return Barrier(*(value if np.ndim(beam.rise) else value.item() for value in found))


@cache
def unit_buckling(basis: Basis, modes: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, in EI/L^2, and modes v_j, the columns, with v.S v = 1."""
    modal = unit_modes(basis, modes)
    return eigh(np.diag(modal.stiffness), modal.geometric)


def _lowest_equilibria(modal, buckling):
    """Guesses at the lowest equilibria but the two shapes, (n, PASSES, k); NaN for those not there.

    In buckling modes, kappa v = N_j S v and p = sum c_j v_j, equilibrium reads
    c_j = N s_j / (N_j - N), s_j = v_j.S q0: either N is a buckling load N_j and c_j is free, or N
    is a root of the stretch equation alone. The energy grows with N, so of the first kind the
    lowest has the second load, on either side. The start is a multiple of the first mode, but for a
    small remainder that `_polish` adds; where modes are left out, it tells the two sides apart.
    """
    loads, shapes = buckling
    start = dot(shapes[:, 0], modal.slope_start)
    first, axial = loads[0], modal.axial
    guesses = np.full((axial.size, PASSES, loads.size), np.nan)
    with np.errstate(invalid="ignore"):
        # N = axial (s^2 - q^2), q = first s / (first - N): a cubic in q, of which q = s is a root;
        # the others solve q^2 + s q + first/axial = 0, of which the lower is the second shape.
        along = (np.sqrt(start * start - 4 * first / axial) - start) / 2 - start
        guesses[:, 0] = along[:, np.newaxis] * shapes[:, 0]
        if loads.size > 1:
            along = first * start / (first - loads[1])
            bent = np.sqrt(start * start - along * along - loads[1] / axial)
            for which, side in enumerate((bent, -bent), start=1):
                guesses[:, which] = (along - start) * shapes[:, 0]
                guesses[:, which] += side[:, np.newaxis] * shapes[:, 1]
    return guesses


def _lowest_pass(modal):
    """The lowest pass of each form, whatever its start, and its second shape; NaN where none is.

    Returns (n, PASSES, k), of which the first is meant, and (n, k).

    With q_j = c_j + s_j = s_j N_j / (N_j - N), N is a root of

        h(N) = N - axial sum s_j^2 (1 - (N_j / (N_j - N))^2),

    which is convex between the first two loads: of its two roots there the lower is the second
    shape, the higher the pass, close to N_2 if the start has little of the second mode. Without a
    root the second shape is none, or not stable. N = N_2 (1 - x), as x keeps all digits.
    """
    loads, shapes = eigh(_diagonal(modal.stiffness), modal.geometric)
    s = apply(shapes.swapaxes(-1, -2), np.broadcast_to(modal.slope_start, loads.shape))
    if loads.shape[1] == 1:
        # A single mode has a pass of its own, wherever a second load would be.
        loads = np.concatenate([loads, FAR * loads], axis=1)
        s, shapes = (np.concatenate([part, 0 * part], axis=-1) for part in (s, shapes))
    second, others = loads[:, 1], np.arange(loads.shape[1]) != 1

    def shares(x):
        """N_j / (N_j - N)."""
        found = np.repeat(1 / x[:, np.newaxis], loads.shape[1], axis=1)
        below = loads[:, others] - (second * (1 - x))[:, np.newaxis]
        found[:, others] = loads[:, others] / below
        return found

    def above(x):
        share = shares(x)
        return second * (1 - x) - modal.axial * np.sum(s * s * (1 - share * share), axis=1)

    def rises(x):
        return 1 + 2 * modal.axial * np.sum(s * s * shares(x) ** 3 / loads, axis=1) > 0

    most = 1 - loads[:, 0] / second
    with np.errstate(over="ignore"):
        lowest = _between(LEAST_APART * most, most, rises)
        x = _between(LEAST_APART * most, lowest, lambda x: above(x) > 0)
        at_second = _between(lowest, most, lambda x: above(x) < 0)
    q, own = s * shares(x), s * shares(at_second)
    # Without any of the second mode in the start its coordinate is what the stretch leaves open.
    free = np.sqrt(np.maximum(-above(x), 0) / modal.axial)
    q[:, 1] = np.where(s[:, 1] == 0, free, q[:, 1])
    q[above(lowest) >= 0] = np.nan
    found = np.full((len(loads), PASSES, shapes.shape[1]), np.nan)
    found[:, 0] = apply(shapes, q - s)
    return found, apply(shapes, own - s)


def _between(low, high, holds):
    """Where what holds at `low` and not at `high` ceases to, by bisection of their ratio."""
    for _ in range(BISECTIONS):
        middle = np.sqrt(low) * np.sqrt(high)
        yes = holds(middle)
        low, high = np.where(yes, middle, low), np.where(yes, high, middle)
    return np.sqrt(low) * np.sqrt(high)


def _of(modal, each):
    """The unit forms of rows, given by the numbers of their kinds; one for all as made."""
    own = modal.stiffness.ndim > 1
    columns = {key: column[each] if own else column for key, column in modal._asdict().items()}
    return modal._replace(**columns | {"axial": modal.axial[each]})


def _diagonal(values):
    return values[..., np.newaxis] * np.eye(values.shape[-1])


def _stretch(modal, p):
    """S p + S q0 and the axial force N."""
    slope = apply(modal.geometric, p) + modal.slope_start
    return slope, -modal.axial * dot(p, slope + modal.slope_start)


def _energy(modal, p):
    _, axial_force = _stretch(modal, p)
    return dot(p, modal.stiffness * p) / 2 + axial_force * axial_force / (4 * modal.axial)


def _hessian(modal, p):
    slope, axial_force = _stretch(modal, p)
    tangent = (
        _diagonal(modal.stiffness) - axial_force[..., np.newaxis, np.newaxis] * modal.geometric
    )
    along = 2 * modal.axial[..., np.newaxis, np.newaxis] * slope[..., :, np.newaxis]
    return tangent + along * slope[..., np.newaxis, :]


def _polish(modal, each, p):
    """Newton's method from guesses, (rows, k), each until it has converged; each: its kind."""
    found = p.copy()
    left = np.flatnonzero(np.isfinite(found).all(axis=-1))
    for _ in range(NEWTON_STEPS):
        some, guess = _of(modal, each[left]), found[left]
        slope, axial_force = _stretch(some, guess)
        force = some.stiffness * guess - axial_force[..., np.newaxis] * slope
        step = solve(_hessian(some, guess), force)
        found[left] = guess - step
        left = left[abs(step).max(axis=-1) > CONVERGED * abs(guess).max(axis=-1)]
    return found

"""The barrier between the beam's two shapes."""

from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam, Value
from ..numerics.linalg import apply, dot, eigh, is_positive, solve
from .basis import Basis
from .modal import unit_form, unit_modes
from .prestress import kinds_of

PASSES = 3
"""Equilibria that may be the lowest pass."""
NEWTON_STEPS, CONVERGED = 10, 1e-8
"""Most steps, and a relative step so small that the next would be lost in rounding."""


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes; numbers, or arrays (devices,).

    energy: of the beam there, above the start, pJ
    midpoint: w(L/2) - rise there, um
    """

    energy: Value
    midpoint: Value


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
    guesses, second = _lowest_equilibria(modal, _buckling(basis, modes, kinds, modal))
    p, each = guesses.reshape(-1, guesses.shape[-1]), np.repeat(np.arange(kinds.Q.size), PASSES)
    p = _polish(modal, each, p)
    form = _of(modal, each)
    is_pass = np.isfinite(p).all(axis=-1) & ~is_positive(np.nan_to_num(_hessian(form, p)))
    if not kinds.as_made or basis.tilt.any():
        is_pass &= _is_stable(modal, second)[each]
    energies = np.where(is_pass, _energy(form, p), np.inf).reshape(-1, PASSES)
    midpoints = dot(form.midpoint, p).reshape(-1, PASSES)
    lowest = np.argmin(energies, axis=-1)[:, np.newaxis]
    energy = np.take_along_axis(energies, lowest, axis=-1)[kind, 0]
    midpoint = np.take_along_axis(midpoints, lowest, axis=-1)[kind, 0]
    exists = np.isfinite(energy)
    unit = beam.stiffness_unit * beam.rise * beam.rise
    barrier = np.where(exists, energy, 0.0) * unit, np.where(exists, midpoint, 0.0) * beam.rise
    return Barrier(*(value if np.ndim(beam.rise) else value.item() for value in barrier))


@cache
def unit_buckling(basis: Basis, modes: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, in EI/L^2, and modes v_j, the columns, with v.S v = 1."""
    modal = unit_modes(basis, modes)
    return eigh(np.diag(modal.stiffness), modal.geometric)


def _buckling(basis, modes, kinds, modal):
    """Loads, beyond the tension at rest, and modes: one for all kinds as made, else of each."""
    if kinds.as_made:
        return unit_buckling(basis, modes)
    return eigh(_diagonal(modal.stiffness), modal.geometric)


def _lowest_equilibria(modal, buckling):
    """Guesses at the lowest equilibria but the first shape; NaN for what is not there.

    In buckling modes, kappa v = N_j S v and p = sum c_j v_j, equilibrium reads
    c_j = N s_j / (N_j - N), s_j = v_j.S q0: either N is a buckling load N_j and c_j is free, or N
    is a root of the stretch equation alone. The energy grows with N, so of the first kind the
    lowest has the second load, on either side. The start is a multiple of the first mode, but for a
    small remainder, or an imperfection, that `_polish` adds; where modes are left out, it tells the
    two sides apart.
    Returns the passes, (kinds, PASSES, k), and the second shape, (kinds, k).
    """
    loads, shapes = buckling
    start, first = dot(shapes[..., 0], modal.slope_start), loads[..., 0]
    axial, v = modal.axial, shapes[..., 0]
    guesses = np.full((axial.size, PASSES, loads.shape[-1]), np.nan)
    with np.errstate(invalid="ignore"):
        # N = axial (s^2 - q^2), q = first s / (first - N): a cubic in q, of which q = s is a root;
        # the others solve q^2 + s q + first/axial = 0, of which the lower is the second shape.
        root = np.sqrt(start * start - 4 * first / axial)
        guesses[:, 0] = ((root - start) / 2 - start)[:, np.newaxis] * v
        second = ((-root - start) / 2 - start)[:, np.newaxis] * v
        if loads.shape[-1] > 1:
            along = first * start / (first - loads[..., 1])
            bent = np.sqrt(start * start - along * along - loads[..., 1] / axial)
            for which, side in enumerate((bent, -bent), start=1):
                guesses[:, which] = (along - start)[..., np.newaxis] * v
                guesses[:, which] += side[:, np.newaxis] * shapes[..., 1]
    return guesses, second


def _is_stable(modal, guess):
    """Whether beams, (kinds,), have a stable shape close to the guess, on the other side."""
    each = np.arange(len(guess))
    found = _polish(modal, each, guess)
    stays = is_positive(np.nan_to_num(_hessian(_of(modal, each), found)))
    return stays & (dot(modal.midpoint, found) < 0.5 * dot(modal.midpoint, guess))


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

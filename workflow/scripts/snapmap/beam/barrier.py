"""The barrier between the beam's two shapes."""

from functools import cache
from typing import NamedTuple

import numpy as np

from ..device import Beam, Value
from ..numerics.linalg import apply, dot, eigh, is_positive, solve
from .basis import Basis
from .modal import unit_modes

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
    A model too coarse to have a second shape, close to Q = 4/sqrt(3), has a barrier of energy 0.
    """
    # With rise, span, rho A and EI as units a beam is told from others by Q = rise/thickness alone.
    Q, place = np.unique(np.atleast_1d(beam.bistability), return_inverse=True)
    modal = unit_modes(basis, modes)._replace(axial=6 * Q[:, np.newaxis] * Q[:, np.newaxis])
    p = _polish(modal, _lowest_equilibria(modal, unit_buckling(basis, modes)))
    is_pass = np.isfinite(p).all(axis=-1) & ~is_positive(np.nan_to_num(_hessian(modal, p)))
    energies = np.where(is_pass, _energy(modal, p), np.inf)
    lowest = np.argmin(energies, axis=-1)[:, np.newaxis]
    energy = np.take_along_axis(energies, lowest, axis=-1)[place, 0]
    midpoint = np.take_along_axis(dot(modal.midpoint, p), lowest, axis=-1)[place, 0]
    exists = np.isfinite(energy)
    unit = beam.stiffness_unit * beam.rise * beam.rise
    barrier = np.where(exists, energy, 0.0) * unit, np.where(exists, midpoint, 0.0) * beam.rise
    return Barrier(*(value if np.ndim(beam.rise) else value.item() for value in barrier))


@cache
def unit_buckling(basis: Basis, modes: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, in EI/L^2, and modes v_j, the columns, with v.S v = 1."""
    modal = unit_modes(basis, modes)
    return eigh(np.diag(modal.stiffness), modal.geometric)


def _lowest_equilibria(modal, buckling):
    """Guesses at the lowest equilibria but the two shapes, (n, 3, k); NaN for what is not there.

    In buckling modes, kappa v = N_j S v and p = sum c_j v_j, equilibrium reads
    c_j = N s_j / (N_j - N), s_j = v_j.S q0: either N is a buckling load N_j and c_j is free, or N
    is a root of the stretch equation alone. The energy grows with N, so of the first kind the
    lowest has the second load, on either side. The start is a multiple of the first mode, but for a
    small remainder that `_polish` adds; where modes are left out, it tells the two sides apart.
    """
    loads, shapes = buckling
    start = dot(shapes[:, 0], modal.slope_start)
    first, axial = loads[0], modal.axial[:, 0]
    guesses = np.full((axial.size, 3, loads.size), np.nan)
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


def _stretch(modal, p):
    """S p + S q0 and the axial force N."""
    slope = apply(modal.geometric, p) + modal.slope_start
    return slope, -modal.axial * dot(p, slope + modal.slope_start)


def _energy(modal, p):
    _, axial_force = _stretch(modal, p)
    return dot(p, modal.stiffness * p) / 2 + axial_force * axial_force / (4 * modal.axial)


def _hessian(modal, p):
    slope, axial_force = _stretch(modal, p)
    tangent = np.diag(modal.stiffness) - axial_force[..., np.newaxis, np.newaxis] * modal.geometric
    along = 2 * modal.axial[..., np.newaxis, np.newaxis] * slope[..., :, np.newaxis]
    return tangent + along * slope[..., np.newaxis, :]


def _polish(modal, p):
    """Newton's method from guesses, (n, 3, k), each until it has converged."""
    found = p.reshape(-1, p.shape[-1]).copy()
    axial = np.broadcast_to(modal.axial, p.shape[:-1]).ravel()
    left = np.flatnonzero(np.isfinite(found).all(axis=-1))
    for _ in range(NEWTON_STEPS):
        some, guess = modal._replace(axial=axial[left]), found[left]
        slope, axial_force = _stretch(some, guess)
        force = modal.stiffness * guess - axial_force[..., np.newaxis] * slope
        step = solve(_hessian(some, guess), force)
        found[left] = guess - step
        left = left[abs(step).max(axis=-1) > CONVERGED * abs(guess).max(axis=-1)]
    return found.reshape(p.shape)

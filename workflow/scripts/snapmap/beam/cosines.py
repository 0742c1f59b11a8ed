"""The buckling shapes of the straight clamped beam, which make bending and geometric diagonal.

The symmetric shapes are cosines, phi_n = 1 - cos(2 n pi x / L). The antisymmetric shapes are
psi_n = sin(mu_n y / L) / sin(mu_n / 2) - 2 y / L with y = x - L/2 and tan(mu_n/2) = mu_n/2.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from ..numerics.portable import sine
from .basis import PLACES, Basis, block_diagonal

TERMS = 30
"""Terms of the continued fraction of tan; ten give all digits up to the second buckling load."""


@cache
def symmetric_cosines(cosines: int) -> Basis:
    """Return the basis of the first `cosines` phi_n; w0 is rise/2 times the first."""
    n = np.arange(1, cosines + 1)
    square = 4 * np.pi * np.pi * n * n  # of the wave number
    quarters = n * np.arange(PLACES)[:, np.newaxis] % 4
    return Basis(
        mass=np.ones((cosines, cosines)) + np.eye(cosines) / 2,
        bending=np.diag(square * square / 2),
        geometric=np.diag(square / 2),
        load=np.ones(cosines),
        midpoint=np.where(n % 2, 2.0, 0.0),
        start=np.where(n == 1, 0.5, 0.0),
        project=lambda a: _resized(a, cosines) / 2,
        tilt=np.zeros(cosines),
        curvature=square * np.array([1.0, 0.0, -1.0, 0.0])[quarters],  # cos(2 n pi x / L)
        flexibility=_midpoint_flexibility,
        bent=_bent,
        complete=False,
    )


@cache
def buckling_shapes(cosines: int) -> Basis:
    """Return the basis of `cosines` phi_n and as many psi_n, for a beam that is free to tilt."""
    symmetric, mu = symmetric_cosines(cosines), antisymmetric_loads(cosines)
    none, tilt = np.zeros(cosines), np.zeros(2 * cosines)
    # The slope of psi_1 vanishes at mu y = 2 pi - mu/2, where |psi_1| = 4 pi / mu.
    tilt[cosines] = mu[0] / (4 * np.pi)
    square = mu * mu
    # -sin(mu y / L) / sin(mu / 2) at the PLACES; at quarters, 1 / (2 cos(mu / 4)).
    inner = np.array([0.5 / sine(turn + 0.25) for turn in (mu / (8 * np.pi)).tolist()])
    halves = np.stack([0 * mu + 1, inner, 0 * mu, -inner, 0 * mu - 1])
    # The integral of psi_m psi_n over the span is 1/3, and 1/2 more for m = n.
    mass = np.full((cosines, cosines), 1 / 3) + np.eye(cosines) / 2
    return replace(
        symmetric,
        mass=block_diagonal(symmetric.mass, mass),
        bending=block_diagonal(symmetric.bending, np.diag(square * square / 2)),
        geometric=block_diagonal(symmetric.geometric, np.diag(square / 2)),
        load=np.append(symmetric.load, none),
        midpoint=np.append(symmetric.midpoint, none),
        start=np.append(symmetric.start, none),
        project=lambda a: _resized(symmetric.project(a), 2 * cosines),
        tilt=tilt,
        curvature=np.hstack([symmetric.curvature, square * halves]),
    )


@cache
def antisymmetric_loads(number: int) -> np.ndarray:
    """Find the first roots mu > 0 of tan(mu/2) = mu/2, (number,).

    With mu/2 = end - d just below end = (n + 1/2) pi, Newton's method solves
    cos(d) = (end - d) sin(d).
    """
    end = (np.arange(1, number + 1) + 0.5) * np.pi
    d = 1 / end
    for _ in range(6):
        turns = (d / (2 * np.pi)).tolist()
        sin, cos = (np.array([sine(turn + shift) for turn in turns]) for shift in (0, 0.25))
        d = d - (cos - (end - d) * sin) / (-(end - d) * cos)
    return 2 * (end - d)


def _resized(a, size):
    """Cut the last axis to `size`, or pad it with zeros."""
    return np.concatenate([a[..., :size], np.zeros((*a.shape[:-1], size))], axis=-1)[..., :size]


def _midpoint_flexibility(axial_force):
    """Return the flexibility of a clamped beam-column, in L^3/EI: 3 (tan u - u) / u^3 / 192.

    u = L/4 sqrt(N/EI), with compression positive (Timoshenko & Gere, ch. 1). By Lambert's continued
    fraction tan u = u / (1 - u^2/f), and 3 (tan u - u) / u^3 = 3 / (f - u^2).
    """
    square, fraction = _lambert(axial_force)
    return 3 / (fraction - square) / 192


def _bent(axial_force):
    """Return w'' at the PLACES, in L/EI: tan u / 8u at clamps, -tan u / 8u midway, else 0."""
    square, fraction = _lambert(axial_force)
    return np.multiply.outer(fraction / (fraction - square) / 8, [1.0, 0.0, -1.0, 0.0, 1.0])


def _lambert(axial_force):
    """Return u^2 and f = 3 - u^2/(5 - u^2/(7 - ...)) of `_midpoint_flexibility`."""
    square = axial_force / 16
    fraction = 2.0 * TERMS + 1
    for odd in range(2 * TERMS - 1, 1, -2):
        fraction = odd - square / fraction
    return square, fraction

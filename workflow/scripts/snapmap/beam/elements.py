"""Hermite cubic elements on the half beam: the handout's discretisation."""

from functools import cache
from math import pi, sqrt

import numpy as np

from ..device.shape import slope_products
from ..numerics.linalg import apply, dot, multiply, outer, solve, solve_all
from ..numerics.portable import sine
from .basis import Basis, block_diagonal
from .cosines import antisymmetric_loads

HERMITE = np.array([[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])
"""The N_i as polynomials of 0 <= xi <= 1, lowest power first; those of slopes are over h."""
SYMMETRIC, ANTISYMMETRIC = -1, -2
"""Index of the unknown, of (W, Phi) at the midpoint, that symmetry fixes there: Phi, or W."""


@cache
def hermite_elements(elements: int = 5, free: bool = False) -> Basis:
    """Assemble `elements` uniform Hermite elements of the half beam: 2 elements - 1 unknowns.

    Unknowns are W and Phi = dw/d(x/L) at each node, except W = Phi = 0 at the clamp and Phi = 0 at
    the midpoint.
    free: whether antisymmetric motions, with W = 0 at the midpoint, are appended; both kinds
        together are the motions of a whole beam of twice as many elements
    """
    h, none = 1 / (2 * elements), np.zeros(2 * elements - 1)
    parts = [_integrals(order, h) for order in (2, 1, 0)]
    bending, geometric, mass = (_assemble(elements, part, SYMMETRIC) for part in parts)
    load = _assemble(elements, h * np.array([1 / 2, h / 12, 1 / 2, -h / 12]), SYMMETRIC)
    start, tilt = _interpolate_start(elements), none
    midpoint, curvature = np.append(none[1:], 1.0), _curvature(elements, SYMMETRIC)
    project = _projection(elements, geometric, free)
    if free:
        others = (_assemble(elements, part, ANTISYMMETRIC) for part in parts)
        bending, geometric, mass = map(block_diagonal, (bending, geometric, mass), others)
        load, start, midpoint = (np.append(vector, none) for vector in (load, start, midpoint))
        tilt = np.append(none, _interpolate_tilt(elements))
        curvature = np.hstack([curvature, _curvature(elements, ANTISYMMETRIC)])

    def pushed(axial_force):
        tangent = bending - np.asarray(axial_force)[..., np.newaxis, np.newaxis] * geometric
        return solve(tangent, midpoint)

    return Basis(
        mass=mass,
        bending=bending,
        geometric=geometric,
        load=load,
        midpoint=midpoint,
        start=start,
        project=project,
        tilt=tilt,
        curvature=curvature,
        flexibility=lambda axial_force: dot(midpoint, pushed(axial_force)),
        bent=lambda axial_force: apply(curvature, pushed(axial_force)),
        complete=True,
    )


def _integrals(order, h):
    """Integrate products of the order-th derivatives of the N_i over an element, (4, 4)."""
    c, sizes, scale = HERMITE, np.array([1.0, h, 1.0, h]), h
    for _ in range(order):
        c, scale = c[:, 1:] * np.arange(1, c.shape[1]), scale / (h * h)
    n = np.arange(c.shape[1])
    # 420 is a multiple of 1 to 7, so the sums are of whole numbers.
    sums = multiply(multiply(c, 420 // (n[:, np.newaxis] + n + 1)), c.T)
    return sums * outer(sizes, sizes) / 420 * scale


def _assemble(elements, part, fixed):
    """Sum an element's matrix or vector over the half beam, drop fixed unknowns, and double it."""
    full = np.zeros([2 * elements + 2] * part.ndim)
    for i in range(0, 2 * elements, 2):
        full[(slice(i, i + 4),) * part.ndim] += part
    kept = np.delete(np.arange(2 * elements + 2), [0, 1, fixed])
    return 2 * full[np.ix_(*[kept] * part.ndim)]


def _curvature(elements, fixed):
    """Return w'' at the PLACES per free unknown: at a node, the mean of both sides."""
    h, mirrored = 1 / (2 * elements), 1 if fixed == SYMMETRIC else -1
    begins, ends = np.array([[-6, -4 * h, 6, -2 * h], [6, 2 * h, -6, 4 * h]]) / (h * h)
    half = np.zeros((elements, 2, 2 * elements + 2))
    for i in range(elements):
        half[i, :, 2 * i : 2 * i + 4] = begins, ends
    # A quarter of the span is a node, or the middle of an element.
    quarter = (half[(elements - 1) // 2, 1] + half[elements // 2, 0]) / 2
    middle = half[-1, 1] * (1 + mirrored) / 2
    places = [half[0, 0], quarter, middle, mirrored * quarter, mirrored * half[0, 0]]
    return np.delete(np.array(places), [0, 1, 2 * elements + 2 + fixed], axis=1)


def _interpolate_start(elements):
    """Return nodal values and slopes of w0, eq. (1), which hence is exactly stress-free."""
    nodal = []
    for node in range(elements + 1):
        quarter, half = (sine(node / elements / parts) for parts in (4, 2))
        nodal += [quarter * quarter, pi * half]
    return np.array(nodal[2:-1])


def _projection(elements, geometric, free):
    """Make `Basis.project`: least squares of the slopes, by symmetric shapes alone."""

    @cache
    def cosines():
        """Return the coordinates of the phi_n / 2, (unknowns, TERMS)."""
        h = 1 / (2 * elements)
        x, weights, slopes = slope_products(np.arange(elements + 1) * h)
        share = x / h - np.arange(elements)[:, np.newaxis]
        bend = 6 * share * (share - 1) / h
        tilt, next_tilt = 1 + share * (3 * share - 4), share * (3 * share - 2)
        rises = np.stack([bend, tilt, -bend, next_tilt], axis=1)
        parts = multiply(rises * weights[:, np.newaxis], slopes)
        full = np.zeros((2 * elements + 2, parts.shape[-1]))
        for i in range(elements):
            full[2 * i : 2 * i + 4] += parts[i]
        # The factors 2, for both halves of the beam, and 1/2, of phi_n / 2, cancel.
        symmetric = solve_all(geometric, np.delete(full, [0, 1, len(full) + SYMMETRIC], axis=0))
        return np.concatenate([symmetric, 0 * symmetric]) if free else symmetric

    return lambda a: apply(cosines(), a)


def _interpolate_tilt(elements):
    """Return nodal values and slopes of psi_1 with largest displacement 1 (`buckling_shapes`)."""
    (mu,) = antisymmetric_loads(1)
    tangent = mu / 2
    nodal = []
    for node in range(elements + 1):
        along = node / (2 * elements) - 0.5
        sin, cos = (sine(mu * along / (2 * pi) + turn) for turn in (0, 0.25))
        # sin(mu/2) = tan(mu/2) cos(mu/2), and cos(mu/2) is negative.
        half = -tangent / sqrt(1 + tangent * tangent)
        nodal += [sin / half - 2 * along, mu * cos / half - 2]
    return mu / (4 * pi) * np.delete(np.array(nodal), [0, 1, ANTISYMMETRIC])

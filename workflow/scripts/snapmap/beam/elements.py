"""Hermite cubic elements on the half beam: the handout's discretisation."""

from functools import cache
from math import pi

import numpy as np

from ..numerics.linalg import dot, solve
from ..numerics.portable import sine
from .basis import Basis


@cache
def hermite_elements(elements: int = 5, mass_matrix: str = "consistent") -> Basis:
    """Assemble `elements` uniform Hermite elements of the half beam: 2 elements - 1 unknowns.

    Unknowns are (W, Phi) at each node but those fixed: W = Phi = 0 at the clamp, Phi = 0 at L/2;
    Phi = dw/d(x/L).
    mass_matrix: "consistent" or "hrz" (diagonal, Hinton, Rock & Zienkiewicz 1976).
    """
    h = 1 / (2 * elements)
    bending = _assemble(elements, _bending(h))
    geometric = _assemble(elements, _geometric(h))
    midpoint = np.zeros(2 * elements - 1)
    midpoint[-1] = 1.0

    def flexibility(axial_force: float) -> float:
        return float(dot(midpoint, solve(bending - axial_force * geometric, midpoint)))

    return Basis(
        mass=_assemble(elements, _hrz_mass(h) if mass_matrix == "hrz" else _consistent_mass(h)),
        bending=bending,
        geometric=geometric,
        load=_assemble_vector(elements, _load(h)),
        midpoint=midpoint,
        start=_interpolate_start(elements),
        flexibility=flexibility,
        complete=True,
    )


def _bending(h):
    """Integral of N_i'' N_j'' over one element, 1/um^3."""
    return np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    ) / (h * h * h)


def _geometric(h):
    """Integral of N_i' N_j' over one element, 1/um."""
    return np.array(
        [
            [36, 3 * h, -36, 3 * h],
            [3 * h, 4 * h * h, -3 * h, -h * h],
            [-36, -3 * h, 36, -3 * h],
            [3 * h, -h * h, -3 * h, 4 * h * h],
        ]
    ) / (30 * h)


def _consistent_mass(h):
    """Integral of N_i N_j over one element, um."""
    return (
        np.array(
            [
                [156, 22 * h, 54, -13 * h],
                [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                [54, 13 * h, 156, -22 * h],
                [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
            ]
        )
        * h
        / 420
    )


def _hrz_mass(h):
    """Diagonal of the consistent mass, scaled so that the translations carry all of it, um."""
    return h * np.diag([1 / 2, h * h / 78, 1 / 2, h * h / 78])


def _load(h):
    """Integral of N_i over one element, um."""
    return h * np.array([1 / 2, h / 12, 1 / 2, -h / 12])


def _assemble(elements, element_matrix):
    """Sum one element's matrix over the half beam, drop the fixed unknowns, double."""
    full = np.zeros((2 * elements + 2, 2 * elements + 2))
    for i in range(0, 2 * elements, 2):
        full[i : i + 4, i : i + 4] += element_matrix
    return 2 * full[2:-1, 2:-1]


def _assemble_vector(elements, element_vector):
    full = np.zeros(2 * elements + 2)
    for i in range(0, 2 * elements, 2):
        full[i : i + 4] += element_vector
    return 2 * full[2:-1]


def _interpolate_start(elements):
    """Nodal values and slopes of w0, eq. (1): hence exactly stress-free."""
    nodal = []
    for node in range(elements + 1):
        half, whole = (sine(node / elements / parts) for parts in (4, 2))
        nodal += [half * half, pi * whole]
    return np.array(nodal[2:-1])

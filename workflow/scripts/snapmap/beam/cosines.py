"""Symmetric cosines phi_n = 1 - cos(2 n pi x / L): clamped exactly, bending and slopes diagonal."""

from functools import cache

import numpy as np

from .basis import Basis

TERMS = 30
"""Of the continued fraction of the tangent; ten give all digits up to the second buckling load."""


@cache
def symmetric_cosines(cosines: int) -> Basis:
    """Expand w in the first `cosines` symmetric cosines; w0 is rise/2 times the first of them."""
    n = np.arange(1, cosines + 1)
    square = 4 * np.pi * np.pi * n * n  # of the wave number
    start = np.zeros(cosines)
    start[0] = 0.5
    return Basis(
        mass=np.ones((cosines, cosines)) + np.eye(cosines) / 2,
        bending=np.diag(square * square / 2),
        geometric=np.diag(square / 2),
        load=np.ones(cosines),
        midpoint=np.where(n % 2, 2.0, 0.0),
        start=start,
        flexibility=_midpoint_flexibility,
        complete=False,
    )


def _midpoint_flexibility(axial_force):
    """Clamped beam-column under a midpoint force: L^3/(192 EI) * 3 (tan u - u) / u^3.

    u = L/4 sqrt(N/EI), compression positive (Timoshenko & Gere, ch. 1); with Lambert's fraction
    tan u = u / (1 - u^2/f), f = 3 - u^2/(5 - u^2/(7 - ...)), the last factor is 3 / (f - u^2).
    """
    square = axial_force / 16
    fraction = 2.0 * TERMS + 1
    for odd in range(2 * TERMS - 1, 1, -2):
        fraction = odd - square / fraction
    return 3 / (fraction - square) / 192

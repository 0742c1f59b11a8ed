"""Symmetric cosines phi_n = 1 - cos(2 n pi x / L): clamped exactly, bending and slopes diagonal."""

import numpy as np

from ..device import Beam
from .basis import Basis


def symmetric_cosines(beam: Beam, cosines: int) -> Basis:
    """Expand w in the first `cosines` symmetric cosines; w0 is rise/2 times the first of them."""
    n = np.arange(1, cosines + 1)
    wave_number = 2 * np.pi * n / beam.span
    ei = beam.bending_stiffness
    beam_mass = beam.mass_per_length * beam.span
    start = np.zeros(cosines)
    start[0] = beam.rise / 2

    def flexibility(axial_force: float) -> float:
        return _midpoint_flexibility(beam.span, ei, axial_force)

    return Basis(
        mass=beam_mass * (np.ones((cosines, cosines)) + np.eye(cosines) / 2),
        bending=np.diag(ei * beam.span / 2 * wave_number**4),
        geometric=np.diag(beam.span / 2 * wave_number**2),
        load=np.full(cosines, beam_mass),
        midpoint=1.0 - (-1.0) ** n,
        start=start,
        flexibility=flexibility,
        complete=False,
    )


def _midpoint_flexibility(span, ei, axial_force):
    """Clamped beam-column under a midpoint force: L^3/(192 EI) * 3 (tan u - u) / u^3.

    u = L/4 sqrt(N/EI); axial_force N in uN, compression positive (Timoshenko & Gere, ch. 1).
    """
    u = span / 4 * np.sqrt(axial_force / ei)
    return float(span**3 / (192 * ei) * 3 * (np.tan(u) - u) / u**3)

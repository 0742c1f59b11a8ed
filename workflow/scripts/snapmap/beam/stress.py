"""Stress along the beam, of bending at both of its faces and of the axial force.

With M / EI = w'' - w0'' and the tension T of the beam at rest, the largest tensile stress of a
place is E t/2 |w'' - w0''| + (T - N) / A.
"""

from typing import NamedTuple

import numpy as np

from ..device.device import Beam, Device, Value
from ..numerics.linalg import apply, multiply, outer, solve
from .basis import Basis
from .modal import halfway, unit_beams


class Stress(NamedTuple):
    """Stress at the PLACES of one beam, of n coordinates u from its shape at rest, MPa.

    bending: (PLACES, n), per coordinate; rest: (PLACES,), of bending at rest
    residual: (PLACES,), of the modes left out, per contact force, 1/um^2
    tension: at rest; area: um^2
    """

    bending: np.ndarray
    rest: np.ndarray
    residual: np.ndarray
    tension: float
    area: Value

    def largest(self, u: np.ndarray, contact: np.ndarray, axial_force: np.ndarray) -> np.ndarray:
        """Find the largest tensile stress over both faces of the PLACES, MPa, (samples,).

        Below 0 where all of them are pressed.

        u: (samples, n); contact: force on the beam, uN; axial_force: N beyond that at rest, uN
        """
        bent = apply(self.bending, u) + self.rest - outer(contact, self.residual)
        return np.abs(bent).max(axis=-1) + self.tension - axial_force / self.area


def break_probability(device: Device, stress: np.ndarray) -> np.ndarray:
    """Probability that beams break under their largest stress, MPa.

    That is 1 - exp(-((stress - threshold) / scale)^modulus) of a Weibull distribution of the
    strength, and 0 or 1 where it is a number: a modulus without end.
    """
    # ASSUME: the largest stress alone decides, not how much of the beam bears it.
    over = np.maximum(stress - device.strength_threshold, 0.0) / device.strength
    with np.errstate(over="ignore"):
        return -np.expm1(-(over**device.strength_modulus))


def stress_of(beam: Beam, basis: Basis, shapes: np.ndarray) -> Stress:
    """Give the stress of one beam in modes of its basis: shapes, (n, k), as in `ModalBeam`."""
    beams = unit_beams(basis, beam)
    ((T,), (q,)), (made,) = beams.at_rest, beams.made
    scaled, force = basis.scaled_to(beam), beam.stiffness_unit * beam.span
    per_curvature = beam.youngs_modulus * beam.thickness / 2
    N = halfway(T) * force
    back = shapes.swapaxes(0, 1)
    tangent = multiply(multiply(back, scaled.bending - N * scaled.geometric), shapes)
    kept = apply(shapes, solve(tangent, apply(back, scaled.midpoint)))
    return Stress(
        bending=per_curvature * multiply(scaled.curvature, shapes),
        rest=per_curvature * apply(scaled.curvature, beam.made_rise * (q - made)),
        residual=per_curvature * (scaled.bent(N) - apply(scaled.curvature, kept)),
        tension=T * force / beam.area,
        area=beam.area,
    )

"""Tensile stress along the beam, from bending, at both faces, and from the axial force.

As M / EI = w'' - w0'', the largest tensile stress at a place is E t/2 |w'' - w0''| + (T - N) / A,
with the tension T of the beam at rest and the axial force N beyond it.
"""

from typing import NamedTuple

import numpy as np

from ..device.device import Beam, Device
from ..numerics.linalg import apply, multiply, outer, solve
from ..values.kinds import Number
from .basis import Basis
from .modal import halfway, unit_beams

DECIMALS = 9
"""Of probabilities, so that every machine has the same."""


class Stress(NamedTuple):
    """Stress at the PLACES of a beam, for n coordinates u from its shape at rest.

    bending: per coordinate, (PLACES, n); rest: of bending at rest, MPa, (PLACES,)
    residual: of the modes left out, per contact force, 1/um^2, (PLACES,)
    tension: T / A at rest, MPa; area: um^2
    """

    bending: np.ndarray
    rest: np.ndarray
    residual: np.ndarray
    tension: float
    area: Number

    def largest(self, u: np.ndarray, contact: np.ndarray, axial_force: np.ndarray) -> np.ndarray:
        """Find the largest tensile stress over both faces of the PLACES, MPa, (samples,).

        It is negative if all of them are compressed.

        u: (samples, n); contact: force on the beam, uN; axial_force: N beyond that at rest, uN
        """
        bent = apply(self.bending, u) + self.rest - outer(contact, self.residual)
        return np.abs(bent).max(axis=-1) + self.tension - axial_force / self.area


def break_probability(device: Device, stress: np.ndarray) -> np.ndarray:
    """Return the probability that beams break under their largest stress, MPa, in its shape.

    A Weibull distribution of the strength gives 1 - exp(-((stress - threshold) / scale)^modulus);
    an infinite modulus makes the strength a number, and the probability 0 or 1.
    """
    # ASSUME: the largest stress alone decides, not how much of the beam bears it.
    over = np.maximum(stress - device.strength_threshold, 0.0) / device.strength
    with np.errstate(over="ignore"):
        return np.round(-np.expm1(-(over**device.strength_modulus)), DECIMALS)


def stress_of(beam: Beam, basis: Basis, shapes: np.ndarray) -> Stress:
    """Return the stress of a single beam in k modes; shapes: (n, k), as in `ModalBeam`."""
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

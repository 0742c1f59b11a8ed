"""The common form of every discretisation: eq. (4) as matrices over its deflections."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..device.device import Beam

PLACES = 5
"""Number of places at which curvature is taken: 0, L/4, L/2, 3L/4 and L."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Matrices of the whole beam (twice the half beam's) over n clamped shapes.

    They are symmetric and, of a beam that is free to tilt, antisymmetric ones; no matrix couples
    these. Of a beam whose span L, rise, rho A and EI are 1; `scaled_to` gives those of another.

    mass: (n, n), rho A w w~, in rho A L
    bending: (n, n), EI w'' w~'', in EI/L^3
    geometric: (n, n), w' w~', in 1/L
    load: (n,), rho A w~, in rho A L
    midpoint: (n,), w~(L/2)
    start: (n,), the stress-free shape w0 of a cosine, in the rise
    project: the a_n of shapes, (..., TERMS) as in `device/shape.py`, -> their starts, (..., n)
    tilt: (n,), the first antisymmetric shape, its largest displacement 1; 0 of a guided beam
    curvature: (PLACES, n), w~'' there, in 1/L^2
    flexibility: axial force N (in EI/L^2) -> static deflection of the midpoint per force there
        (in L^3/EI)
    bent: likewise -> static w'' at the PLACES per force on the midpoint (in L/EI)
    complete: whether flexibility and bent are those of the n shapes; else of the exact beam
    """

    mass: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    start: np.ndarray
    project: Callable[[np.ndarray], np.ndarray]
    tilt: np.ndarray
    curvature: np.ndarray
    flexibility: Callable[[np.ndarray], np.ndarray]
    bent: Callable[[np.ndarray], np.ndarray]
    complete: bool

    def scaled_to(self, beam: Beam) -> "Basis":
        """Give the same shapes for a beam as made: ng, uN/um, 1/um, um and um/uN; N in uN."""
        unit_force, square = beam.stiffness_unit * beam.span, beam.span * beam.span
        return replace(
            self,
            mass=beam.weight * self.mass,
            bending=beam.stiffness_unit * self.bending,
            geometric=self.geometric / beam.span,
            load=beam.weight * self.load,
            start=beam.made_rise * self.start + beam.imperfection * self.tilt,
            curvature=self.curvature / square,
            flexibility=lambda force: self.flexibility(force / unit_force) / beam.stiffness_unit,
            bent=lambda force: self.bent(force / unit_force) / (beam.stiffness_unit * square),
        )


def block_diagonal(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Build the matrix of two square blocks of one size."""
    zeros = np.zeros(a.shape)
    return np.block([[a, zeros], [zeros, b]])

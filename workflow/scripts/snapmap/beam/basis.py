"""The common form of all discretisations: eq. (4) as matrices over n clamped shapes."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..device.device import Beam

PLACES = 5
"""Number of places at which curvature is evaluated: 0, L/4, L/2, 3L/4 and L."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Matrices of a whole beam whose span L, rise, rho A and EI are 1, over n clamped shapes w~.

    The shapes are symmetric; a beam that is free to tilt has as many antisymmetric ones beside
    them, and no matrix couples both kinds. `scaled_to` gives the matrices of another beam.

    mass: (n, n), rho A w w~, in rho A L
    bending: (n, n), EI w'' w~'', in EI/L^3
    geometric: (n, n), w' w~', in 1/L
    load: (n,), rho A w~, in rho A L
    midpoint: (n,), w~(L/2)
    start: (n,), coordinates of the stress-free cosine w0, in the rise
    project: maps the a_n of shapes as made, (..., TERMS), to their coordinates, (..., n)
    tilt: (n,), the first antisymmetric shape, its largest displacement 1; 0 for a guided beam
    curvature: (PLACES, n), w~'' at the PLACES, in 1/L^2
    flexibility: maps an axial force N, in EI/L^2, (...), to the static deflection of the midpoint
        per force on it, in L^3/EI, (...)
    bent: maps N likewise to the static w'' at the PLACES per force on the midpoint, in L/EI
    complete: whether flexibility and bent are those of the n shapes, not of the exact beam
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
        """Return the basis of a beam as made, in ng, uN/um, 1/um, um and um/uN, with N in uN."""
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
    """Build the block diagonal matrix of two square matrices of one size."""
    zeros = np.zeros(a.shape)
    return np.block([[a, zeros], [zeros, b]])

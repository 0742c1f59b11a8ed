"""The common form of every discretisation: eq. (4) as matrices over symmetric deflections."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..device import Beam


@dataclass(frozen=True, eq=False)
class Basis:
    """Matrices of the whole beam (twice the half beam's) over n symmetric, clamped shapes.

    Of a beam whose span L, rise, rho A and EI are 1; `scaled_to` gives those of another.

    mass: (n, n), rho A w w~, in rho A L
    bending: (n, n), EI w'' w~'', in EI/L^3
    geometric: (n, n), w' w~', in 1/L
    load: (n,), rho A w~, in rho A L
    midpoint: (n,), w~(L/2)
    start: (n,), the stress-free shape w0, in the rise
    flexibility: axial force N (in EI/L^2) -> static deflection of the midpoint per force there
        (in L^3/EI)
    complete: whether that flexibility is the n shapes' own; else it is the exact beam's
    """

    mass: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    start: np.ndarray
    flexibility: Callable[[float], float]
    complete: bool

    def scaled_to(self, beam: Beam) -> "Basis":
        """The same shapes for a beam: ng, uN/um, 1/um, um and um/uN; N in uN."""
        unit_force = beam.stiffness_unit * beam.span
        return replace(
            self,
            mass=beam.weight * self.mass,
            bending=beam.stiffness_unit * self.bending,
            geometric=self.geometric / beam.span,
            load=beam.weight * self.load,
            start=beam.rise * self.start,
            flexibility=lambda force: self.flexibility(force / unit_force) / beam.stiffness_unit,
        )

"""Small free vibrations of the beam by itself, about its shape at rest.

Linear in u, the force is -(Kb + 2 EA/2L (G q0)(G q0)^T) u: bending, which holds the axial force of
the rest, and the stretch that an arch cannot bend without. A straight beam has none of it.
"""

from dataclasses import replace

import numpy as np

from ..device import Beam
from ..numerics.linalg import apply, eigh, outer
from .elements import hermite_elements
from .prestress import settled

ELEMENTS = 10
"""On the half beam; they leave the frequency 1e-4 too high."""


def natural_frequency(beam: Beam) -> float:
    """The first symmetric mode's, of one beam without damping, rad/us.

    A free beam's imperfection mixes it with the first antisymmetric one: of these two, the lowest
    of all, it is the one that a shaken frame moves more.
    """
    basis = settled(hermite_elements(ELEMENTS, free=True), beam)
    slope = apply(basis.geometric, basis.start)
    axial = 6 * beam.bistability * beam.bistability
    squares, shapes = eigh(basis.bending + 2 * axial * outer(slope, slope), basis.mass)
    first = np.argmax(np.abs(apply(shapes.T, basis.load)[:2]))
    return float(np.sqrt(squares[first] * (beam.stiffness_unit / beam.weight)))


def damped(beam: Beam, quality_factor: float) -> Beam:
    """The beam with the damping that gives its first symmetric mode a quality factor."""
    # ASSUME: a measured one is that mode's, of the beam clear of the mass; the drag is that of all
    # modes, so that others have quality factors in proportion to their frequencies.
    return replace(beam, damping=natural_frequency(beam) / quality_factor)

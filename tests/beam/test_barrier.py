"""The barrier by the stretch equation against all equilibria that buckling branches lead to."""

import dataclasses

import numpy as np
import pytest

from snapmap.beam.cosines import symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import find_barrier
from snapmap.beam.modal import unit_modes
from snapmap.numerics.linalg import eigh

BASES = {
    "1 cosine": (symmetric_cosines(1), None),
    "3 cosines": (symmetric_cosines(3), None),
    "3 elements": (hermite_elements(3), None),
    "5 elements, 7 modes": (hermite_elements(5), 7),
    "20 elements, 4 modes": (hermite_elements(20), 4),
    "8 cosines, 4 modes": (symmetric_cosines(8), 4),
}
Q = np.unique([*np.geomspace(2.32, 50, 15), *np.linspace(2.44, 2.5, 11)])
"""Mode 2 takes part from sqrt 6 = 2.4495 on, near which Newton's method converges slowly."""


def branches(modal, basis, modes):
    """Starts of Newton's method: every root of the first mode, and every mode at its own load."""
    loads, shapes = eigh(np.diag(modal.stiffness), modal.geometric)
    s, axial = shapes.T @ modal.slope_start, modal.axial
    for q in np.roots([axial, 0.0, loads[0] - axial * s[0] ** 2, -loads[0] * s[0]]):
        if abs(q.imag) < 1e-9:
            for beside in (-0.1, 0.0, 0.1):
                yield shapes[:, 0] * (q.real - s[0]) + beside * shapes[:, -loads.size + 1]
    for j in range(1, loads.size):
        others = np.arange(loads.size) != j
        c = np.zeros(loads.size)
        c[others] = loads[j] * s[others] / (loads[others] - loads[j])
        rest = loads[j] / axial + np.sum(c * (c + 2 * s))
        for root in np.roots([1.0, 2 * s[j], rest]):
            if abs(root.imag) < 1e-9:
                c[j] = root.real
                yield shapes @ c


def forces(modal, p):
    """The force that p asks for, its derivative, and the energy."""
    slope = modal.geometric @ p + modal.slope_start
    axial_force = -modal.axial * p @ (slope + modal.slope_start)
    tangent = np.diag(modal.stiffness) - axial_force * modal.geometric
    tangent += 2 * modal.axial * np.outer(slope, slope)
    energy = p @ (modal.stiffness * p) / 2 + axial_force**2 / (4 * modal.axial)
    return modal.stiffness * p - axial_force * slope, tangent, energy


def lowest_pass(modal, basis, modes):
    """Energy and midpoint of the lowest equilibrium that is no minimum; 0 and 0 without one."""
    passes = [(np.inf, 0.0)]
    for p in branches(modal, basis, modes):
        for _ in range(50):
            force, tangent, _ = forces(modal, p)
            p = p - np.linalg.solve(tangent, force)
        force, tangent, energy = forces(modal, p)
        rests = np.linalg.norm(force) < 1e-9 * np.linalg.norm(modal.stiffness * p)
        if rests and np.linalg.eigvalsh(tangent)[0] < 0:
            passes.append((energy, modal.midpoint @ p))
    lowest = min(passes)
    return lowest if np.isfinite(lowest[0]) else (0.0, 0.0)


@pytest.mark.parametrize("name", BASES)
def test_the_barrier_is_the_lowest_pass_of_all(handout, name):
    basis, modes = BASES[name]
    for ratio in Q:
        beam = dataclasses.replace(handout.beam, thickness=handout.beam.rise / ratio)
        modal = unit_modes(basis, modes)._replace(axial=6 * beam.bistability**2)
        energy, midpoint = lowest_pass(modal, basis, modes)
        barrier = find_barrier(beam, basis, modes)
        unit = beam.stiffness_unit * beam.rise**2
        assert barrier.energy == pytest.approx(energy * unit, rel=1e-9, abs=1e-9 * unit), ratio
        assert barrier.midpoint == pytest.approx(midpoint * beam.rise, rel=1e-6), ratio

"""Equilibria of beams as made: with stress, free to tilt, and the pass between them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

import snapmap
from snapmap import Study
from snapmap.beam.basis import Basis
from snapmap.beam.cosines import antisymmetric_loads, buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import find_barrier
from snapmap.beam.modal import reduce_to_modes, settled, unit_modes
from snapmap.numerics.linalg import eigh

STRESSES = (-40.0, -5.0, 5.0, 60.0)


@pytest.mark.equation(27)
def test_antisymmetric_shapes_are_clamped_and_orthogonal():
    mu = antisymmetric_loads(6)
    np.testing.assert_allclose(np.tan(mu / 2) / (mu / 2), 1, rtol=1e-12)
    y = (np.arange(200_000) + 0.5) / 200_000 - 0.5
    shapes = np.sin(np.outer(mu, y)) / np.sin(mu / 2)[:, np.newaxis] - 2 * y
    slopes = mu[:, np.newaxis] * np.cos(np.outer(mu, y)) / np.sin(mu / 2)[:, np.newaxis] - 2
    basis = buckling_shapes(6)
    np.testing.assert_allclose(shapes @ shapes.T / y.size, basis.mass[6:, 6:], atol=1e-8)
    np.testing.assert_allclose(slopes @ slopes.T / y.size, basis.geometric[6:, 6:], atol=2e-5)
    bends = -(mu[:, np.newaxis] ** 2) * np.sin(np.outer(mu, y)) / np.sin(mu / 2)[:, np.newaxis]
    np.testing.assert_allclose(bends @ bends.T / y.size, basis.bending[6:, 6:], atol=1e-3)
    assert abs(shapes[:, [0, -1]]).max() < 1e-4 and abs(slopes[:, [0, -1]]).max() < 2e-2
    assert abs(basis.tilt[6] * shapes[0]).max() == pytest.approx(1, rel=1e-8)


def test_elements_have_the_antisymmetric_frequencies_and_shape(handout):
    bases = hermite_elements(20, free=True), buckling_shapes(20)
    low = [reduce_to_modes(handout.beam, basis, 8).stiffness for basis in bases]
    np.testing.assert_allclose(*low, rtol=4e-4)
    energies = [basis.tilt @ basis.bending @ basis.tilt for basis in bases]
    np.testing.assert_allclose(*energies, rtol=1e-4)


@pytest.mark.equation(13, 22)
@pytest.mark.parametrize("basis", [symmetric_cosines(4), hermite_elements(4)])
@pytest.mark.parametrize("stress", STRESSES)
def test_at_rest_no_force_is_left(handout, basis: Basis, stress):
    beam = replace(handout.beam, residual_stress=stress)
    rest, made = settled(basis, beam), basis.scaled_to(beam)
    assert (reduce_to_modes(beam, basis, None).residual == 0) == basis.complete
    u = beam.rise * (rest.start - basis.start)
    stretch = u @ made.geometric @ (u + 2 * made.start)
    tension = stress * beam.area + beam.axial_stiffness * stretch
    force = made.bending @ u + tension * made.geometric @ (u + made.start)
    assert abs(force).max() < 1e-9 * abs(made.bending @ made.start).max()
    assert basis.midpoint @ rest.start * beam.rise == pytest.approx(beam.height, rel=2e-3)


def test_a_free_beam_with_stress_starts_from_its_own_midpoint(handout):
    """Where its energy is least, by a search; that of a guided one is elsewhere."""
    stressed = replace(handout.beam, residual_stress=-8.0, imperfection=2.0, free=1.0)
    made = buckling_shapes(8).scaled_to(stressed)

    def energy(q):
        u = q - made.start
        stretch = q @ made.geometric @ q - made.start @ made.geometric @ made.start
        axial = stressed.residual_stress * stressed.area * stretch / 2
        return u @ made.bending @ u / 2 + axial + stressed.axial_stiffness * stretch**2 / 4

    least = minimize(energy, made.start, method="BFGS", options={"gtol": 1e-9}).x
    at_rest, rest = settled(buckling_shapes(8), stressed).scaled_to(stressed), made.midpoint @ least
    np.testing.assert_allclose(at_rest.start, least, atol=1e-4)
    assert rest == pytest.approx(10.3461, abs=1e-4) and abs(rest - stressed.height) > 0.02
    assert find_barrier(stressed, buckling_shapes(8)).first == pytest.approx(rest, abs=1e-5)
    device = replace(handout, beam=stressed)
    run = snapmap.simulate(Study(device, "3 cosines", horizon=0), 1, 1500, 25)
    assert run.w_mid[0].item() == run.z_mass[0].item() == pytest.approx(rest, abs=1e-4)


def test_tilting_lowers_the_barrier_and_may_end_it(handout):
    guided = replace(handout.beam, thickness=1.2)

    def barrier(imperfection, thickness=1.2):
        made = {"free": 1.0, "imperfection": imperfection, "thickness": thickness}
        return find_barrier(replace(guided, **made), buckling_shapes(4))

    energies = [barrier(imperfection).energy for imperfection in (1e-6, 0.003, 0.005, 2.0)]
    whole = find_barrier(guided, symmetric_cosines(4)).energy
    assert whole > energies[0] > energies[1] > energies[2] > energies[3] == 0
    assert barrier(1e-6).second == pytest.approx(guided.second_equilibrium, rel=1e-9)
    none = barrier(1e-6, thickness=2.0)
    assert (none.energy, none.midpoint) == (0, (none.second - none.first) / 2)


BASES = {
    "1 cosine": (symmetric_cosines(1), None),
    "3 cosines": (symmetric_cosines(3), None),
    "3 elements": (hermite_elements(3), None),
    "5 elements, 7 modes": (hermite_elements(5), 7),
    "20 elements, 4 modes": (hermite_elements(20), 4),
    "8 cosines, 4 modes": (symmetric_cosines(8), 4),
}
RATIOS = np.unique([*np.geomspace(2.32, 50, 15), *np.linspace(2.44, 2.5, 11)])
"""Mode 2 takes part from sqrt 6 = 2.4495 on, near which Newton's method converges slowly."""


@pytest.mark.equation(16, 17, 18)
@pytest.mark.parametrize("Q", [2.35, 2.44, 2.46, 3.0, 5.0, 12.0])
def test_the_barrier_and_the_second_shape_have_the_closed_forms(handout, Q):
    """Above Q = sqrt 6 the saddle of two modes, at N = 4 N_1; below it that of the first mode."""
    beam = replace(handout.beam, thickness=handout.beam.rise / Q)
    unit, root = np.pi**4 * beam.stiffness_unit * beam.rise**2, np.sqrt(1 - 16 / (3 * Q**2))

    def energy(s, r):
        N = 0.75 * Q**2 * (1 - s**2 - 4 * r**2)
        assert pytest.approx(1 / (1 - N), rel=1e-9) == s
        return unit * ((1 - s) ** 2 + 16 * r**2 + 2 / (3 * Q**2) * N**2)

    s, r = -(1 - root) / 2, 0.0
    if Q**2 > 6:
        s, r = -1 / 3, np.sqrt(8 / 9 - 16 / (3 * Q**2)) / 2
        assert energy(s, r) == pytest.approx(unit * (16 / 3 - 32 / (3 * Q**2)), rel=1e-12)
    barrier = find_barrier(beam, symmetric_cosines(6))
    assert barrier.energy == pytest.approx(energy(s, r), rel=1e-9)
    assert barrier.first + barrier.midpoint == pytest.approx(s * beam.rise, rel=1e-6)
    assert barrier.second == pytest.approx(-(1 + root) / 2 * beam.rise, rel=1e-9)
    assert energy(-(1 + root) / 2, 0.0) < barrier.energy


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
    return lowest if np.isfinite(lowest[0]) else (0.0, np.nan)


@pytest.mark.parametrize("name", BASES)
def test_the_barrier_is_the_lowest_pass_of_all(handout, name):
    basis, modes = BASES[name]
    for Q in RATIOS:
        beam = replace(handout.beam, thickness=handout.beam.rise / Q)
        modal = unit_modes(basis, modes)._replace(axial=6 * beam.bistability**2)
        energy, midpoint = lowest_pass(modal, basis, modes)
        barrier = find_barrier(beam, basis, modes)
        unit = beam.stiffness_unit * beam.rise**2
        assert barrier.energy == pytest.approx(energy * unit, rel=1e-9, abs=1e-9 * unit), Q
        at = (barrier.second - barrier.first) / 2 if np.isnan(midpoint) else midpoint * beam.rise
        assert barrier.midpoint == pytest.approx(at, rel=1e-6, nan_ok=True), Q

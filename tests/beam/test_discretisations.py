"""Both discretisations against quadrature, exact statics and stresses, and each other."""

from dataclasses import replace

import numpy as np
import pytest

from snapmap.beam.cosines import buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.modal import buckling, reduce_to_modes
from snapmap.beam.stress import stress_of


def test_cosines_have_the_inverse_mass_of_the_formula(handout):
    beam, m = handout.beam, 7
    basis = symmetric_cosines(m).scaled_to(beam)
    inverse = 2 / beam.weight * (np.eye(m) - 2 / (1 + 2 * m) * np.ones((m, m)))
    np.testing.assert_allclose(basis.mass @ inverse, np.eye(m), atol=1e-12)


def test_the_start_is_w0_and_the_flexibilities_agree(handout):
    beam = handout.beam
    bases = [basis.scaled_to(beam) for basis in (hermite_elements(20), symmetric_cosines(40))]
    for basis in bases:
        assert basis.midpoint @ basis.start == pytest.approx(beam.rise, rel=1e-14)
    loads = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2 * np.array([1e-6, 0.5, 2, 3.5])
    finite, cosine = ([basis.flexibility(load) for load in loads] for basis in bases)
    assert finite == pytest.approx(cosine, rel=2e-4)
    assert cosine[0] == pytest.approx(beam.span**3 / (192 * beam.bending_stiffness), rel=1e-5)


def initial_stiffness(beam, basis):
    slope = basis.geometric @ basis.start
    tangent = basis.bending + 2 * beam.axial_stiffness * np.outer(slope, slope)
    return 1 / (basis.midpoint @ np.linalg.solve(tangent, basis.midpoint))


def test_the_initial_stiffness_converges_with_order_four_in_h_to_that_of_all_modes(handout):
    beam = handout.beam
    exact = initial_stiffness(beam, symmetric_cosines(400).scaled_to(beam))
    assert exact == pytest.approx(48.8, abs=0.05)
    meshes = (hermite_elements(n).scaled_to(beam) for n in (5, 10))
    coarse, finer = (initial_stiffness(beam, basis) - exact for basis in meshes)
    assert 3.8 < np.log2(coarse / finer) < 4.2


def of_modes(beam, basis, modes=None):
    modal = reduce_to_modes(beam, basis, modes)
    return stress_of(beam, basis, modal.shapes), modal


def bent_first_shape(beam, c):
    """E t/2 |w'' - w0''| at a clamp where w = c w0, MPa."""
    curvature = 2 * np.pi**2 * beam.rise / beam.span**2
    return beam.youngs_modulus * beam.thickness / 2 * curvature * abs(c - 1)


@pytest.mark.parametrize(
    ("basis", "within"), [(symmetric_cosines(3), 1e-9), (hermite_elements(20), 4e-3)]
)
def test_the_second_shape_at_rest_has_160_mpa_of_bending_11_of_compression(handout, basis, within):
    beam, c = handout.beam, handout.beam.second_equilibrium / handout.beam.rise
    stress, modal = of_modes(beam, basis)
    p = modal.shapes.T @ (beam.weight * basis.mass @ ((c - 1) * beam.rise * basis.start))
    bent, pressed = bent_first_shape(beam, c), beam.buckling_stress * (1 - 1 / c)
    assert (bent, pressed) == pytest.approx((160, 11.3), abs=0.5)
    largest = stress.largest(p[np.newaxis], np.zeros(1), np.array([pressed * beam.area]))
    assert largest == pytest.approx(bent - pressed, rel=within)


@pytest.mark.parametrize("residual", [-20.0, 30.0])
def test_a_beam_at_rest_keeps_the_stress_that_its_rise_does_not_relieve(handout, residual):
    beam = replace(handout.beam, residual_stress=residual)
    stress, _ = of_modes(beam, symmetric_cosines(4), 3)
    c = beam.height / beam.rise
    assert stress.tension == pytest.approx(beam.buckling_stress * (1 / c - 1), rel=1e-9)
    assert abs(stress.rest).max() == pytest.approx(bent_first_shape(beam, c), rel=1e-9)
    made, _ = of_modes(handout.beam, symmetric_cosines(4))
    assert made.tension == 0 and not made.rest.any()


@pytest.mark.parametrize("modes", [1, 3, 9])
def test_a_static_force_bends_few_modes_as_it_bends_the_exact_beam(handout, modes):
    """By P L/8 tan(u)/u, u = L/4 sqrt(N/EI), at the clamps and at midspan; here N = 2 N_1."""
    beam = handout.beam
    stress, modal = of_modes(beam, symmetric_cosines(9), modes)
    axial_force = 2 * beam.buckling_stress * beam.area
    tangent = np.diag(modal.stiffness) - axial_force * modal.geometric
    u = np.pi / np.sqrt(2)
    moment = beam.span / 8 * np.tan(u) / u
    exact = beam.youngs_modulus * beam.thickness / 2 * moment / beam.bending_stiffness
    bent = stress.bending @ np.linalg.solve(tangent, modal.midpoint) + stress.residual
    np.testing.assert_allclose(bent, exact * np.array([1, 0, -1, 0, 1]), atol=1e-12 * abs(exact))


@pytest.mark.parametrize("elements", [20, 21])
def test_buckling_shapes_of_elements_curve_as_the_exact_ones(elements):
    """Symmetric and antisymmetric; a quarter of the span is a node, or between two."""
    finite, exact = hermite_elements(elements, free=True), buckling_shapes(8)
    curved = [basis.curvature @ buckling(basis)[1][:, :4] for basis in (finite, exact)]
    signs = np.sign(curved[0][0] * curved[1][0])
    np.testing.assert_allclose(curved[0] * signs, curved[1], atol=0.02 * abs(curved[1]).max())
    np.testing.assert_allclose(finite.bent(30.0), exact.bent(30.0), atol=1e-2 / 8)

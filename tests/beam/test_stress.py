"""Stress along the beam against closed forms, and the same in every basis."""

from dataclasses import replace

import numpy as np
import pytest

from snapmap.beam.cosines import buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.modal import buckling, reduce_to_modes
from snapmap.beam.stress import stress_of


def of_modes(beam, basis, modes=None):
    modal = reduce_to_modes(beam, basis, modes)
    return stress_of(beam, basis, modal.shapes), modal


def bent_first_shape(beam, c):
    """E t/2 |w'' - w0''| at a clamp where w = c w0, MPa."""
    curvature = 2 * np.pi**2 * beam.rise / beam.span**2
    return beam.youngs_modulus * beam.thickness / 2 * curvature * abs(c - 1)


@pytest.mark.parametrize(("basis", "within"), [(symmetric_cosines(3), 1e-9), (None, 4e-3)])
def test_the_second_shape_at_rest_has_160_mpa_of_bending_and_11_of_compression(
    handout, basis, within
):
    beam, basis = handout.beam, basis or hermite_elements(20)
    stress, modal = of_modes(beam, basis)
    to_second = (beam.second_equilibrium / beam.rise - 1) * beam.rise * basis.start
    p = modal.shapes.T @ (beam.weight * basis.mass @ to_second)
    bent = bent_first_shape(beam, beam.second_equilibrium / beam.rise)
    pressed = beam.buckling_stress * (1 - beam.rise / beam.second_equilibrium)
    assert (bent, pressed) == pytest.approx((160, 11.3), abs=0.5)
    found = stress.largest(p[np.newaxis], np.zeros(1), np.array([pressed * beam.area]))
    assert found == pytest.approx(bent - pressed, rel=within)


@pytest.mark.parametrize("residual", [-20.0, 30.0])
def test_what_is_left_of_residual_stress_at_rest(handout, residual):
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
    bent = beam.youngs_modulus * beam.thickness / 2 * moment / beam.bending_stiffness
    found = stress.bending @ np.linalg.solve(tangent, modal.midpoint) + stress.residual
    np.testing.assert_allclose(found, bent * np.array([1, 0, -1, 0, 1]), atol=1e-12 * abs(bent))


@pytest.mark.parametrize("elements", [20, 21])
def test_buckling_shapes_of_elements_curve_as_the_exact_ones(elements):
    """Symmetric and antisymmetric; a quarter of the span is a node, or between two."""
    finite, exact = hermite_elements(elements, free=True), buckling_shapes(8)
    curved = [basis.curvature @ buckling(basis)[1][:, :4] for basis in (finite, exact)]
    signs = np.sign(curved[0][0] * curved[1][0])
    np.testing.assert_allclose(curved[0] * signs, curved[1], atol=0.02 * abs(curved[1]).max())
    np.testing.assert_allclose(finite.bent(30.0), exact.bent(30.0), atol=1e-2 / 8)

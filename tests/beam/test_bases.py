"""Both discretisations against quadrature, exact statics and each other."""

import numpy as np
import pytest

from snapmap.beam.cosines import symmetric_cosines
from snapmap.beam.elements import hermite_elements


def test_cosines_have_the_inverse_mass_of_the_formula(handout):
    beam, m = handout.beam, 7
    basis = symmetric_cosines(m).scaled_to(beam)
    weight = beam.mass_per_length * beam.span
    inverse = 2 / weight * (np.eye(m) - 2 / (1 + 2 * m) * np.ones((m, m)))
    np.testing.assert_allclose(basis.mass @ inverse, np.eye(m), atol=1e-12)


def bases(beam):
    return [hermite_elements(20).scaled_to(beam), symmetric_cosines(40).scaled_to(beam)]


def test_the_start_is_w0_and_the_flexibilities_agree(handout):
    beam = handout.beam
    finite, cosine = bases(beam)
    for basis in (finite, cosine):
        assert basis.midpoint @ basis.start == pytest.approx(beam.rise, rel=1e-14)
    unit = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    for axial_force in (1e-6 * unit, 0.5 * unit, 2 * unit, 3.5 * unit):
        assert finite.flexibility(axial_force) == pytest.approx(
            cosine.flexibility(axial_force), rel=2e-4
        )
    assert cosine.flexibility(1e-6 * unit) == pytest.approx(
        beam.span**3 / (192 * beam.bending_stiffness), rel=1e-5
    )


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

"""Both discretisations against quadrature, exact statics and each other."""

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from snapmap.beam import elements
from snapmap.beam.cosines import symmetric_cosines
from snapmap.beam.elements import hermite_elements


def shape_functions(a, h):
    """The handout's N1 to N4, their first and second derivatives by x."""
    n = np.array([2 * a**3 - 3 * a**2 + 1, h * (a**3 - 2 * a**2 + a)])
    n = np.vstack([n, [-2 * a**3 + 3 * a**2, h * (a**3 - a**2)]])
    slope = np.array([6 * a**2 - 6 * a, h * (3 * a**2 - 4 * a + 1)]) / h
    slope = np.vstack([slope, np.array([-6 * a**2 + 6 * a, h * (3 * a**2 - 2 * a)]) / h])
    bend = np.array([12 * a - 6, h * (6 * a - 4), -12 * a + 6, h * (6 * a - 2)]) / h**2
    return n, slope, bend


def test_element_matrices_are_the_integrals_of_the_shape_functions():
    h = 60.0
    points, weights = leggauss(6)
    n, slope, bend = shape_functions((points + 1) / 2, h)
    weights = weights * h / 2
    for order, values in enumerate((n, slope, bend)):
        integral, size = np.einsum("ip,jp,p->ij", values, values, weights), 1e-12
        closed = elements._integrals(order, h)
        np.testing.assert_allclose(closed, integral, rtol=size, atol=size * abs(integral).max())
    np.testing.assert_allclose(elements._load(h), n @ weights, rtol=1e-13)


@pytest.mark.parametrize("mass_matrix", ["consistent", "hrz"])
def test_a_rigid_lift_of_the_free_nodes_weighs_the_beam_less_the_clamps(handout, mass_matrix):
    beam = handout.beam
    basis = hermite_elements(40, mass_matrix).scaled_to(beam)
    lift = np.zeros(79)
    lift[0::2] = 1.0
    weight = beam.mass_per_length * beam.span
    assert lift @ basis.mass @ lift == pytest.approx(weight, rel=0.02)
    assert lift @ basis.load == pytest.approx(weight, rel=0.015)


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


def test_initial_stiffness_under_a_midpoint_force(handout):
    beam = handout.beam
    exact = initial_stiffness(beam, symmetric_cosines(400).scaled_to(beam))
    assert exact == pytest.approx(48.8, abs=0.05)
    finite = initial_stiffness(beam, hermite_elements(20).scaled_to(beam))
    assert finite == pytest.approx(exact, rel=1e-4)


def test_the_initial_stiffness_converges_with_order_four_in_h(handout):
    beam = handout.beam
    coarse, finer, exact = (
        initial_stiffness(beam, hermite_elements(n).scaled_to(beam)) for n in (5, 10, 160)
    )
    assert 3.8 < np.log2((coarse - exact) / (finer - exact)) < 4.2


def residual_force(beam, basis, q):
    """Internal force of eq. (4) at deflection q."""
    axial = beam.axial_stiffness * (basis.start @ basis.geometric @ basis.start)
    axial -= beam.axial_stiffness * (q @ basis.geometric @ q)
    return basis.bending @ (q - basis.start) - axial * basis.geometric @ q


def energy(beam, basis, q):
    stretch = basis.start @ basis.geometric @ basis.start - q @ basis.geometric @ q
    bent = q - basis.start
    return bent @ basis.bending @ bent / 2 + beam.axial_stiffness * stretch**2 / 4


def test_w2_is_an_equilibrium(handout):
    beam = handout.beam
    basis = symmetric_cosines(6).scaled_to(beam)
    q = np.zeros(6)
    q[0] = beam.second_equilibrium / 2
    assert abs(residual_force(beam, basis, q)).max() < 1e-9 * beam.bending_stiffness / beam.span**2
    assert beam.second_equilibrium == pytest.approx(-9.43471, abs=1e-5)
    assert energy(beam, basis, q) == pytest.approx(385.962, abs=1e-3)


def test_the_saddle_is_an_equilibrium_with_the_second_mode(handout):
    beam = handout.beam
    basis = symmetric_cosines(6).scaled_to(beam)
    q = np.zeros(6)
    q[0] = -beam.rise / 6
    unit = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    stretch = basis.start @ basis.geometric @ basis.start - 4 * unit / beam.axial_stiffness
    q[1] = np.sqrt((stretch - q[0] ** 2 * basis.geometric[0, 0]) / basis.geometric[1, 1])
    assert abs(residual_force(beam, basis, q)).max() < 1e-9 * unit
    assert basis.midpoint @ q == pytest.approx(-beam.rise / 3)
    assert energy(beam, basis, q) == pytest.approx(486.805, abs=1e-3)


def test_the_static_force_peaks_where_the_second_mode_buckles(handout):
    """At N = 4 N_1 the deflection is linear in the force: two forces meet eq. (4)."""
    beam = handout.beam
    basis = symmetric_cosines(801).scaled_to(beam)
    odd = np.arange(0, 801, 2)
    axial = 4 * beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    bending, geometric = np.diag(basis.bending)[odd], np.diag(basis.geometric)[odd]
    start, midpoint = basis.start[odd], basis.midpoint[odd]
    tangent = bending - axial * geometric
    fixed, per_force = bending * start / tangent, -midpoint / tangent
    coefficients = [
        np.sum(geometric * per_force**2),
        2 * np.sum(geometric * per_force * fixed),
        np.sum(geometric * (fixed**2 - start**2)) + axial / beam.axial_stiffness,
    ]
    top, bottom = sorted(np.roots(coefficients), reverse=True)
    drops = [beam.rise - midpoint @ (fixed + force * per_force) for force in (top, bottom)]
    assert (top, bottom) == pytest.approx((70.67, -32.54), abs=0.01)
    assert drops == pytest.approx([2.349, 18.39], abs=0.005)
    assert (bottom - top) / (drops[1] - drops[0]) == pytest.approx(-6.43, abs=0.01)

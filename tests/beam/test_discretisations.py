"""Both discretisations against quadrature, exact statics and stresses, and each other."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import leggauss

from snapmap.beam.cosines import buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.modal import buckling, reduce_to_modes
from snapmap.beam.stress import stress_of


@pytest.mark.equation(15)
def test_cosines_have_the_inverse_mass_of_the_formula(handout):
    beam, m = handout.beam, 7
    basis = symmetric_cosines(m).scaled_to(beam)
    inverse = 2 / beam.weight * (np.eye(m) - 2 / (1 + 2 * m) * np.ones((m, m)))
    np.testing.assert_allclose(basis.mass @ inverse, np.eye(m), atol=1e-12)


def of_page(h):
    """k/EI, g, m/(rho A) and f/(rho A) of an element, as docs/theory.md has them."""
    a, b = 6 * h, h * h
    k = [[12, a, -12, a], [a, 4 * b, -a, 2 * b], [-12, -a, 12, -a], [a, 2 * b, -a, 4 * b]]
    g = [[36, 3 * h, -36, 3 * h], [3 * h, 4 * b, -3 * h, -b]]
    g += [[-36, -3 * h, 36, -3 * h], [3 * h, -b, -3 * h, 4 * b]]
    m = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * b, 13 * h, -3 * b]]
    m += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * b, -22 * h, 4 * b]]
    f = [h / 2, b / 12, h / 2, -b / 12]
    return np.array(k) / h**3, np.array(g) / (30 * h), h / 420 * np.array(m), np.array(f)


def shapes_of_page(xi, h):
    """The handout's N_i, and the derivatives in the table of the page, each (4, points)."""
    values = [2 * xi**3 - 3 * xi**2 + 1, h * (xi**3 - 2 * xi**2 + xi)]
    values += [-2 * xi**3 + 3 * xi**2, h * (xi**3 - xi**2)]
    slopes = [6 * xi**2 - 6 * xi, h * (3 * xi**2 - 4 * xi + 1)]
    slopes += [-6 * xi**2 + 6 * xi, h * (3 * xi**2 - 2 * xi)]
    bends = [12 * xi - 6, h * (6 * xi - 4), -12 * xi + 6, h * (6 * xi - 2)]
    return np.array(values), np.array(slopes) / h, np.array(bends) / h**2


@pytest.mark.equation(9)
def test_a_cubic_is_its_own_interpolant_with_both_derivatives():
    h, xi = 0.7, np.linspace(0, 1, 9)
    cubic = Polynomial([0.3, -1.1, 0.8, 2.3])
    slope = cubic.deriv()
    v = np.array([cubic(0), slope(0), cubic(h), slope(h)])
    for order, shapes in enumerate(shapes_of_page(xi, h)):
        exact = cubic.deriv(order)(h * xi)
        np.testing.assert_allclose(v @ shapes, exact, atol=1e-13)


@pytest.mark.equation(10, 11, 12)
def test_the_matrices_of_an_element_are_the_integrals_of_its_shapes():
    h, (s, weights) = 0.7, leggauss(5)
    N, slopes, bends = shapes_of_page((1 + s) / 2, h)
    k, g, m, f = of_page(h)
    for part, one, other in (k, bends, bends), (g, slopes, slopes), (m, N, N), (f, N, 1 + 0 * N[0]):
        np.testing.assert_allclose(part, one * weights @ other.T * h / 2, atol=1e-13)
    lumped = 420 / 312 * np.diag(m)
    np.testing.assert_allclose(lumped, h * np.array([1 / 2, h**2 / 78, 1 / 2, h**2 / 78]))


@pytest.mark.equation(7, 10, 11)
@pytest.mark.parametrize("n", [1, 3, 5])
def test_the_doubled_half_beam_is_the_whole_beam_that_moves_symmetrically(n):
    """Of twice as many elements, clamped at both ends; each node stands for its mirror image."""
    parts, size = of_page(1 / (2 * n)), 4 * n + 2
    whole = [np.zeros([size] * part.ndim) for part in parts]
    for full, part in zip(whole, parts, strict=True):
        for i in range(0, size - 2, 2):
            full[(slice(i, i + 4),) * part.ndim] += part
    mirrored = np.zeros((size, 2 * n - 1))
    for node in range(1, n + 1):
        mirrored[2 * node, 2 * node - 2] = mirrored[size - 2 - 2 * node, 2 * node - 2] = 1
        if node < n:
            mirrored[2 * node + 1, 2 * node - 1] = 1
            mirrored[size - 1 - 2 * node, 2 * node - 1] = -1
    half, bending = hermite_elements(n), whole[0]
    for ours, full in zip((half.bending, half.geometric, half.mass), whole, strict=False):
        expected = mirrored.T @ full @ mirrored
        np.testing.assert_allclose(ours, expected, atol=1e-13 * abs(expected).max())
    np.testing.assert_allclose(half.load, whole[3] @ mirrored, atol=1e-14)
    assert abs(bending - bending.T).max() == 0 and half.load.size == 2 * n - 1


@pytest.mark.equation(15)
def test_cosines_have_the_diagonal_matrices_of_the_formula(handout):
    """Sums over a period of the span, exact for so few waves."""
    beam, n = handout.beam, np.arange(1, 6)[:, np.newaxis]
    x = np.arange(40) / 40 * beam.span
    alpha, cell = 2 * np.pi * n / beam.span, beam.span / x.size
    shapes, slopes, bends = 1 - np.cos(alpha * x), alpha * np.sin(alpha * x), alpha**2
    bends = bends * np.cos(alpha * x)
    basis = symmetric_cosines(5).scaled_to(beam)
    cases = [(basis.bending, bends, beam.bending_stiffness), (basis.geometric, slopes, 1.0)]
    cases.append((basis.mass, shapes, beam.weight / beam.span))
    for ours, one, factor in cases:
        np.testing.assert_allclose(ours, factor * cell * one @ one.T, atol=1e-12 * abs(ours).max())


@pytest.mark.equation(24)
@pytest.mark.parametrize("n", [3, 8])
def test_a_shape_as_made_is_projected_by_its_slopes(n):
    """What is left has no slope in common with a shape. A shallow arc has a_n = 8 / (n pi)^2."""
    a, (s, weights) = np.array([0.9, -0.2, 0.1, 0.05, 0.02]), leggauss(20)
    h, basis = 1 / (2 * n), hermite_elements(n)
    q = np.concatenate([[0.0, 0.0], basis.project(a), [0.0]])
    waves, left = 2 * np.pi * np.arange(1, 6), np.zeros(2 * n + 2)
    for i in range(n):
        x = h * (i + (1 + s) / 2)
        slopes = shapes_of_page((1 + s) / 2, h)[1]
        made = a / 2 * waves @ np.sin(np.outer(waves, x))
        left[2 * i : 2 * i + 4] += slopes * weights @ (q[2 * i : 2 * i + 4] @ slopes - made)
    assert abs(np.delete(left, [0, 1, -1])).max() < 1e-12
    x, share = (1 + s) / 2, weights / 2
    arc = [share @ (4 * (1 - 2 * x) * wave * np.sin(wave * x)) for wave in waves]
    np.testing.assert_allclose(arc / (waves / 2) ** 2, 32 / waves**2, rtol=1e-9)


@pytest.mark.equation(1)
def test_the_start_is_w0_and_the_flexibilities_agree(handout):
    beam = handout.beam
    bases = [basis.scaled_to(beam) for basis in (hermite_elements(20), symmetric_cosines(40))]
    for basis in bases:
        assert basis.midpoint @ basis.start == pytest.approx(beam.rise, rel=1e-14)
    nodes = np.arange(1, 21) / 40
    w0 = beam.rise / 2 * (1 - np.cos(2 * np.pi * nodes))
    np.testing.assert_allclose(bases[0].start[::2], w0, rtol=1e-13)
    loads = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2 * np.array([1e-6, 0.5, 2, 3.5])
    finite, cosine = ([basis.flexibility(load) for load in loads] for basis in bases)
    assert finite == pytest.approx(cosine, rel=2e-4)
    assert cosine[0] == pytest.approx(beam.span**3 / (192 * beam.bending_stiffness), rel=1e-5)


def initial_stiffness(beam, basis):
    slope = basis.geometric @ basis.start
    tangent = basis.bending + 2 * beam.axial_stiffness * np.outer(slope, slope)
    return 1 / (basis.midpoint @ np.linalg.solve(tangent, basis.midpoint))


@pytest.mark.equation(19)
def test_the_initial_stiffness_converges_with_order_four_in_h_to_that_of_all_modes(handout):
    beam = handout.beam
    exact = initial_stiffness(beam, symmetric_cosines(400).scaled_to(beam))
    first, stiffer = 8 * np.pi**4 * beam.stiffness_unit, 1 + 1.5 * beam.bistability**2
    softness = 1 / (192 * beam.stiffness_unit) - 4 / first * (1 - 1 / stiffer)
    assert exact == pytest.approx(1 / softness, rel=1e-6) == pytest.approx(48.8, abs=0.05)
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


@pytest.mark.equation(26)
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


@pytest.mark.equation(26)
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

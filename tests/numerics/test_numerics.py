"""The portable sine, ranges and small matrices: exact values, and alone against in company."""

from decimal import Decimal

import numpy as np
import pytest

from snapmap.numerics import pieces, portable
from snapmap.numerics.kernels import sine
from snapmap.numerics.linalg import apply, dot, eigh, multiply, solve
from snapmap.numerics.portable import evenly, geometric, linear

SIZES = [1, 2, 3, 8, 19]


def test_the_sine_is_right_to_two_units_in_the_last_place_and_exact_where_it_can_be():
    turns = [0.0, 0.25, 0.5, 0.75, 1.0, -0.25, 7.25]
    assert [sine(value) for value in turns] == [0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 1.0]
    turns = np.random.default_rng(0).uniform(-0.25, 0.25, 2000)
    values = np.array([sine(value) for value in turns])
    pi = np.longdouble("3.14159265358979323846264338327950288")
    exact = np.sin(2 * pi * turns.astype(np.longdouble))
    assert (abs(values - exact) <= 2 * np.spacing(abs(values))).all()
    assert [portable.sine(value) for value in turns] == values.tolist()


def test_the_sine_of_an_array_has_the_bits_of_the_sine_of_each_number():
    rng = np.random.default_rng(2)
    spread = rng.normal(size=5000) * np.ldexp(1.0, rng.integers(-1000, 50, 5000))
    quarters, near = np.arange(-41, 42) / 4, np.nextafter(0.25, [0.0, 1.0])
    turns = np.concatenate([rng.uniform(-3, 3, 5000), spread, quarters, near, [0.0, -0.0]])
    each = np.array([portable.sine(value) for value in turns.tolist()])
    assert portable.sines(turns).tobytes() == each.tobytes()
    assert portable.sines(turns[:12].reshape(3, 4)).shape == (3, 4)


def test_ranges_have_even_steps_right_to_14_digits_and_finer_ones_the_same_values():
    values = geometric(100.0, 3e4, 31)
    assert values[0] == 100.0 and values[-1] == 3e4 and geometric(5.0, 5.0, 1).tolist() == [5.0]
    np.testing.assert_allclose(values[1:] / values[:-1], 300 ** (1 / 30), rtol=1e-13)
    exact = Decimal(100) * (Decimal(300) ** (Decimal(1) / 7)) ** 3
    assert geometric(100.0, 3e4, 8)[3] == float(f"{exact:.14g}")
    assert linear(600.0, 2400.0, 91).tolist() == list(range(600, 2401, 20))
    assert set(values) < set(geometric(100.0, 3e4, 91))
    assert set(linear(0.1, 0.7, 4)) < set(linear(0.1, 0.7, 13))


def test_a_few_places_of_many_are_even_with_both_ends():
    assert [evenly(20, 4), evenly(5, 9), evenly(1, 3)] == [[0, 6, 13, 19], [*range(5)], [0]]


LINE, WAVE = [0.0, 0.2, 0.5, 0.0, 0.0, 0.0], [0.25, 0.325, 0.0, 0.75, 0.5, -0.3]


def test_pieces_are_lines_and_waves_with_the_increments_of_their_values():
    curve, phase = np.array([LINE, WAVE]), 1.5 * np.pi * 0.35
    wave = 0.325 + 0.5 * (1 - np.cos(phase)) - 0.3 * np.sin(phase)
    values = pieces.value(curve, 0, 0.1), pieces.value(curve, 1, 0.6)
    assert values == pytest.approx((0.25, wave), rel=1e-15)
    assert [pieces.at(curve, 0, 2, x) for x in (0.0, 0.24, 0.25, 1.0)] == [0, 0, 1, 1]
    assert pieces.at(curve, 0, 1, 0.9) == 0
    grown = wave - pieces.value(curve, 1, 0.5), 0.05
    made = [pieces.increment(*piece[2:], s, 0.1) for piece, s in ((WAVE, 0.35), (LINE, 0.2))]
    assert made == pytest.approx(grown, rel=1e-14)


@pytest.mark.parametrize(("slope", "ends"), [(0.0, (1.0, 1.0)), (-1.0, (1.0, 0.0))])
@pytest.mark.parametrize("step", [0.25, 0.22, 0.3, 0.17])
def test_samples_of_a_curve_that_jumps_add_up_to_its_integral(slope, ends, step):
    """Of its line to order two, and exactly at its jumps."""
    curve, samples = np.array([[0.0, 1.0, slope, 0.0, 0.0, 0.0]]), pieces.lasts(ends[1], step)
    total = step * sum(pieces.sample(curve, 0, ends, n * step, step) for n in range(samples))
    assert total == pytest.approx(1 + slope / 2, rel=1e-14, abs=abs(slope) * step * step / 2)
    assert samples == (np.floor(1 / step + 0.5) + 1 if ends[1] else np.ceil(1 / step))


def matrices(size, count=5):
    """Symmetric matrices, and positive definite ones."""
    rng = np.random.default_rng(size)
    a, b = rng.normal(size=(2, count, size, size))
    return a + a.swapaxes(1, 2), b @ b.swapaxes(1, 2) + np.eye(size)


@pytest.mark.parametrize("size", SIZES)
def test_products_are_those_of_numpy(size):
    a, b = matrices(size)
    np.testing.assert_allclose(multiply(a, b), a @ b, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(apply(a, b[:, 0]), np.einsum("aij,aj->ai", a, b[:, 0]), atol=1e-12)
    np.testing.assert_allclose(dot(a[:, 0], b[:, 0]), np.sum(a[:, 0] * b[:, 0], 1), atol=1e-12)


@pytest.mark.parametrize("size", SIZES)
def test_solutions_leave_a_residual_of_rounding(size):
    a, b = matrices(size)
    if size > 1:
        a[0, 0, 0] = 0.0  # a pivot that must be passed over
    x = solve(a, b[:, 0])
    scale = np.linalg.norm(a, axis=(1, 2)) * np.linalg.norm(x, axis=1)
    residual = np.linalg.norm(apply(a, x) - b[:, 0], axis=1)
    assert (residual < 1e-14 * size * scale).all()


@pytest.mark.parametrize("size", SIZES)
def test_eigenvectors_are_orthonormal_in_the_mass_and_ascend(size):
    a, mass = matrices(size)
    values, vectors = eigh(a, mass)
    unit, turned = np.swapaxes(vectors, 1, 2) @ mass @ vectors, mass @ vectors * values[:, None]
    np.testing.assert_allclose(unit, np.broadcast_to(np.eye(size), a.shape), atol=1e-12)
    np.testing.assert_allclose(a @ vectors, turned, atol=1e-12 * abs(a).max() * size)
    assert (np.diff(values) >= 0).all()
    largest = np.abs(vectors).argmax(axis=1)[:, np.newaxis]
    assert (np.take_along_axis(vectors, largest, axis=1) > 0).all()


@pytest.mark.parametrize("size", SIZES)
def test_eigenvalues_do_not_depend_on_other_matrices(size):
    a, _ = matrices(size, count=600)
    assert np.array_equal(eigh(a)[0][7], eigh(a[7])[0])


def test_small_eigenvalues_keep_their_digits_where_lapack_loses_them():
    """A graded matrix: D H D, of which every eigenvalue is known to high relative accuracy."""
    scale = 10.0 ** -np.arange(0, 15, 3)
    well = np.full((5, 5), 0.1) + 0.9 * np.eye(5)
    values, _ = eigh(scale[:, np.newaxis] * well * scale)
    exact = np.linalg.det(well) * np.prod(scale**2)
    assert np.prod(values) == pytest.approx(exact, rel=1e-12)


def test_no_result_depends_on_its_company():
    a, mass = matrices(6, count=40)
    mass[3] = np.nan
    together = *eigh(a), *eigh(a, mass), solve(a, mass[:, 0])
    for i in (0, 17, 39):
        alone = *eigh(a[i]), *eigh(a[i], mass[i]), solve(a[i], mass[i, 0])
        for single, many in zip(alone, together, strict=True):
            assert np.array_equal(single, many[i])

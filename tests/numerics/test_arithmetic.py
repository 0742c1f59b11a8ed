"""The sine and the ranges against exact values."""

from decimal import Decimal

import numpy as np
import pytest

from snapmap.numerics import portable
from snapmap.numerics.kernels import sine
from snapmap.numerics.portable import geometric, linear


def test_the_sine_is_exact_where_it_can_be():
    turns = [0.0, 0.25, 0.5, 0.75, 1.0, -0.25, 7.25]
    assert [sine(value) for value in turns] == [0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 1.0]


def test_the_sine_is_right_to_two_units_in_the_last_place():
    turns = np.random.default_rng(0).uniform(-0.25, 0.25, 2000)
    found = np.array([sine(value) for value in turns])
    pi = np.longdouble("3.14159265358979323846264338327950288")
    exact = np.sin(2 * pi * turns.astype(np.longdouble))
    assert (abs(found - exact) <= 2 * np.spacing(abs(found))).all()
    assert [portable.sine(value) for value in turns] == found.tolist()


def test_the_sine_has_the_same_value_after_whole_turns():
    for turns in (0.125, 0.3, 0.4375):
        assert sine(turns + 3) == pytest.approx(sine(turns), abs=1e-15)
        assert sine(-turns) == -sine(turns)


def test_ranges_have_their_ends_and_even_steps():
    values = geometric(100.0, 3e4, 31)
    assert values[0] == 100.0 and values[-1] == 3e4
    np.testing.assert_allclose(values[1:] / values[:-1], 300 ** (1 / 30), rtol=1e-13)
    assert linear(600.0, 2400.0, 91).tolist() == list(range(600, 2401, 20))
    assert geometric(5.0, 5.0, 1).tolist() == [5.0]


def test_a_finer_range_has_the_values_of_the_coarse_one():
    assert set(geometric(100.0, 3e4, 31)) < set(geometric(100.0, 3e4, 91))
    assert set(linear(0.1, 0.7, 4)) < set(linear(0.1, 0.7, 13))


def test_a_range_of_ratios_is_right_to_the_last_of_14_digits():
    exact = Decimal(100) * (Decimal(300) ** (Decimal(1) / 7)) ** 3
    assert geometric(100.0, 3e4, 8)[3] == float(f"{exact:.14g}")

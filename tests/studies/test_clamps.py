"""Clamps that turn: closed forms, elements and the package agree."""

import numpy as np
import pytest

from snapmap.beam import limit_loads
from snapmap.numerics.linalg import eigh
from studies import clamps

SOFT = 0.02


def order_of(value, exact):
    """The order at which what elements give converges to a closed form."""
    coarse, fine = (abs(value(clamps.turning_elements(n, SOFT)) - exact) for n in (10, 20))
    return np.log2(coarse / fine)


def test_elements_converge_to_the_beam_column_at_fourth_order(handout):
    for matrix, root in (("geometric", clamps.buckling_root), ("mass", clamps.vibration_root)):

        def lowest(basis, matrix=matrix):
            return eigh(basis.bending, getattr(basis, matrix))[0][0]

        power = 2 if matrix == "geometric" else 4
        assert order_of(lowest, root(SOFT) ** power) == pytest.approx(4, abs=0.1)
    exact = clamps.static_threshold(handout, clamps.exact(SOFT))
    static = order_of(lambda b: clamps.static_threshold(handout, clamps.of_elements(b)), exact)
    assert static == pytest.approx(4, abs=0.2)


def test_rigid_clamps_are_those_of_the_package(handout):
    ours = clamps.static_threshold(handout, clamps.exact(0.0))
    assert ours == pytest.approx(limit_loads.static_threshold(handout), rel=1e-7)
    bases = (clamps.turning_elements(10, b) for b in (0.0, 1e-7))
    rigid, nearly = (clamps.thresholds(handout, basis, [1500.0]) for basis in bases)
    assert nearly == pytest.approx(rigid, rel=1e-4)


def test_a_stiff_clamp_acts_as_a_longer_span_on_the_straight_beam():
    """By EI/k at each end: load and frequency fall by 4 b, and the end has the slope 2 pi b."""
    b = 1e-6
    for root in (clamps.buckling_root, clamps.vibration_root):
        assert ((root(b) / root(0.0)) ** 2 - 1) / b == pytest.approx(-4, rel=1e-4)
    assert clamps.slope(b) / b == pytest.approx(2 * np.pi, rel=1e-4)


def test_a_half_plane_turns_by_16_or_18():
    """Flamant's displacement -2/pi ln|x - y| of stresses on strips of a root of width 1."""
    edges = np.linspace(-0.5, 0.5, 401)
    y, width = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
    apart = np.abs(edges[:, np.newaxis] - edges) + np.finfo(float).tiny
    twice = apart**2 * (np.log(apart) / 2 - 3 / 4)
    pairs = twice[1:, :-1] + twice[:-1, 1:] - twice[1:, 1:] - twice[:-1, :-1]
    turning = -2 / np.pi * pairs / width
    linear = 12 * y
    assert np.pi * linear @ turning @ linear * width == pytest.approx(18, rel=1e-3)
    stress = np.linalg.solve(turning, y)  # of a root that turns as a whole by 1
    assert np.pi / (stress @ y * width) == pytest.approx(16, rel=1e-2)

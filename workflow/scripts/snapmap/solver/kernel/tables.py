"""Potentials of a user's laws as tables of cubics."""

from collections.abc import Callable

import numpy as np

CELLS = 2048
"""Number of cells of a table, even, as 0 is a node."""
FINE = 0.03
"""Distance from 0 at which the cells of a table are four times as long as at 0, over the reach."""
GAUSS = np.sqrt(0.6) * np.array([-1, 0, 1]), np.array([5, 8, 5]) / 18
"""Points of a cell from -1 to 1, and their weights, for the integral of a law."""
INSIDE = 1 - 1e-9
"""Points near the ends of a cell, as a law may jump at 0."""


def potentials(force: Callable[[np.ndarray], np.ndarray], reach: float) -> np.ndarray:
    """Tabulate the integral of a force from 0 to x, uN and um, in cubics of cells: (CELLS, 4)."""
    v = (2 * np.arange(CELLS + 1) / CELLS - 1) / (1 + FINE)
    nodes, fine = FINE * reach * v / (1 - abs(v)), FINE * reach
    middle, half = (nodes[1:] + nodes[:-1]) / 2, np.diff(nodes) / 2
    shares, weights = GAUSS
    points = middle + np.multiply.outer([*shares, -INSIDE, INSIDE], half)
    *forces, left, right = force(points.ravel()).reshape(points.shape)
    mean = sum(weight * F for weight, F in zip(weights, forces, strict=True))
    energy = np.append(0.0, np.cumsum(2 * half * mean))
    per = (1 + FINE) * CELLS / 2 * fine / (fine + abs(nodes)) ** 2
    begins, ends = left / per[:-1], right / per[1:]
    gain = np.diff(energy)
    cubics = energy[:-1], begins, 3 * gain - 2 * begins - ends, begins + ends - 2 * gain
    return np.column_stack(cubics) - [[energy[CELLS // 2], 0.0, 0.0, 0.0]]


def least_energy(table: np.ndarray) -> float:
    """Return an energy below which no cubic of a table lies, or -inf if it falls beyond its ends.

    A cubic lies above the least of its four points of control.
    """
    a, b, c, d = table.T
    if b[0] > 0 or (b + 2 * c + 3 * d)[-1] < 0:
        return -np.inf
    return min(a.min(), *(part.min() for part in (a + b / 3, a + (2 * b + c) / 3, a + b + c + d)))


def look_up(table: np.ndarray, reach: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return energies and forces at x, up to the reach on either side, as the kernel does."""
    fine, per = FINE * reach, (1 + FINE) * CELLS / 2
    place = per * x / (fine + abs(x)) + CELLS / 2
    cell = np.clip(place.astype(np.int64), 0, CELLS - 1)
    t, (a, b, c, d) = place - cell, table[cell].T
    force = (b + t * (2 * c + t * 3 * d)) * per * fine / (fine + abs(x)) ** 2
    return a + t * (b + t * (c + t * d)), force

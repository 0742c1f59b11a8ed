"""The barrier between the beam's two shapes, in a reduced model's own terms."""

from typing import NamedTuple

import numpy as np

from .modal import ModalBeam


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes.

    energy: of the beam there, above the start, pJ
    midpoint: w(L/2) - rise there, um
    """

    energy: float
    midpoint: float


def find_barrier(modal: ModalBeam) -> Barrier:
    """Find the lowest equilibrium that is no minimum: every way out of a well passes as high.

    Below its energy each well is closed, and w(L/2) on either side of its midpoint tells which
    well the beam is in: among all shapes with that midpoint none has less energy than the saddle.
    A model too coarse to have a second shape, close to Q = 4/sqrt(3), has a barrier of energy 0.
    """
    equilibria = [_polish(modal, guess) for guess in _equilibria(modal)]
    passes = [p for p in equilibria if _is_unstable(modal, p)]
    if not passes:
        return Barrier(0.0, 0.0)
    lowest = min(passes, key=lambda p: _energy(modal, p))
    return Barrier(_energy(modal, lowest), float(modal.midpoint @ lowest))


def _equilibria(modal):
    """Guesses at all equilibria but the start, from the buckling modes kappa v = N_j S v.

    In these, p = sum c_j v_j, equilibrium reads c_j = N s_j / (N_j - N), s_j = v_j.S q0: either
    N is a buckling load N_k and c_k is free, or N is a root of the stretch equation alone. The
    start is a multiple of the first mode, but for a small remainder that `_polish` adds.
    """
    loads, shapes = buckling(modal)
    starts = shapes.T @ modal.slope_start
    first, start = loads[0], starts[0]
    for load, shape in zip(loads[1:], shapes.T[1:], strict=True):
        along = first * start / (first - load)
        free = start**2 - along**2 - load / modal.axial
        if free > 0:
            yield (along - start) * shapes[:, 0] + np.sqrt(free) * shape
    # N = axial (s^2 - q^2), q = first s / (first - N): a cubic in q, of which q = s is the start.
    for along in np.roots([1.0, start, first / modal.axial]):
        if abs(along.imag) < 1e-9 * abs(start):
            yield (along.real - start) * shapes[:, 0]


def buckling(modal: ModalBeam) -> tuple[np.ndarray, np.ndarray]:
    """Buckling loads N_j, ascending, uN, and modes v_j, the columns, with v.S v = 1."""
    lower = np.linalg.cholesky(modal.geometric)
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, np.diag(modal.stiffness)).T)
    loads, vectors = np.linalg.eigh((scaled + scaled.T) / 2)
    return loads, np.linalg.solve(lower.T, vectors)


def _stretch(modal, p):
    slope = modal.geometric @ p + modal.slope_start
    return slope, -modal.axial * p @ (slope + modal.slope_start)


def _energy(modal, p):
    _, axial_force = _stretch(modal, p)
    return float(p @ (modal.stiffness * p) / 2 + axial_force**2 / (4 * modal.axial))


def _hessian(modal, p):
    slope, axial_force = _stretch(modal, p)
    tangent = np.diag(modal.stiffness) - axial_force * modal.geometric
    return tangent + 2 * modal.axial * np.outer(slope, slope)


def _polish(modal, p):
    for _ in range(30):
        slope, axial_force = _stretch(modal, p)
        force = modal.stiffness * p - axial_force * slope
        p = p - np.linalg.solve(_hessian(modal, p), force)
    return p


def _is_unstable(modal, p):
    return np.linalg.eigvalsh(_hessian(modal, p))[0] < 0

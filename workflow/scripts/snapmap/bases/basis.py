"""The common form of every discretisation: eq. (4) as matrices over symmetric deflections."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Basis(NamedTuple):
    """Matrices of the whole beam (twice the half beam's) over n symmetric, clamped shapes.

    mass: (n, n), rho A w w~, ng
    bending: (n, n), EI w'' w~'', uN/um
    geometric: (n, n), w' w~', 1/um
    load: (n,), rho A w~, ng
    midpoint: (n,), w~(L/2)
    start: (n,), the stress-free shape w0, um
    flexibility: axial force N (uN) -> static deflection of the midpoint per force there, um/uN
    complete: whether that flexibility is the n shapes' own; else it is the exact beam's
    """

    mass: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    start: np.ndarray
    flexibility: Callable[[float], float]
    complete: bool

"""The shape of a beam as measured along it, and the few cosines that fit it."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..device.shape import TILT
from ..files.named import naming, read_named
from ..files.tables import read_table
from ..numerics.linalg import apply, dot, multiply, solve
from ..numerics.portable import sine

COSINES = 5
MOST = 20_000
LEAST = 20
PROFILE = 2_000_000, f"write at most {MOST} points"
"""Most bytes of a file with a shape, and the remedy for more, as `read_named` takes both."""
LENGTHS = {"um": 1.0, "µm": 1.0, "μm": 1.0, "nm": 1e-3, "mm": 1e3, "m": 1e6}
FARTHEST = 0.1
"""Largest distance of the fit from the points, rms over the rise, that a clamped beam may have."""


class Measured(NamedTuple):
    """Cosines that fit a measured shape, beside a straight line for its inclination; all in um.

    cosines: amplitudes of (1 - cos(2 n pi x/L))/2
    tilt: largest displacement in the first antisymmetric shape
    rms, most: distance of the points from the fit
    points: number of points; length: distance of the last from the first
    """

    cosines: list[float]
    tilt: float
    rms: float
    most: float
    points: int
    length: float

    @property
    def rise(self) -> float:
        """Height of the midpoint over the clamps."""
        return sum(self.cosines[::2])

    @property
    def words(self) -> str:
        """A line on how well the cosines fit what was read."""
        return (
            f"{COSINES} cosines fit {self.points} points to {self.rms:.2g} um (rms), "
            f"{self.most:.2g} um at most; rise {self.rise:.4g} um, tilt {self.tilt:.2g} um"
        )


def read_shape(path: str | Path) -> Measured:
    """Read a measured shape; raises ValueError, one line, with file and fault.

    path: CSV with two columns, whose header has their units, as `x (um),w (um)`; rows are points
        from clamp to clamp, in any order
    """
    with naming(path):
        content = read_named(path, *PROFILE)
        x, w = read_table(content, {"x": LENGTHS, "w": LENGTHS}, most=MOST).values()
        if x.size < LEAST:
            raise ValueError(f"has {x.size} points; write {LEAST} or more")
        if not np.ptp(x) > 0:
            raise ValueError("has all points at one x; write points from clamp to clamp")
        length = float(np.ptp(x))
        measured = _fit((x - x.min()) / length, w, length)
        if not measured.rms <= FARTHEST * measured.rise:
            raise ValueError(
                f"differs by {measured.rms:.3g} um (rms) from {COSINES} cosines of a rise of "
                f"{measured.rise:.3g} um; write w along one beam, from clamp to clamp"
            )
        return measured


def _fit(x, w, length):
    """Fit by least squares a line, the cosines and the first antisymmetric shape, `psi_1`."""
    mu = 2 * math.pi * math.sqrt(TILT)
    half = sine(mu / (4 * math.pi))
    tilted = [sine(mu * s / (2 * math.pi)) / half - 2 * s for s in (x - 0.5).tolist()]
    columns = np.column_stack(
        [
            *(np.ones(x.size), x - 0.5),
            [[(1 - sine(n * s + 0.25)) / 2 for n in range(1, COSINES + 1)] for s in x.tolist()],
            mu / (4 * math.pi) * np.array(tilted),
        ]
    )
    fit = solve(multiply(columns.T, columns), apply(columns.T, w))
    residual = w - apply(columns, fit)
    rms, most = math.sqrt(dot(residual, residual) / x.size), float(np.abs(residual).max())
    cosines = (fit[2:-1] * math.copysign(1.0, fit[2])).tolist()  # also if drawn upside down
    tilt = abs(float(fit[-1]))
    return Measured(cosines, tilt=tilt, rms=rms, most=most, points=x.size, length=length)

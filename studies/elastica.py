"""The exact plane beam without shear, pushed at its midpoint, by SciPy for comparison."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_bvp
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq

from snapmap.device.device import Beam

MESH, TOLERANCE, POINTS = 101, 1e-6, 41
"""Number of points at first and relative tolerance of a boundary value; displacements of a path."""


class Pushed(NamedTuple):
    """A state of the half beam: x/half, place, angle and moment over it, and two loads."""

    x: np.ndarray
    z: np.ndarray
    loads: np.ndarray


class ExactBeam:
    """A symmetric clamped beam whose centre line turns by any angle, bends and stretches.

    Lengths are over half the span, forces over EI/half^2. At rest it is the cosine of its rise.
    """

    def __init__(self, beam: Beam) -> None:
        half = beam.span / 2
        self.rise = beam.rise / half
        self.stretch = beam.bending_stiffness / (beam.youngs_modulus * beam.area * half**2)
        self.unit = 2 * beam.bending_stiffness / half**2
        self.half = half

    def shape(self, height: float, second: float = 0.0) -> Callable:
        """Return slope and its derivative over x of a first and a second cosine."""

        def of(x):
            waves = [(height, np.pi), (second, 2 * np.pi)]
            slope = sum(a / 2 * k * np.sin(k * x) for a, k in waves)
            return slope, sum(a / 2 * k * k * np.cos(k * x) for a, k in waves)

        return of

    def rate(self, x, z, loads):
        """Give the derivatives of place, angle and moment over x at rest."""
        slope, turn = self.shape(self.rise)(x)
        ds = np.sqrt(1 + slope * slope)
        cos, sin = np.cos(z[2]), np.sin(z[2])
        now = ds * (1 + self.stretch * (loads[0] * cos + loads[1] * sin))
        across = loads[1] * cos - loads[0] * sin
        return np.array([now * cos, now * sin, turn / ds**2 + ds * z[3], -now * across])

    def hold(self, guess: Pushed, down: float) -> Pushed:
        """Hold the midpoint at a displacement, over half the span."""

        def ends(start, end, loads):
            return np.array([*start[:3], end[0] - 1, end[1] - self.rise + down, end[2]])

        run = solve_bvp(self.rate, ends, guess.x, guess.z, guess.loads, tol=TOLERANCE)
        if not run.success:
            raise RuntimeError(f"the exact beam at {down:g} of its half span: {run.message}")
        return Pushed(run.x, run.y, run.p)

    def guess(self, height: float, second: float, axial: float) -> Pushed:
        """Guess a state by the height of a first and a second cosine, and the axial load."""
        x = np.linspace(0, 1, MESH)
        place = height / 2 * (1 - np.cos(np.pi * x)) + second / 2 * (1 - np.cos(2 * np.pi * x))
        slope, turn = self.shape(height, second)(x)
        moment = turn - self.shape(self.rise)(x)[1]
        return Pushed(x, np.array([x, place, slope, moment]), np.array([axial, 0.0]))

    def path(self, first: Pushed, ends: tuple[float, float]) -> Callable:
        """Follow a path between displacements over the rise; returns the force over them, uN."""
        places, forces, state = np.linspace(*ends, POINTS), [], first
        for place in places:
            state = self.hold(state, place * self.rise)
            forces.append(-state.loads[1] * self.unit)
        order = np.argsort(places)
        return make_interp_spline(places[order], np.array(forces)[order], k=3)


def corners(beam: Beam) -> list[tuple[float, float]]:
    """Find the displacements, over the rise, and the forces, uN, at both ends of the second mode.

    Between them the beam moves in its second cosine, with nearly constant axial load; there its
    path leaves that of the other shapes at the largest force, and returns at the least.
    """
    exact = ExactBeam(beam)
    bent = exact.hold(exact.guess(0.0, exact.rise / 2, -4 * np.pi**2), exact.rise)
    found = []
    for rest, height, nearest in ((0.0, exact.rise, 0.3), (2.0, -exact.rise, 1.75)):
        # The branch is so straight that it is drawn out to the corner, where it ends.
        alone = exact.path(exact.guess(height, 0.0, 0.0), (rest, nearest))
        branch = exact.path(bent, (1.0, nearest))
        place = brentq(lambda place, a=alone, b=branch: a(place) - b(place), rest, nearest)
        found.append((place, float(alone(place))))
    return found

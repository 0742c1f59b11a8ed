"""Equilibria of the beam under slow loads: the branches of a path, and where it ends.

In buckling modes v_j (kappa v_j = N_j S v_j, v_j.S v_j = 1) equilibrium under a force P on the
midpoint and an acceleration a of the frame reads, with s_j = v_j.S q0,

    (N_j - N) c_j = N s_j - f_j a - e_j P,    N = -EA/2L sum (c_j^2 + 2 c_j s_j).

For a given N the load is a root of a quadratic: one belongs to the path from the first shape to the
largest N, the other, farther along, to the path on from there.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..device import Beam, Device, Value
from ..numerics.linalg import apply, eigh
from .barrier import find_barrier, unit_buckling
from .basis import Basis
from .cosines import buckling_shapes, symmetric_cosines
from .modal import ModalBeam, contact_stiffness, pulse_load, unit_form, unit_modes
from .prestress import first_midpoint, kinds_of

COSINES = 40
GRID, ZOOMS = 100, 5
"""Points between which something is looked for, and how often closer."""


class BucklingModes(NamedTuple):
    """A beam in its buckling modes: N_j, s_j, f_j and e_j, (modes, 1); EA/2L; flexibility."""

    buckling: np.ndarray
    start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Value
    residual: Value


def static_threshold(device: Device) -> float | np.ndarray:
    """Lowest N, in multiples of g, whose lasting acceleration leaves no equilibrium to rest in.

    That is the first maximum on the path, or where the beam leaves the mass to snap by itself. A
    mass on its stop holds the midpoint no farther than there, until the beam leaves it by its own
    inertia. A beam that leaves the mass where it could still rest alone, or that the mass does not
    reach across its gap, goes on to its own first maximum; so does one alone, of whose force on the
    midpoint N then counts the units.
    """
    if np.ndim(device.mass):
        return np.array([static_threshold(device.pick(i)) for i in range(len(device))])
    modes = buckling_modes(device.beam)
    modes = modes._replace(load=pulse_load(device, modes.load, modes.midpoint))
    first = first_midpoint(shapes_of(device.beam), device.beam).item()
    whole = first - device.beam.second_equilibrium

    stiffness, room = contact_stiffness(device, modes.residual), device.stop_toward - device.gap

    def pressed(modes, N):
        return _shock(modes, N, device.mass, device.spring, stiffness, device.gap)

    def held(modes, N):
        return _shock(modes, N, 0.0, np.inf, stiffness, -room)

    def is_left(a, reached):
        """Whether the midpoint is ahead of the mass by itself, once that has touched it."""
        behind = device.mass * a < device.spring * (reached + device.gap)
        return behind & np.logical_or.accumulate(~behind)

    if device.is_alone:
        alone, *_ = _end_of(modes, _shock_alone, lambda a, reached: a < 0, whole)
        return float(alone / device.gravity)
    ends = [_end_of(modes, pressed, is_left, whole)]
    if room < np.inf:
        ends.append(_end_of(modes, held, lambda a, reached: reached > room, whole))
    alone, edge, apart = np.inf, 0.0, False
    if device.gap > 0 or any(leaves for *_, leaves in ends):
        alone, edge, _ = _end_of(modes, _shock_alone, lambda a, reached: a < 0, whole)
        apart = device.gap > 0 and device.mass * alone < device.spring * (edge + device.gap)
    # What the mass on its spring no longer holds runs on to the stop, which may hold it.
    a = max(alone if (reached < edge if leaves else apart) else a for a, reached, leaves in ends)
    return float(a / device.gravity)


def least_way(device: Device) -> float:
    """How far the mass must travel from rest to push the midpoint slowly to the saddle, um."""
    return float(device.gap - find_barrier(device.beam, shapes_of(device.beam)).midpoint)


def _end_of(modes, loaded, is_left, whole):
    """The first maximum of a on a path, its end, or where the midpoint goes ahead of the mass.

    is_left: tells which points of a path are such, from a and the midpoint's displacement there
    whole: that of the second shape, um
    Returns a, the midpoint's displacement, and whether the mass is left there.
    """
    largest = largest_force(modes, loaded, modes.buckling[1, 0])
    low, high = 0.0, 2.0
    for _ in range(ZOOMS):
        places = np.linspace(low, high, GRID)
        a, reached = _along(modes, loaded, largest, places)
        leaves = is_left(a, reached)[1:]
        first = np.argmax((np.diff(a) < 0) | leaves | (reached[1:] >= whole))
        low, high = places[[max(first - 1, 0), min(first + 1, GRID - 1)]]
    return a[first], reached[first], leaves[first]


def _along(modes, loaded, largest, places):
    """Load and displacement along a path: N grows to the largest up to 1, and falls to 2."""
    N = largest * (1 - (1 - places) ** 2)
    constant, slope = loaded(modes, N)
    lower, upper = roots(modes, N, constant, slope)
    # Which root belongs to the path there changes where the loads' direction does.
    there_first = displacement(modes, slope) > 0
    x = np.where(there_first == (places <= 1), lower, upper)
    return x, displacement(modes, constant + slope * x)


def shapes_of(beam: Beam) -> Basis:
    """The basis in which a beam's equilibria are found: COSINES shapes of each kind it takes."""
    return buckling_shapes(COSINES) if beam.free else symmetric_cosines(COSINES)


def buckling_modes(beam: Beam) -> BucklingModes:
    """Expand a beam in COSINES buckling modes, twice as many if it is free to tilt."""
    kinds, _ = kinds_of(beam)
    loads, start, load, midpoint, residual = _unit_modes(shapes_of(beam), kinds)
    root = np.sqrt(beam.span)
    return BucklingModes(
        buckling=loads * (beam.stiffness_unit * beam.span),
        start=start * (beam.made_rise / root),
        load=load * (beam.weight * root),
        midpoint=midpoint * root,
        axial=beam.axial_stiffness,
        residual=residual / beam.stiffness_unit,
    )


def _unit_modes(basis, kinds):
    """Loads, s_j, f_j and e_j, (modes, 1), and the residual flexibility, of one kind at rest."""
    if kinds.as_made:
        modal, (loads, shapes) = unit_modes(basis), unit_buckling(basis)
    else:
        modal = ModalBeam(*(column[0] for column in unit_form(basis, None, kinds)))
        loads, shapes = eigh(np.diag(modal.stiffness), modal.geometric)
    vectors = (modal.slope_start, modal.load, modal.midpoint)
    columns = loads, *(apply(shapes.T, vector) for vector in vectors)
    return *(column[:, np.newaxis] for column in columns), modal.residual


def push(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c = constant + slope P under a force P (uN) on the midpoint, each (modes, n); N: (n,), uN."""
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.midpoint


def _shock(modes, N, mass, spring, stiffness, gap):
    """c = constant + slope a where the mass on its spring presses: e.c - (P - M a)/K - h = P/k."""
    constant, slope = push(modes, N)
    sag = -modes.load / (modes.buckling - N)
    give = 1 / spring + 1 / stiffness - np.sum(modes.midpoint * slope, axis=0)
    at_rest = (np.sum(modes.midpoint * constant, axis=0) - gap) / give
    grows = (mass / spring + np.sum(modes.midpoint * sag, axis=0)) / give
    return constant + slope * at_rest, sag + slope * grows


def _shock_alone(modes, N):
    """c = constant + slope a of the beam by itself."""
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.load


def roots(
    modes: BucklingModes, N: np.ndarray, constant: np.ndarray, slope: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Both loads x at which c = constant + slope x stretches the beam to N; NaN if none does."""
    square = modes.axial * np.sum(slope**2, axis=0)
    half = modes.axial * np.sum(slope * (constant + modes.start), axis=0)
    rest = N + modes.axial * np.sum(constant * (constant + 2 * modes.start), axis=0)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(half**2 - square * rest)
    return (-half - root) / square, (-half + root) / square


def displacement(modes: BucklingModes, c: np.ndarray) -> np.ndarray:
    """How far the midpoint of the kept modes has moved from the first shape, um; c: (modes, n)."""
    return -np.sum(modes.midpoint * c, axis=0)


def largest_force(modes: BucklingModes, loaded: Callable, limit: float) -> float:
    """Largest N below the limit up to which the two roots exist, uN.

    loaded: gives constant and slope of c for modes and N, as `push` does
    """
    low, high = 0.0, limit
    for _ in range(ZOOMS):
        N = low + (high - low) * (np.arange(GRID) + 0.5) / GRID
        exists = np.isfinite(roots(modes, N, *loaded(modes, N))[0])
        count = int(np.count_nonzero(np.logical_and.accumulate(exists)))
        low, high = N[max(count - 1, 0)], N[count] if count < GRID else high
    return float(low)

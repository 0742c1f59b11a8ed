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

from ..arch import equilibria
from ..device import Beam, Device, Value, batch
from ..numerics.linalg import apply, dot, eigh
from .basis import Basis
from .cosines import buckling_shapes, symmetric_cosines
from .modal import (
    at_rest,
    buckling,
    contact_stiffness,
    first_midpoint,
    halfway,
    pulse_load,
    unit_beams,
    unit_form,
)

COSINES = 40
GRID, ZOOMS = 100, 5
"""Points of a search, and how often it is repeated between two of them."""


class BucklingModes(NamedTuple):
    """A beam in its buckling modes: N_j, s_j, f_j and e_j, (modes, 1); EA/2L; flexibility."""

    buckling: np.ndarray
    start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Value
    residual: Value


def static_threshold(device: Device, back: bool = False) -> float | np.ndarray:
    """Lowest N, in multiples of g, whose lasting acceleration leaves no equilibrium to rest in.

    That is the first maximum on the path, or where the beam leaves the mass to snap by itself. A
    mass on its stop holds the midpoint no farther than there, until the beam leaves it by its own
    inertia. A beam that leaves the mass where it could still rest alone, or that the mass does not
    reach across its gap, goes on to its own first maximum; so does one alone, of whose force on the
    midpoint N then counts the units.

    back: from the second shape, by a pull along -z, where the mass goes its own way
    """
    if not np.ndim(device.mass):
        return float(np.asarray(static_threshold(batch([device]), back))[0])
    N = np.empty(len(device))
    for free in np.unique(device.beam.free):
        mine = np.flatnonzero(device.beam.free == free)
        alike = device.pick(mine) if mine.size < N.size else device
        modes, first = buckling_modes(alike.beam), first_midpoint(shapes_of(alike.beam), alike.beam)
        modes = modes._replace(load=pulse_load(alike, modes.load, modes.midpoint))
        each = [BucklingModes(*(np.asarray(c)[i] for c in modes)) for i in range(mine.size)]
        if back:
            N[mine] = [_least_back(one) for one in each]
            continue
        facts = {
            "mass": alike.mass,
            "spring": alike.spring,
            "stiffness": contact_stiffness(alike, modes.residual),
            "gap": alike.gap,
            "stop": alike.stop_toward,
            "travel": first - alike.beam.second_equilibrium,
        }
        N[mine] = [
            _least_without_rest(
                one, **{key: float(np.asarray(column)[i]) for key, column in facts.items()}
            )
            for i, one in enumerate(each)
        ]
    return N / device.gravity


def _least_without_rest(modes, mass, spring, stiffness, gap, stop, travel):
    """That acceleration of one device; stop: how far its mass may travel towards the beam."""

    def pressed(modes, N):
        return _shock(modes, N, mass, spring, stiffness, gap)

    def held(modes, N):
        return _shock(modes, N, 0.0, np.inf, stiffness, gap - stop)

    def is_left(a, reached):
        """Whether the midpoint is ahead of the mass by itself, once that has touched it."""
        behind = mass * a < spring * (reached + gap)
        return behind & np.logical_or.accumulate(~behind)

    def is_pulled(a, reached):
        return a < 0

    if gap == np.inf:
        return _end_of(modes, alone, is_pulled, travel)[0]
    ends = [_end_of(modes, pressed, is_left, travel)]
    if stop < np.inf:
        ends.append(_end_of(modes, held, lambda a, reached: reached > stop - gap, travel))
    own, edge, apart = np.inf, 0.0, False
    if gap > 0 or any(leaves for *_, leaves in ends):
        own, edge, _ = _end_of(modes, alone, is_pulled, travel)
        apart = bool(gap > 0 and mass * own < spring * (edge + gap))
    # What the mass on its spring no longer holds runs on to the stop, which may hold it.
    return max(own if (reached < edge if leaves else apart) else a for a, reached, leaves in ends)


def reset_force(beam: Beam) -> tuple[float, float]:
    """Force on the midpoint of one beam that leaves no rest in its second shape, and its error, uN.

    Below 0 where the beam returns by itself. The error is what half of the modes leave out.
    """
    modes = buckling_modes(beam)
    modes = modes._replace(load=modes.midpoint)
    kept = slice(len(modes.buckling) // 2)
    half = modes._replace(**{key: getattr(modes, key)[kept] for key in modes._fields[:4]})
    force = _least_back(modes)
    return float(force), float(abs(force - _least_back(half)))


def least_travel(device: Device) -> float:
    """How far the mass must travel from rest to push the midpoint slowly to the saddle, um."""
    return float(device.gap - find_barrier(device.beam, shapes_of(device.beam)).midpoint)


def _end_of(modes, loaded, is_left, travel):
    """The first maximum of a on a path, its end, or where the midpoint goes ahead of the mass.

    is_left: of which points of a path this holds, from a and the midpoint's displacement there
    travel: the displacement of the second shape, um
    Returns a, the midpoint's displacement, and whether the mass is left there.
    """
    largest = largest_force(modes, loaded, modes.buckling[1, 0])
    low, high = 0.0, 2.0
    for _ in range(ZOOMS):
        places = np.linspace(low, high, GRID)
        a, reached = _on_path(modes, loaded, largest, places)
        leaves = is_left(a, reached)[1:]
        first = np.argmax((np.diff(a) < 0) | leaves | (reached[1:] >= travel))
        low, high = places[[max(first - 1, 0), min(first + 1, GRID - 1)]]
    return a[first], reached[first], leaves[first]


def _least_back(modes):
    """The pull at the first minimum of a that is met from beyond the second shape."""
    largest, low, high = largest_force(modes, alone, modes.buckling[1, 0]), 1.0, 2.0
    for _ in range(ZOOMS):
        places = np.linspace(high, low, GRID)
        a, _ = _on_path(modes, alone, largest, places)
        first = np.argmax(np.append(np.diff(a) > 0, True))
        low, high = places[[min(first + 1, GRID - 1), max(first - 1, 0)]]
    return -a[first]


def _on_path(modes, loaded, largest, places):
    """a and the midpoint's displacement where N grows to the largest up to place 1 and falls to 2.

    At 1 itself those of the path from the first shape.
    """
    N = largest * (1 - (1 - places) ** 2)
    constant, slope = loaded(modes, N)
    lower, upper = roots(modes, N, constant, slope)
    # Which root belongs to the path there changes where the loads' direction does.
    a = np.where((displacement(modes, slope) > 0) == (places <= 1), lower, upper)
    return a, displacement(modes, constant + slope * a)


def shapes_of(beam: Beam) -> Basis:
    """The basis in which a beam's equilibria are found: COSINES shapes of each kind it takes."""
    return buckling_shapes(COSINES) if np.any(beam.free) else symmetric_cosines(COSINES)


def buckling_modes(beam: Beam) -> BucklingModes:
    """Expand a beam in COSINES buckling modes, twice as many if it is free to tilt.

    Of a batch, of guided beams or of free ones, each has one more axis, in front.
    """
    basis, (beams, which) = shapes_of(beam), unit_beams(beam)
    which = which if np.ndim(beam.rise) else which[0]
    T, q = at_rest(basis, beams)
    loads, shapes = buckling(basis)
    start = apply(shapes.T, apply(basis.geometric, q))[which]
    load, midpoint = (apply(shapes.T, vector) for vector in (basis.load, basis.midpoint))
    middle = halfway(T)
    kept = np.sum(midpoint * midpoint / (loads - middle[:, np.newaxis]), axis=-1)
    residual = np.maximum(0.0, basis.flexibility(middle) - kept)[which]

    def column(values, factor):
        return (values * np.asarray(factor)[..., np.newaxis])[..., np.newaxis]

    root = np.sqrt(beam.span)
    return BucklingModes(
        buckling=column(loads + T[which][..., np.newaxis], beam.stiffness_unit * beam.span),
        start=column(start, beam.made_rise / root),
        load=column(load, beam.weight * root),
        midpoint=column(midpoint, root),
        axial=beam.axial_stiffness,
        residual=residual / beam.stiffness_unit,
    )


def push(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c = constant + slope P under a force P (uN) on the midpoint, each (modes, n); N: (n,), uN."""
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.midpoint


def alone(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c = constant + slope a under the load of the pulse alone, as `push`."""
    return push(modes._replace(midpoint=modes.load), N)


def _shock(modes, N, mass, spring, stiffness, gap):
    """c = constant + slope a where the mass on its spring presses: e.c - (P - M a)/K - h = P/k."""
    constant, slope = push(modes, N)
    sag = -modes.load / (modes.buckling - N)
    give = 1 / spring + 1 / stiffness - np.sum(modes.midpoint * slope, axis=0)
    at_rest = (np.sum(modes.midpoint * constant, axis=0) - gap) / give
    grows = (mass / spring + np.sum(modes.midpoint * sag, axis=0)) / give
    return constant + slope * at_rest, sag + slope * grows


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


class Barrier(NamedTuple):
    """The lowest pass between the two stable shapes; numbers, or arrays (devices,).

    energy: of the beam there, above its shape at rest, pJ
    midpoint: w(L/2) there, from that at rest, um
    second: w(L/2) in the second shape, um; of a beam that has none because it is free to tilt, that
        of a guided one
    first: w(L/2) in the shape at rest, um
    """

    energy: Value
    midpoint: Value
    second: Value
    first: Value


def find_barrier(beam: Beam, basis: Basis, modes: int | None = None) -> Barrier:
    """Find the lowest equilibrium that is no minimum: every way out of a well passes as high.

    Below its energy each well is closed, and w(L/2) on either side of its midpoint tells which
    well the beam is in: among all shapes with that midpoint none has less energy than the saddle.
    A model that has no stable second shape has a barrier of energy 0: one too coarse, close to
    Q = 4/sqrt(3), or a beam that is free to tilt out of it.
    """
    modal, axial, which, p, own = _saddle_and_second(beam, basis, modes)
    exists = np.isfinite(p).all(axis=-1)
    energy, along = (
        np.where(exists, part, 0.0)[which]
        for part in (_unit_energy(modal, axial, p), dot(modal.midpoint, p))
    )
    first, second = first_midpoint(basis, beam), np.atleast_1d(beam.second_equilibrium)
    if basis.tilt.any():
        stays = first + dot(modal.midpoint, own)[which] * beam.made_rise
        second = np.where(exists[which], stays, second)
    unit = beam.stiffness_unit * beam.made_rise * beam.made_rise
    columns = energy * unit, along * beam.made_rise, second, first
    return Barrier(*(value if np.ndim(beam.rise) else value.item() for value in columns))


class Rest(NamedTuple):
    """The second shape of a form at rest: its modes, (..., k), um ng^0.5; its energy, pJ."""

    modes: np.ndarray
    energy: Value


def second_shape(beam: Beam, basis: Basis, modes: int | None = None) -> Rest:
    """Find where a beam rests in its second shape, measured from the first; NaN if it has none."""
    modal, axial, which, _, own = _saddle_and_second(beam, basis, modes)
    energy, scale = _unit_energy(modal, axial, own)[which], beam.made_rise * np.sqrt(beam.weight)
    p = own[which] * np.reshape(scale, (-1, 1))
    energy = energy * (beam.stiffness_unit * beam.made_rise * beam.made_rise)
    return Rest(p, energy) if np.ndim(beam.rise) else Rest(p[0], energy.item())


def _saddle_and_second(beam, basis, modes):
    """The form of unit beams, their axial stiffness, which is which, and coordinates there."""
    beams, which = unit_beams(beam)
    axial = 6 * beams.Q * beams.Q
    modal = unit_form(basis, modes, beams)
    stiffness = modal.stiffness[..., np.newaxis] * np.eye(modal.stiffness.shape[-1])
    loads, shapes = eigh(stiffness, modal.geometric)
    s = apply(shapes.swapaxes(-1, -2), modal.slope_start)
    loads, s = (np.broadcast_to(part, (axial.size, part.shape[-1])) for part in (loads, s))
    rest = equilibria(loads, s, axial, np.zeros(axial.size))
    return modal, axial, which, *(apply(shapes, q - s) for q in (rest.saddle, s * rest.second))


def _unit_energy(modal, axial, p):
    slope = apply(modal.geometric, p) + modal.slope_start
    N = -axial * dot(p, slope + modal.slope_start)
    return dot(p, modal.stiffness * p) / 2 + N * N / (4 * axial)

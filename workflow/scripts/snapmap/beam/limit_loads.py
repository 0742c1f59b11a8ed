"""The largest slow loads: beyond them a path of equilibria ends, and the beam snaps."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ..device.device import Device, batch
from ..values.kinds import Number
from .equilibria import BucklingModes, alone, buckling_modes, displacement, push, roots, shapes_of
from .modal import column, contact_stiffness, first_midpoint, pulse_load

POINTS = (100, *[12] * 9)
"""Number of points of a first search, and of each finer one between neighbours of the last hit."""
PATH_END = 2.0
"""Place at which a path ends: N grows from 0 at place 0 to its largest at 1, and is 0 at 2."""
BLOCK = 16
"""Number of devices searched together, as their data fit into a processor's cache."""


class _Pushed(NamedTuple):
    """Devices under a slow pulse; all but modes are (devices, 1), in the units of `Device`.

    stiffness: of the contact, with the residual flexibility of the modes
    stop: travel of the mass towards the beam, um; travel: of the midpoint to the second shape, um
    """

    modes: BucklingModes
    mass: np.ndarray
    spring: np.ndarray
    stiffness: np.ndarray
    gap: np.ndarray
    stop: np.ndarray
    travel: np.ndarray

    def take(self, which):
        modes = BucklingModes(*(column[which] for column in self.modes))
        return _Pushed(modes, *(column[which] for column in self[1:]))


def static_threshold(device: Device, back: bool = False) -> float | np.ndarray:
    """Find the lowest N whose lasting acceleration leaves no equilibrium; a number, or (devices,).

    N, in multiples of g, grows slowly along a path of equilibria, which ends at the first maximum
    of N, or where the beam leaves the mass and snaps by its own inertia. A mass on its stop holds
    the midpoint at the stop until the beam leaves it. The beam goes on to the first maximum of its
    own path if it leaves the mass where it can rest without it, if the mass does not reach it
    across the gap, or if it is alone. With a `force`, N counts units of that force.

    back: whether the path begins at the second shape, under a pull along -z and without the mass
    """
    if not np.ndim(device.mass):
        return float(np.asarray(static_threshold(batch([device]), back))[0])
    N = np.empty(len(device))
    for free in np.unique(device.beam.free):
        which = np.flatnonzero(device.beam.free == free)
        pushed = _collect(device.pick(which) if which.size < N.size else device)
        for block in np.split(np.arange(which.size), range(BLOCK, which.size, BLOCK)):
            part = pushed.take(block)
            N[which[block]] = least_back(part.modes) if back else _least_without_rest(part)
    return N / device.gravity


def _collect(device):
    """Collect the columns of a batch of guided devices only, or of free ones only."""
    beam, modes = device.beam, buckling_modes(device.beam)
    modes = modes._replace(load=pulse_load(device, modes.load, modes.midpoint))
    travel = first_midpoint(shapes_of(beam), beam) - beam.second_equilibrium
    return _Pushed(
        modes=modes,
        mass=column(device.mass, 1),
        spring=column(device.spring, 1),
        stiffness=column(contact_stiffness(device, modes.residual), 1),
        gap=column(device.gap, 1),
        stop=column(device.stop_toward, 1),
        travel=column(travel, 1),
    )


def _least_without_rest(devices):
    """Find the least acceleration that leaves no equilibrium, from the first shape, um/us^2."""
    gap = devices.gap[:, 0]
    reaches, has_stop = gap < np.inf, devices.stop[:, 0] < np.inf
    ends = [
        _ends(devices, reaches, _pressed, _is_left),
        _ends(devices, reaches & has_stop, _held, lambda part, a, w: w > part.stop - part.gap),
    ]
    released = (gap > 0) | np.any([leaves for *_, leaves in ends], axis=0)
    a_alone, edge, _ = _ends(
        devices, released, lambda part, N: alone(part.modes, N), lambda part, a, w: a < 0
    )
    apart = (gap > 0) & (devices.mass[:, 0] * a_alone < devices.spring[:, 0] * (edge + gap))
    # A beam that the mass on its spring no longer holds moves on to the stop, which may hold it.
    least = [
        np.where(np.where(leaves, reached < edge, apart & (a != -np.inf)), a_alone, a)
        for a, reached, leaves in ends
    ]
    return np.where(reaches, np.fmax(*least), a_alone)


def _pressed(devices, N):
    """Return constant and slope of c, with the mass on the beam: e.c - (P - M a)/K - h = P/k."""
    modes, (constant, slope) = devices.modes, push(devices.modes, N)
    _, sag = alone(modes, N)
    give = 1 / devices.spring + 1 / devices.stiffness + displacement(modes, slope)
    at_rest = -(displacement(modes, constant) + devices.gap) / give
    grows = (devices.mass / devices.spring - displacement(modes, sag)) / give
    constant += slope * at_rest[..., np.newaxis, :]
    return constant, sag + slope * grows[..., np.newaxis, :]


def _held(devices, N):
    """Return constant and slope, as `_pressed` does, with the mass on its stop, a rigid wall."""
    return _pressed(devices._replace(mass=0.0, spring=np.inf, gap=devices.gap - devices.stop), N)


def _is_left(devices, a, reached):
    """Return whether the midpoint has left the mass behind, at a place after they have touched."""
    behind = devices.mass * a < devices.spring * (reached + devices.gap)
    return behind & np.logical_or.accumulate(~behind, axis=-1)


def least_back(modes: BucklingModes) -> np.ndarray:
    """Find the pull, um/us^2, at the first minimum of a on the path from the second shape."""
    loaded = partial(alone, modes)

    def path(largest, places):
        a, _ = _on_path(modes, loaded, largest, places)
        return np.diff(a, append=np.inf) > 0, a

    (a,) = _first_on_path(modes, loaded, PATH_END, 1.0, path)
    return -a


def largest_force(modes: BucklingModes, loaded: Callable, limit: Number) -> np.ndarray:
    """Find the largest N below a limit, uN, (...), up to which both roots exist.

    loaded: maps N to constant and slope of c, as `push` does
    """
    low, high = np.zeros(np.shape(limit)), np.asarray(limit)
    for points in POINTS:
        N = low[..., np.newaxis] + np.multiply.outer((high - low) / points, np.arange(points) + 0.5)
        exists = np.isfinite(roots(modes, N, *loaded(N))[0])
        count = np.count_nonzero(np.logical_and.accumulate(exists, axis=-1), axis=-1)
        low = np.where(count > 0, _at(N, np.maximum(count - 1, 0)), low)
        high = np.where(count < points, _at(N, np.minimum(count, points - 1)), high)
    return low


def _ends(devices, which, loaded, is_left):
    """Find where each path ends: at a maximum of a, the second shape, or where `is_left` holds.

    which: mask of the devices to search, (devices,)
    loaded: maps devices and N to constant and slope of c
    is_left: maps devices, a and the midpoint's displacement to whether the beam leaves the mass
    Returns a, -inf for other devices, the midpoint's displacement, and `is_left` there; (devices,)
    """
    a, reached, leaves = np.full(which.size, -np.inf), np.zeros(which.size), which & False
    if not which.any():
        return a, reached, leaves
    part = devices.take(which)
    modes, loaded = part.modes, partial(loaded, part)

    def path(largest, places):
        a, reached = _on_path(modes, loaded, largest, places)
        leaves = is_left(part, a, reached)[:, 1:]
        return (np.diff(a) < 0) | leaves | (reached[:, 1:] >= part.travel), a, reached, leaves

    values = _first_on_path(modes, loaded, 0.0, PATH_END, path)
    a[which], reached[which], leaves[which] = values
    return a, reached, leaves


def _first_on_path(modes, loaded, begin, end, path):
    """Zoom in on the first place between two at which a condition holds; return the values there.

    path: maps the largest N and places, (..., points), to the condition and values, (..., points)
    """
    largest = largest_force(modes, loaded, modes.buckling[..., 1, 0])
    begin, end = np.full(largest.shape, begin), np.full(largest.shape, end)
    for points in POINTS:
        places = np.linspace(begin, end, points, axis=-1)
        holds, *values = path(largest, places)
        first = np.argmax(holds, axis=-1)
        begin = _at(places, np.maximum(first - 1, 0))
        end = _at(places, np.minimum(first + 1, points - 1))
    return [_at(value, first) for value in values]


def _at(values, index):
    """Pick a value, (...), of (..., n), by an index, (...)."""
    return np.take_along_axis(values, index[..., np.newaxis], -1)[..., 0]


def _on_path(modes, loaded, largest, places):
    """Return a and the midpoint's displacement at places on a path, (..., points); see PATH_END.

    Place 1 belongs to the part on which N grows.
    """
    constant, slope = loaded(N := largest[..., np.newaxis] * (1 - (1 - places) ** 2))
    lower, upper = roots(modes, N, constant, slope)
    # The roots change parts where the load changes the direction in which it moves the midpoint.
    grows = displacement(modes, slope)
    a = np.where((grows > 0) == (places <= 1), lower, upper)
    return a, displacement(modes, constant) + a * grows

"""Slow loads that leave no equilibrium: where the paths of a beam that is pushed end."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ..device.device import Device, Value, batch
from .equilibria import BucklingModes, alone, buckling_modes, displacement, push, roots, shapes_of
from .modal import column, contact_stiffness, first_midpoint, pulse_load

POINTS = (100, *[12] * 9)
"""Points of a search, and of each that follows it between neighbours of the point it found."""
PATH_END = 2.0
"""The place on a path up to which it is followed: N has grown to its largest at 1, and fallen."""
BLOCK = 16
"""Devices searched together: their data fit into a processor's cache."""


class _Pushed(NamedTuple):
    """Devices under a slow pulse, their values as columns, (devices, 1).

    stiffness: of the contact; stop: how far the mass may travel towards the beam; travel: how far
        the midpoint does to the second shape, um
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
        which = np.flatnonzero(device.beam.free == free)
        pushed = _collect(device.pick(which) if which.size < N.size else device)
        for block in np.split(np.arange(which.size), range(BLOCK, which.size, BLOCK)):
            part = pushed.take(block)
            N[which[block]] = least_back(part.modes) if back else _least_without_rest(part)
    return N / device.gravity


def _collect(device):
    """Collect what a batch of guided devices, or of free ones, answers a slow pulse by."""
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
    """Find the least acceleration that leaves no equilibrium, um/us^2, (devices,)."""
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
    # What the mass on its spring no longer holds runs on to the stop, which may hold it.
    least = [
        np.where(np.where(leaves, reached < edge, apart & (a != -np.inf)), a_alone, a)
        for a, reached, leaves in ends
    ]
    return np.where(reaches, np.fmax(*least), a_alone)


def _pressed(devices, N):
    """c = constant + slope a where the mass on its spring presses: e.c - (P - M a)/K - h = P/k."""
    modes, (constant, slope) = devices.modes, push(devices.modes, N)
    _, sag = alone(modes, N)
    give = 1 / devices.spring + 1 / devices.stiffness + displacement(modes, slope)
    at_rest = -(displacement(modes, constant) + devices.gap) / give
    grows = (devices.mass / devices.spring - displacement(modes, sag)) / give
    constant += slope * at_rest[..., np.newaxis, :]
    return constant, sag + slope * grows[..., np.newaxis, :]


def _held(devices, N):
    """c = constant + slope a where the mass is on its stop, as a rigid wall there."""
    return _pressed(devices._replace(mass=0.0, spring=np.inf, gap=devices.gap - devices.stop), N)


def _is_left(devices, a, reached):
    """Whether the midpoint is ahead of the mass by itself, once that has touched it."""
    behind = devices.mass * a < devices.spring * (reached + devices.gap)
    return behind & np.logical_or.accumulate(~behind, axis=-1)


def least_back(modes: BucklingModes) -> np.ndarray:
    """Find the pull at the first minimum of a that is met from beyond the second shape."""
    loaded = partial(alone, modes)

    def path(largest, places):
        a, _ = _on_path(modes, loaded, largest, places)
        return np.diff(a, append=np.inf) > 0, a

    (a,) = _first_on_path(modes, loaded, PATH_END, 1.0, path)
    return -a


def largest_force(modes: BucklingModes, loaded: Callable, limit: Value) -> np.ndarray:
    """Largest N below the limit up to which the two roots exist, uN, (...).

    loaded: gives constant and slope of c for N, as `push` does
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
    """Find the first maximum of a on each path, its end, or where the midpoint leaves the mass.

    which: mask of the devices that are searched, (devices,)
    loaded: gives constant and slope of c for devices and N; is_left: tells for which points of a
        path this holds, from devices, a and the midpoint's displacement there
    Returns a, -inf of others, the midpoint's displacement, and whether the mass is left there.
    """
    a, reached, leaves = np.full(which.size, -np.inf), np.zeros(which.size), which & False
    if which.any():
        part = devices.take(which)
        a[which], reached[which], leaves[which] = _end_of(part, partial(loaded, part), is_left)
    return a, reached, leaves


def _end_of(devices, loaded, is_left):
    def path(largest, places):
        a, reached = _on_path(devices.modes, loaded, largest, places)
        leaves = is_left(devices, a, reached)[:, 1:]
        ends = (np.diff(a) < 0) | leaves | (reached[:, 1:] >= devices.travel)
        return ends, a, reached, leaves

    return _first_on_path(devices.modes, loaded, 0.0, PATH_END, path)


def _first_on_path(modes, loaded, begin, end, path):
    """Zoom in on the first place from `begin` to `end` that is sought, and give what is there.

    path: gives, for the largest N and for places, (..., points), whether each is sought, and values
    """
    largest = largest_force(modes, loaded, modes.buckling[..., 1, 0])
    begin, end = np.full(largest.shape, begin), np.full(largest.shape, end)
    for points in POINTS:
        places = np.linspace(begin, end, points, axis=-1)
        sought, *values = path(largest, places)
        first = np.argmax(sought, axis=-1)
        begin = _at(places, np.maximum(first - 1, 0))
        end = _at(places, np.minimum(first + 1, points - 1))
    return [_at(value, first) for value in values]


def _at(values, index):
    """Pick one of the values, (..., n), by its index, (...)."""
    return np.take_along_axis(values, index[..., np.newaxis], -1)[..., 0]


def _on_path(modes, loaded, largest, places):
    """Give a and the midpoint's displacement where N grows to the largest at place 1, then falls.

    At 1 itself those of the path from the first shape.
    """
    constant, slope = loaded(N := largest[..., np.newaxis] * (1 - (1 - places) ** 2))
    lower, upper = roots(modes, N, constant, slope)
    # Which root belongs to the path there changes where the loads' direction does.
    grows = displacement(modes, slope)
    a = np.where((grows > 0) == (places <= 1), lower, upper)
    return a, displacement(modes, constant) + a * grows

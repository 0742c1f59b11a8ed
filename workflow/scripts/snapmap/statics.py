"""Statics of the beam: the force that pushes it through, and the slowest shock that snaps it.

In buckling modes v_j (kappa v_j = N_j S v_j, v_j.S v_j = 1) equilibrium under a force P on the
midpoint and an acceleration a of the frame reads, with s_j = v_j.S q0,

    (N_j - N) c_j = N s_j - f_j a - e_j P,    N = -EA/2L sum (c_j^2 + 2 c_j s_j).

For a given N the load is a root of a quadratic: one belongs to the way from the first shape to the
largest N, the other, farther along, to the way on from there.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from .bases.cosines import symmetric_cosines
from .config import device_document
from .device import Device
from .linalg import apply
from .modal import contact_stiffness, reduce_to_modes
from .provenance import provenance
from .wells import buckling, find_barrier

COSINES = 40
POINTS = 400
"""On each of the parts of a path."""
VARIABLES = {
    "displacement": {"long_name": "way of the midpoint from the first shape", "units": "um"},
    "force": {"long_name": "static force on the midpoint", "units": "uN"},
    "energy": {"long_name": "energy of the beam above that of the first shape", "units": "pJ"},
}


class _Modes(NamedTuple):
    """The beam in its buckling modes: N_j, s_j, f_j and e_j, (modes, 1); EA/2L; flexibility."""

    buckling: np.ndarray
    start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: float
    residual: float


def force_displacement(device: Device) -> xr.Dataset:
    """Push the beam's midpoint slowly from the first shape to the second and beyond.

    Branch `followed` leaves `unbranched`, that of a beam without the second mode, where N reaches
    the second buckling load, and runs straight from there to where they meet again (Vangbo, 1998).
    """
    modes, barrier = _fine_modes(device)
    second = modes.buckling[1, 0]
    # The second mode neither moves the midpoint nor is in the start: it enters by bifurcation.
    odd = _Modes(*(column[0::2] for column in modes[:4]), *modes[4:])
    largest = _largest_force(odd, _push, odd.buckling[1, 0])
    branches = [_path(odd, second), _path(odd, largest)]
    values = (np.stack(arrays) for arrays in zip(*branches, strict=True))
    data = {
        key: (("branch", "point"), array, VARIABLES[key])
        for key, array in zip(VARIABLES, values, strict=True)
    }
    force = data["force"][1][0]
    return xr.Dataset(data, {"branch": ["followed", "unbranched"]}).assign_attrs(
        Conventions="CF-1.11",
        title="Static force on the midpoint of the beam",
        rise=device.beam.rise,
        second_equilibrium=device.beam.second_equilibrium,
        saddle=device.beam.rise + barrier.midpoint,
        barrier=barrier.energy,
        top_force=float(force[: 2 * POINTS].max()),
        bottom_force=float(force[POINTS:].min()),
        **provenance({"device": device_document(device)}),
    )


def static_threshold(device: Device) -> float:
    """Lowest N, in multiples of g, whose lasting acceleration leaves no equilibrium to rest in.

    That is the first maximum on the way, or where the beam leaves the mass to snap by itself.
    """
    modes, _ = _fine_modes(device)

    def shock(modes, N):
        return _shock(device, modes, N)

    largest = _largest_force(modes, shock, modes.buckling[1, 0])
    N = largest * (1 - np.linspace(1, 0, 10 * POINTS) ** 2)
    constant, slope = shock(modes, N)
    roots = _roots(modes, N, constant, slope)
    ways = (_way(modes, constant + slope * a) for a in roots)
    there_first = np.sign(_way(modes, slope))
    a, way = (_in_order(there_first, *pair) for pair in (roots, ways))
    ends = (np.diff(a) < 0) | (device.mass * a < device.spring * way)[1:]
    return float(a[np.argmax(ends)]) / device.gravity


def _fine_modes(device):
    modal = reduce_to_modes(device, symmetric_cosines(COSINES))
    loads, shapes = buckling(modal)
    vectors = (modal.slope_start, modal.load, modal.midpoint)
    columns = loads, *(apply(shapes.T, vector) for vector in vectors)
    columns = (column[:, np.newaxis] for column in columns)
    return _Modes(*columns, modal.axial, modal.residual), find_barrier(modal)


def _push(modes, N):
    """c = constant + slope P under a force P on the midpoint, each (modes, n)."""
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.midpoint


def _shock(device, modes, N):
    """c = constant + slope a where the mass on its spring presses: e.c - (P - M a)/K = P/k."""
    constant, slope = _push(modes, N)
    sag = -modes.load / (modes.buckling - N)
    stiffness = contact_stiffness(device, modes.residual)
    give = 1 / device.spring + 1 / stiffness - np.sum(modes.midpoint * slope, axis=0)
    at_rest = np.sum(modes.midpoint * constant, axis=0) / give
    grows = (device.mass / device.spring + np.sum(modes.midpoint * sag, axis=0)) / give
    return constant + slope * at_rest, sag + slope * grows


def _roots(modes, N, constant, slope):
    """Both loads x at which c = constant + slope x stretches the beam to N; NaN if none does."""
    square = modes.axial * np.sum(slope**2, axis=0)
    half = modes.axial * np.sum(slope * (constant + modes.start), axis=0)
    rest = N + modes.axial * np.sum(constant * (constant + 2 * modes.start), axis=0)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(half**2 - square * rest)
    return (-half - root) / square, (-half + root) / square


def _in_order(lower_first, lower, upper):
    """There and back again: the lower values there where lower_first is above 0."""
    there, back = np.where(lower_first > 0, [lower, upper], [upper, lower])
    return np.concatenate([there, back[::-1]])


def _way(modes, c):
    """How far the midpoint of the kept modes has moved from the first shape."""
    return -np.sum(modes.midpoint * c, axis=0)


def _largest_force(modes, loaded, limit):
    """Largest N below the limit up to which the two roots exist, by bisection."""
    N = limit * (np.arange(10 * POINTS) + 0.5) / (10 * POINTS)
    exists = np.isfinite(_roots(modes, N, *loaded(modes, N))[0])
    low, high = N[np.count_nonzero(np.logical_and.accumulate(exists)) - 1], limit
    for _ in range(30):
        middle = np.array([(low + high) / 2])
        exists = np.isfinite(_roots(modes, middle, *loaded(modes, middle))[0][0])
        low, high = (middle[0], high) if exists else (low, middle[0])
    return low


def _path(modes, turn):
    """Displacement, force and energy: N from 0 to `turn`, straight there, and back to 0."""
    N = turn * (1 - np.linspace(1, 0, POINTS) ** 2)
    # Crossing the first buckling load, the two roots change places.
    force = _in_order(modes.buckling[0] - N, *_roots(modes, N, *_push(modes, N)))
    straight = np.linspace(*force[POINTS - 1 : POINTS + 1], POINTS)
    force = np.concatenate([force[:POINTS], straight, force[POINTS:]])
    N = np.concatenate([N, np.full(POINTS, turn), N[::-1]])
    constant, slope = _push(modes, N)
    c = constant + slope * force
    # At `turn` the stretch that the odd modes leave open is the second mode's.
    free = np.maximum(0.0, -N / modes.axial - np.sum(c * (c + 2 * modes.start), axis=0))
    energy = np.sum(modes.buckling * c**2, axis=0) / 2 + N * free / 2 + N**2 / (4 * modes.axial)
    return _way(modes, c) + modes.residual * force, force, energy

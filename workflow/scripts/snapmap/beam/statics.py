"""The beam pushed slowly: force and energy over the displacement of its midpoint."""

import numpy as np
import xarray as xr

from ..device import Device
from ..io.provenance import device_sections, provenance
from .barrier import find_barrier
from .cosines import symmetric_cosines
from .equilibria import (
    COSINES,
    BucklingModes,
    buckling_modes,
    displacement,
    largest_force,
    push,
    roots,
    shapes_of,
)
from .prestress import first_midpoint

POINTS = 400
"""On each of the parts of a path."""
VARIABLES = {
    "displacement": {"long_name": "way of the midpoint from the first shape", "units": "um"},
    "force": {"long_name": "static force on the midpoint", "units": "uN"},
    "energy": {"long_name": "energy of the beam above that of the first shape", "units": "pJ"},
}


def force_displacement(device: Device) -> xr.Dataset:
    """Push the beam's midpoint slowly from the first shape to the second and beyond.

    Branch `followed` leaves `unbranched`, that of a beam without the second mode, where N reaches
    the second buckling load, and runs straight from there to where they meet again (Vangbo, 1998).
    """
    modes = buckling_modes(device.beam)
    barrier = find_barrier(device.beam, symmetric_cosines(COSINES))
    first = first_midpoint(shapes_of(device.beam), device.beam).item()
    second = modes.buckling[1, 0]
    # The second mode neither moves the midpoint nor is in the start: it enters by bifurcation.
    odd = BucklingModes(*(column[0::2] for column in modes[:4]), *modes[4:])
    largest = largest_force(odd, push, odd.buckling[1, 0])
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
        rise=first,
        second_equilibrium=device.beam.second_equilibrium,
        saddle=first + barrier.midpoint,
        barrier=barrier.energy,
        top_force=float(force[: 2 * POINTS].max()),
        bottom_force=float(force[POINTS:].min()),
        **provenance(device_sections(device)),
    )


def _in_order(lower_first, lower, upper):
    """There and back again: the lower values there where lower_first is above 0."""
    there, back = np.where(lower_first > 0, [lower, upper], [upper, lower])
    return np.concatenate([there, back[::-1]])


def _path(modes, turn):
    """Displacement, force and energy: N from 0 to `turn`, straight there, and back to 0."""
    N = turn * (1 - np.linspace(1, 0, POINTS) ** 2)
    # Crossing the first buckling load, the two roots change places.
    force = _in_order(modes.buckling[0] - N, *roots(modes, N, *push(modes, N)))
    straight = np.linspace(*force[POINTS - 1 : POINTS + 1], POINTS)
    force = np.concatenate([force[:POINTS], straight, force[POINTS:]])
    N = np.concatenate([N, np.full(POINTS, turn), N[::-1]])
    constant, slope = push(modes, N)
    c = constant + slope * force
    # At `turn` the stretch that the odd modes leave open is the second mode's.
    free = np.maximum(0.0, -N / modes.axial - np.sum(c * (c + 2 * modes.start), axis=0))
    energy = np.sum(modes.buckling * c**2, axis=0) / 2 + N * free / 2 + N**2 / (4 * modes.axial)
    return displacement(modes, c) + modes.residual * force, force, energy

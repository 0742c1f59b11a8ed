"""The beam pushed slowly: force and energy over the displacement of its midpoint."""

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from ...beam.equilibria import (
    BucklingModes,
    buckling_modes,
    displacement,
    find_barrier,
    push,
    roots,
    shapes_of,
)
from ...beam.limit_loads import largest_force
from ...beam.modal import first_midpoint
from ...device.device import Device
from ...numerics.portable import sines
from ...study.arguments import SingleStudy
from ...study.provenance import device_sections
from ...study.variables import dress
from .. import merge

POINTS = 400
"""Number of points on each of the three parts of a path."""
PATH = "displacement", "force", "energy"
NEAR_LOAD = 1 - 1e-9
"""Share of a buckling load at which a path has not turned below it."""
LEAST_LOG = -32.0
"""Least ln x in `_tilted`; no imperfection is so small that N comes nearer to the load."""


def statics(study: SingleStudy) -> xr.Dataset:
    """Push the midpoint of a beam slowly from the first shape to the second and beyond.

    Parameters
    ----------
    study
        A Device, or a Study, of which only the device matters.

    Returns
    -------
    Dataset
        `displacement` (um), `force` (uN) and `energy` (pJ) over (branch, point). Branches are
        `guided`, a symmetric beam (Vangbo, 1998); `unbranched`, the second mode suppressed, which
        is not physical; and `tilted`, a beam free to tilt.
        Single numbers are of the path that the beam takes: `largest_force` and `least_force`
        between the shapes (uN; above 0 the beam returns by itself), w(L/2) of shapes and saddle
        (`rise`, `second_equilibrium`, `saddle`, um), the energy of the saddle (`barrier`, pJ; 0
        without a second stable shape), and `hold_force` (uN) on an electrode.

    Raises
    ------
    ValueError
        One line, if the study has several devices, or a law in place of the beam's force.

    Examples
    --------
    >>> path = snapmap.statics(snapmap.load_device("config/config.yaml"))
    >>> round(path.largest_force.item(), 2), round(path.least_force.item(), 2)
    (70.67, -32.54)
    """
    if study.model.laws and study.model.laws.force:
        raise ValueError("model.laws: force: statics are of the device's own beam; leave it out")
    return statics_of(study.device)


def statics_of(device: Device) -> xr.Dataset:
    """Push the midpoint of a device's beam, as `statics` does."""
    modes, shapes = buckling_modes(device.beam), shapes_of(device.beam)
    barrier = find_barrier(device.beam, shapes)
    first = first_midpoint(shapes, device.beam).item()
    # Symmetric shapes and others alternate.
    symmetric = _every_second(modes) if device.beam.free else modes
    branches, w = _symmetric_paths(device.beam, symmetric, modes.buckling[1, 0])
    if device.beam.free:
        # With an imperfection the path bends sharply at both ends of the straight part.
        begin, end = w[POINTS], w[2 * POINTS - 1]
        share = (1 - sines(np.linspace(0.25, 0.75, POINTS))) / 2
        w = np.concatenate([w[:POINTS], begin + (end - begin) * share, w[2 * POINTS :]])
        branches = {"tilted": (w, *_tilted(modes, w)), **branches}
    values = dict(zip(PATH, map(np.stack, zip(*branches.values(), strict=True)), strict=True))
    w, force = values["displacement"][0], values["force"][0]
    data: dict[str, Any] = {key: (("branch", "point"), column) for key, column in values.items()}
    data |= {
        "rise": first,
        "second_equilibrium": barrier.second,
        "saddle": first + barrier.midpoint,
        "barrier": barrier.energy,
        "largest_force": force[: 2 * POINTS].max(),
        "least_force": force[POINTS:].min(),
        **merge(lambda part: part.in_statics(device, first, w, force)),
    }
    path = xr.Dataset(data, {"branch": list(branches)})
    return dress("statics", path, device_sections(device))


def _symmetric_paths(beam, modes, tilts):
    """Branches of a beam that moves symmetrically, and the displacements of a path on which the
    axial force rises to `tilts` at most."""
    if beam.cosines[1::2].any():
        turn = largest_force(modes, partial(push, modes), modes.buckling[1, 0])
        return {"guided": _path(modes, turn)}, _path(modes, min(turn, tilts))[0]
    # The even modes neither move the midpoint nor are in the start: the second mode bifurcates.
    odd = _every_second(modes)
    for load in odd.buckling[1:, 0]:  # beyond each the path goes on, the force reversed
        turn = largest_force(odd, partial(push, odd), load)
        if turn < NEAR_LOAD * load:
            break
    guided = _path(odd, min(turn, modes.buckling[1, 0]))
    branches = {"guided": guided, "unbranched": _path(odd, turn)}
    return branches, _path(odd, min(turn, tilts))[0]


def _every_second(modes):
    return BucklingModes(*(column[::2] for column in modes[:4]), *modes[4:])


def _tilted(modes, w):
    """Force and energy of a free beam whose midpoint is held at displacements w, um.

    A held beam is stable at a single axial force N below the first load N_tilt that tilts it;
    x = 1 - N/N_tilt.
    """
    from scipy.optimize.elementwise import find_root  # half a second, for which nobody else waits

    def held(log_x, w):
        N = modes.buckling[1, 0] * -np.expm1(log_x)
        constant, slope = push(modes, N)
        give = displacement(modes, slope) + modes.residual
        force = (w - displacement(modes, constant)) / give
        return N, force, constant + slope * force

    def over(log_x, w):
        N, _, c = held(log_x, w)
        return N + modes.axial * np.sum(c * (c + 2 * modes.start), axis=0)

    bracket = np.full(w.size, LEAST_LOG), np.full(w.size, np.log(2))
    N, force, c = held(find_root(over, bracket, args=(w,)).x, w)
    return force, _energy(modes, N, c, 0.0, force)


def _energy(modes, N, c, free, force):
    """Energy of the beam, pJ; free: squared amplitude of the mode that buckles at the load N."""
    bent = np.sum(modes.buckling * c**2, axis=0) + N * free + modes.residual * force**2
    return bent / 2 + N**2 / (4 * modes.axial)


def _path(modes, turn):
    """Displacement, force and energy while N rises from 0 to `turn`, stays there, and returns."""
    N = turn * (1 - np.linspace(1, 0, POINTS) ** 2)
    lower, upper = roots(modes, N, *push(modes, N))
    # Crossing a buckling load, the two roots change places.
    crossed = np.count_nonzero(modes.buckling <= N, axis=0)
    rising, back = np.where(crossed % 2 == 0, [lower, upper], [upper, lower])
    straight = np.linspace(rising[-1], back[-1], POINTS)
    force = np.concatenate([rising, straight, back[::-1]])
    N = np.concatenate([N, np.full(POINTS, turn), N[::-1]])
    constant, slope = push(modes, N)
    c = constant + slope * force
    # At `turn` the second mode takes the stretch that the odd modes leave.
    free = np.maximum(0.0, -N / modes.axial - np.sum(c * (c + 2 * modes.start), axis=0))
    return displacement(modes, c) + modes.residual * force, force, _energy(modes, N, c, free, force)

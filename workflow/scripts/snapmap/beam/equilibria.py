"""Equilibria of the beam under slow loads: the branches of a path, and the barrier between shapes.

In buckling modes v_j (kappa v_j = N_j S v_j, v_j.S v_j = 1) equilibrium under a force P on the
midpoint and an acceleration a of the frame reads, with s_j = v_j.S q0,

    (N_j - N) c_j = N s_j - f_j a - e_j P,    N = -EA/2L sum (c_j^2 + 2 c_j s_j).

For a given N the load is a root of a quadratic: one belongs to the path from the first shape to the
largest N, the other, farther along, to the path on from there.
"""

from typing import NamedTuple

import numpy as np

from ..device.arch import equilibria
from ..device.device import Beam, Value
from ..numerics.linalg import apply, dot, eigh
from .basis import Basis
from .cosines import buckling_shapes, symmetric_cosines
from .modal import ModalBeam, UnitBeams, buckling, column, halfway, unit_beams

COSINES = 40
"""Symmetric shapes in which equilibria are sought, and as many others of a free beam."""


class BucklingModes(NamedTuple):
    """A beam in its buckling modes: N_j, s_j, f_j and e_j, (modes, 1); EA/2L; flexibility.

    Of a batch all have one more axis, in front.
    """

    buckling: np.ndarray
    start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Value
    residual: Value


def shapes_of(beam: Beam) -> Basis:
    """Give the basis of a beam's equilibria: COSINES shapes of each kind that the beam takes."""
    return buckling_shapes(COSINES) if np.any(beam.free) else symmetric_cosines(COSINES)


def buckling_modes(beam: Beam) -> BucklingModes:
    """Expand a beam in COSINES buckling modes, twice as many if it is free to tilt.

    A batch is of guided beams or of free ones.
    """
    beams = unit_beams(basis := shapes_of(beam), beam)
    T, q = beams.at_rest
    loads, shapes = buckling(basis)
    start = apply(shapes.T, apply(basis.geometric, q))[beams.index]
    load, midpoint = (apply(shapes.T, vector) for vector in (basis.load, basis.midpoint))
    middle = halfway(T)
    kept = np.sum(midpoint * midpoint / (loads - middle[:, np.newaxis]), axis=-1)
    residual = np.maximum(0.0, basis.flexibility(middle) - kept)[beams.index]

    def scaled(values, factor):
        return (values * np.asarray(factor)[..., np.newaxis])[..., np.newaxis]

    root = np.sqrt(beam.span)
    return BucklingModes(
        buckling=scaled(loads + T[beams.index][..., np.newaxis], beam.stiffness_unit * beam.span),
        start=scaled(start, beam.made_rise / root),
        load=scaled(load, beam.weight * root),
        midpoint=scaled(midpoint, root),
        axial=beam.axial_stiffness,
        residual=residual / beam.stiffness_unit,
    )


def push(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c = constant + slope P under a force P (uN) on the midpoint, each (..., modes, n).

    N: (..., n), uN
    """
    N = N[..., np.newaxis, :]
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.midpoint


def alone(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c = constant + slope a under the load of the pulse alone, as `push`."""
    return push(modes._replace(midpoint=modes.load), N)


def roots(
    modes: BucklingModes, N: np.ndarray, constant: np.ndarray, slope: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Both loads x, (..., n), at which c = constant + slope x stretches the beam to N; or NaN."""
    axial = np.asarray(modes.axial)[..., np.newaxis]
    square = axial * np.sum(slope**2, axis=-2)
    half = axial * np.sum(slope * (constant + modes.start), axis=-2)
    rest = N + axial * np.sum(constant * (constant + 2 * modes.start), axis=-2)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(half**2 - square * rest)
    return (-half - root) / square, (-half + root) / square


def displacement(modes: BucklingModes, c: np.ndarray) -> np.ndarray:
    """How far the midpoint of the kept modes has moved from the first shape, um, (..., n).

    c: (..., modes, n)
    """
    return -np.sum(modes.midpoint * c, axis=-2)


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
    beams, rise = unit_beams(basis, beam), beam.made_rise
    modal, saddle, second_rest = saddle_and_second(beams, modes)
    exists = np.isfinite(saddle).all(axis=-1)
    energy = np.where(exists, _unit_energy(modal, beams.axial, saddle), 0.0)[beams.index]
    midpoint = np.where(exists, dot(modal.midpoint, saddle), 0.0)[beams.index]
    first, second = rise * beams.midpoint[beams.index], beam.second_equilibrium
    if basis.tilt.any():
        stays = first + dot(modal.midpoint, second_rest)[beams.index] * rise
        second = np.where(exists[beams.index], stays, second)
    unit = beam.stiffness_unit * rise * rise
    barrier = Barrier(energy=energy * unit, midpoint=midpoint * rise, second=second, first=first)
    return barrier if np.ndim(beam.rise) else Barrier(*(np.asarray(v).item() for v in barrier))


def saddle_and_second(
    beams: UnitBeams, modes: int | None
) -> tuple[ModalBeam, np.ndarray, np.ndarray]:
    """Give the form of unit beams, and its modes p at the saddle and in the second shape."""
    modal = beams.form(modes)
    stiffness = modal.stiffness[..., np.newaxis] * np.eye(modal.stiffness.shape[-1])
    loads, shapes = eigh(stiffness, modal.geometric)
    s = apply(shapes.swapaxes(-1, -2), modal.slope_start)
    loads, s = (np.broadcast_to(part, (beams.Q.size, part.shape[-1])) for part in (loads, s))
    rest = equilibria(loads, s, beams.axial, np.zeros(beams.Q.size))
    return modal, apply(shapes, rest.saddle - s), apply(shapes, s * rest.second - s)


class Rest(NamedTuple):
    """The second shape of a form at rest: its modes, (..., k), um ng^0.5; its energy, pJ."""

    modes: np.ndarray
    energy: Value


def second_shape(beam: Beam, basis: Basis, modes: int | None = None) -> Rest:
    """Find where a beam rests in its second shape, measured from the first; NaN if it has none."""
    beams, rise = unit_beams(basis, beam), beam.made_rise
    modal, _, p = saddle_and_second(beams, modes)
    energy = _unit_energy(modal, beams.axial, p)[beams.index]
    return Rest(
        modes=p[beams.index] * column(rise * np.sqrt(beam.weight), 1),
        energy=energy * (beam.stiffness_unit * rise * rise),
    )


def require_rest(rest: Rest) -> None:
    """Raise ValueError, one line, if a beam does not stay in its second shape, where it rests."""
    if not np.isfinite(rest.energy).all():
        raise ValueError(
            "start: second needs a guided beam, as a beam free to tilt does not stay there; write "
            "first, or guide: guided"
        )


def _unit_energy(modal, axial, p):
    """Energy of a form in modes p above that at rest, in EI rise^2/L^3."""
    slope = apply(modal.geometric, p) + modal.slope_start
    N = -axial * dot(p, slope + modal.slope_start)
    return dot(p, modal.stiffness * p) / 2 + N * N / (4 * axial)

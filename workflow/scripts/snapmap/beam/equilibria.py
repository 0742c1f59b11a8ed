"""Equilibria of the beam under slow loads, and the energy barrier between its two shapes.

Let v_j be the buckling modes (kappa v_j = N_j S v_j, v_j.S v_j = 1) and s_j = v_j.S q0. Under a
force P on the midpoint and an acceleration a of the frame the beam is in equilibrium if

    (N_j - N) c_j = N s_j - f_j a - e_j P,    N = -EA/2L sum (c_j^2 + 2 c_j s_j).

For a given N the load, a or P, solves a quadratic equation. One root lies on the path from the
first shape to the largest N, the other on the path onwards from there.
"""

from typing import NamedTuple

import numpy as np

from ..device.arch import equilibria
from ..device.device import Beam
from ..numerics.linalg import apply, dot, eigh
from ..values.kinds import Number
from .basis import Basis
from .cosines import buckling_shapes, symmetric_cosines
from .modal import ModalBeam, UnitBeams, buckling, column, halfway, unit_beams

COSINES = 40
"""Number of symmetric shapes for equilibria; a free beam has as many antisymmetric ones."""


class BucklingModes(NamedTuple):
    """A beam in its buckling modes; for a batch all have one more axis in front, (devices, ...).

    buckling: N_j, uN, (modes, 1); start: s_j, (modes, 1), um^0.5
    load: f_j, ng um^0.5, (modes, 1); midpoint: e_j, um^0.5, (modes, 1)
    axial: EA/2L, uN/um; residual: static flexibility of the modes left out, um/uN
    """

    buckling: np.ndarray
    start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: Number
    residual: Number


def shapes_of(beam: Beam) -> Basis:
    """Return the basis for equilibria: COSINES shapes of each kind that the beam can take."""
    return buckling_shapes(COSINES) if np.any(beam.free) else symmetric_cosines(COSINES)


def buckling_modes(beam: Beam) -> BucklingModes:
    """Expand a beam in COSINES buckling modes, or twice as many if it is free to tilt.

    A batch must be of guided beams only, or of free ones only.
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
    """Return constant and slope, (..., modes, n), of c = constant + slope P.

    P is a force on the midpoint, uN; N: axial force, uN, (..., n)
    """
    N = N[..., np.newaxis, :]
    soft = 1 / (modes.buckling - N)
    return soft * N * modes.start, -soft * modes.midpoint


def alone(modes: BucklingModes, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return constant and slope, as `push` does, of c under the pulse alone, a in place of P."""
    return push(modes._replace(midpoint=modes.load), N)


def roots(
    modes: BucklingModes, N: np.ndarray, constant: np.ndarray, slope: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Find both loads x, (..., n), at which c = constant + slope x makes the force N; or NaN."""
    axial = np.asarray(modes.axial)[..., np.newaxis]
    square = axial * np.sum(slope**2, axis=-2)
    half = axial * np.sum(slope * (constant + modes.start), axis=-2)
    rest = N + axial * np.sum(constant * (constant + 2 * modes.start), axis=-2)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(half**2 - square * rest)
    return (-half - root) / square, (-half + root) / square


def displacement(modes: BucklingModes, c: np.ndarray) -> np.ndarray:
    """Return how far the midpoint has moved from the first shape to the second, um, (..., n).

    c: coordinates from the first shape, (..., modes, n)
    """
    return -np.sum(modes.midpoint * c, axis=-2)


class Barrier(NamedTuple):
    """The lowest saddle between the two stable shapes; numbers, or arrays (devices,).

    energy: at the saddle, above the beam at rest in its first shape, pJ
    midpoint: w(L/2) at the saddle minus that at rest, um; halfway to `second` without a saddle
    second: w(L/2) in the second shape, um; that of the guided beam if tilting leaves none
    first: w(L/2) in the first shape, at rest, um
    """

    energy: Number
    midpoint: Number
    second: Number
    first: Number


def find_barrier(beam: Beam, basis: Basis, modes: int | None = None) -> Barrier:
    """Find the lowest saddle of the energy of a beam in some modes of a basis; None keeps all.

    Every way out of a well leads at least as high. Below that energy the wells are separate, and
    w(L/2) compared with the saddle's tells which well the beam is in, as no shape with the saddle's
    midpoint has less energy. The energy is 0 if the model has no stable second shape: if it is too
    coarse, close to Q = 4/sqrt(3), or if the beam is free to tilt out of it.
    """
    beams, rise = unit_beams(basis, beam), beam.made_rise
    modal, saddle, second_rest = saddle_and_second(beams, modes)
    exists = np.isfinite(saddle).all(axis=-1)
    energy = np.where(exists, _unit_energy(modal, beams.axial, saddle), 0.0)[beams.index]
    first, second = rise * beams.midpoint[beams.index], beam.second_equilibrium
    if basis.tilt.any():
        stays = first + dot(modal.midpoint, second_rest)[beams.index] * rise
        second = np.where(exists[beams.index], stays, second)
    unit = beam.stiffness_unit * rise * rise
    # ASSUME: without a saddle a beam is on the side of the shape that is nearer.
    halfway, at_saddle = (second - first) / 2, dot(modal.midpoint, saddle)[beams.index] * rise
    midpoint = np.where(exists[beams.index], at_saddle, halfway)
    barrier = Barrier(energy=energy * unit, midpoint=midpoint, second=second, first=first)
    return barrier if np.ndim(beam.rise) else Barrier(*(np.asarray(v).item() for v in barrier))


def saddle_and_second(
    beams: UnitBeams, modes: int | None
) -> tuple[ModalBeam, np.ndarray, np.ndarray]:
    """Return the modal form of unit beams, and p, (beams, k), at the saddle and second shape."""
    modal = beams.form(modes)
    stiffness = modal.stiffness[..., np.newaxis] * np.eye(modal.stiffness.shape[-1])
    loads, shapes = eigh(stiffness, modal.geometric)
    s = apply(shapes.swapaxes(-1, -2), modal.slope_start)
    loads, s = (np.broadcast_to(part, (beams.Q.size, part.shape[-1])) for part in (loads, s))
    rest = equilibria(loads, s, beams.axial, np.zeros(beams.Q.size))
    return modal, apply(shapes, rest.saddle - s), apply(shapes, s * rest.second - s)


class Rest(NamedTuple):
    """The second shape at rest: modes p, (..., k), um ng^0.5; energy above the first shape, pJ."""

    modes: np.ndarray
    energy: Number


def second_shape(beam: Beam, basis: Basis, modes: int | None = None) -> Rest:
    """Find where a beam rests in its second shape, from the first one; NaN if it has none."""
    beams, rise = unit_beams(basis, beam), beam.made_rise
    modal, _, p = saddle_and_second(beams, modes)
    energy = _unit_energy(modal, beams.axial, p)[beams.index]
    return Rest(
        modes=p[beams.index] * column(rise * np.sqrt(beam.weight), 1),
        energy=energy * (beam.stiffness_unit * rise * rise),
    )


def require_rest(rest: Rest) -> None:
    """Raise ValueError, one line, if a beam has no stable second shape to start from."""
    if not np.isfinite(rest.energy).all():
        raise ValueError(
            "start: second needs a guided beam, as a beam free to tilt does not stay there; write "
            "first, or free: false"
        )


def _unit_energy(modal, axial, p):
    """Return the energy of unit beams in modes p, above that at rest, in EI rise^2/L^3."""
    slope = apply(modal.geometric, p) + modal.slope_start
    N = -axial * dot(p, slope + modal.slope_start)
    return dot(p, modal.stiffness * p) / 2 + N * N / (4 * axial)

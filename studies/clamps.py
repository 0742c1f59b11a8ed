"""What clamps that turn do to the threshold, for docs/limits.md.

./run python -m studies clamps [--small]

A spring of stiffness k, without moment as made, resists the slope at each end of the beam. Lengths
are over the span, deflections over the rise, forces over EI/L^2 along the beam and over
EI rise/L^3 across it. The compliance is b = EI/kL.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from snapmap.beam.basis import PLACES, Basis
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import find_barrier, saddle_and_second
from snapmap.beam.modal import reduce_to_modes, unit_beams
from snapmap.device.device import Beam, Device
from snapmap.solver.cells import to_rows
from snapmap.solver.models import Model
from snapmap.solver.settings import Run
from snapmap.solver.steps import steps_of
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import command_device, few
from .tables import Table, write

ANCHORS = {"a rigid root": 16, "linear stress": 18, "3 times as soft": 54, "10 times": 180}
"""s of k = pi E H t^2/s. An anchor that is an elastic half-plane in plane stress has 16 where the
beam's root stays plane, and 18 where the stress over the root is linear; it lies between."""
F0, C = [500.0, 1500.0, 5000.0], 25.0
ELEMENTS, MODES, STEP, TOLERANCE = 20, 11, 0.25, 1e-6
"""Elements of the half beam, modes kept, step over the default, and tolerance of thresholds."""
POINTS, NODES, HORIZON = 400, 80, 1500.0
"""Axial forces at which a maximum is sought, and nodes of Gauss on half the
beam; time followed after the pulse, us."""


def main():
    device = command_device()
    write("clamps", turning_clamps(device))


def turning_clamps(device: Device) -> Table:
    """Make a table of what anchors of several compliances change, in per cent."""
    rigid, rows = changed(device, 0.0), []
    for name, s in few(ANCHORS, 2).items():
        b = compliance(device.beam, s)
        apart = (f"{100 * (x - 1):+.2f}" for x in np.divide(changed(device, b), rigid))
        k = device.beam.bending_stiffness / (b * device.beam.span) * 1e-6
        rows.append([name, f"{k:.3g}", f"{1e3 * b:.2f}", f"{100 * slope(b):.2f}", *apart])
    head = ["anchor", "k, uN m", "1000 EI/kL", "slope, %", "buckling load, %", "frequency, %"]
    head += ["static, %", "by elements, %", *(f"{f0:g} Hz, %" for f0 in F0)]
    return Table("clamps", head, rows)


def changed(device: Device, b: float) -> list[float]:
    """Find buckling load, frequency, static threshold exactly and by elements, and thresholds."""
    basis = turning_elements(ELEMENTS, b)
    static = (static_threshold(device, response) for response in (exact(b), of_elements(basis)))
    exactly = buckling_root(b) ** 2, vibration_root(b) ** 2
    return [*exactly, *static, *thresholds(device, basis, few(F0))]


def compliance(beam: Beam, s: float) -> float:
    """Return b = EI/kL of the anchor k = pi E H t^2/s."""
    return s * beam.thickness / (12 * np.pi * beam.span)


def buckling_root(b: float) -> float:
    """Find mu of the first symmetric buckling load mu^2: tan(mu/2) = -mu b."""
    return brentq(lambda mu: np.sin(mu / 2) + mu * b * np.cos(mu / 2), np.pi, 7.0)


def slope(b: float) -> float:
    """Return the slope at the clamp over the largest one, in the first symmetric buckling shape."""
    return np.sin(buckling_root(b) / 2)


def vibration_root(b: float) -> float:
    """Find beta of the first frequency beta^2 of the straight beam, over sqrt(EI/rho A L^4)."""

    def moment(beta):
        half = beta / 2
        return np.sin(half) + np.cos(half) * (np.tanh(half) + 2 * b * beta)

    return brentq(moment, np.pi, 2 * np.pi)


class Response(NamedTuple):
    """How the guided beam under an axial force N answers three loads, by superposition.

    The loads are N on the shape as made w0, and towards -w a unit force on the midpoint and a unit
    load along the beam.
    midpoint: (3,); squares: (3, 3), integrals of products of slopes; start: (3,), those with w0'
    """

    midpoint: np.ndarray
    squares: np.ndarray
    start: np.ndarray


def exact(b: float) -> Callable[[float], Response]:
    """Solve v'' + N v = -N w0' - P/2 - p y of the slope v(y), y from the midpoint to a clamp.

    The ends have v = 0 and b v' + v = 0.
    """
    y, weights = np.polynomial.legendre.leggauss(NODES)
    y, weights = (y + 1) / 4, weights / 2
    made = -np.pi * np.sin(2 * np.pi * y)

    def response(N):
        mu = np.sqrt(N)
        sin, cos, wave = np.sin(mu / 2), np.cos(mu / 2), np.pi * N / (N - 4 * np.pi**2)
        v = np.array([wave * np.sin(2 * np.pi * y), (np.cos(mu * y) - 1) / (2 * N), -y / N])
        end = np.array([0.0, (cos - 1) / (2 * N), -1 / (2 * N)])
        end -= b * np.array([2 * np.pi * wave, sin / (2 * mu), 1 / N])
        v -= np.multiply.outer(end / (sin + b * mu * cos), np.sin(mu * y))
        return Response(-v @ weights / 2, v * weights @ v.T, v * weights @ made)

    return response


def of_elements(basis: Basis) -> Callable[[float], Response]:
    """Solve the same by finite elements."""

    def response(N):
        loads = np.array([N * basis.geometric @ basis.start, -basis.midpoint, -basis.load])
        u = np.linalg.solve(basis.bending - N * basis.geometric, loads.T).T
        slopes = u @ basis.geometric
        return Response(u @ basis.midpoint, slopes @ u.T, slopes @ basis.start)

    return response


def static_threshold(device: Device, response: Callable[[float], Response]) -> float:
    """Find the first maximum of the lasting acceleration of a device whose gap is 0, in N.

    On the path from rest the axial force grows up to it.
    """

    def less(N):
        return -balance(device, N, response(N))

    forces = np.linspace(0, 2 * (4 * np.pi) ** 2, 2 * POINTS + 1)[1::2]
    top = np.argmax(~(np.diff([less(N) for N in forces]) < 0))
    best = minimize_scalar(less, bounds=forces[[top - 1, top + 1]], options={"xatol": 1e-9})
    unit = device.beam.stiffness_unit * device.beam.rise
    return -best.fun * unit / (device.mass * device.gravity)


def balance(device: Device, N: float, response: Response) -> float:
    """Return the force M a of the mass with which the stretch of the beam makes N; or NaN.

    Contact and spring give P (1/lambda + 1/K) = midpoint + M a/K, and the beam's own load is
    p = M a m/M, so that all is linear in M a and the stretch a quadratic equation.
    """
    beam = device.beam
    give = beam.stiffness_unit * (1 / device.contact + 1 / device.spring) - response.midpoint[1]
    share = beam.weight / device.mass
    grows = response.midpoint[2] * share + beam.stiffness_unit / device.spring
    still = np.array([1.0, response.midpoint[0] / give, 0.0])
    moved = np.array([0.0, grows / give, share])
    axial = 6 * beam.bistability**2
    square = axial * moved @ response.squares @ moved
    half = axial * moved @ (response.squares @ still + response.start)
    rest = N + axial * still @ (response.squares @ still + 2 * response.start)
    root = np.sqrt(half * half - square * rest) if half * half > square * rest else np.nan
    # The root on the path from rest has the sign of the direction in which the midpoint moves.
    return (-half - np.copysign(root, -response.midpoint @ moved)) / square


def turning_elements(elements: int, b: float) -> Basis:
    """Add to Hermite elements the slope at the clamp, as first unknown, and a spring on it."""
    clamped, h = hermite_elements(elements), 1 / (2 * elements)
    if not b:
        return clamped
    rows = {
        "bending": np.array([4 / h + 1 / b, -6 / h**2, 2 / h]),
        "geometric": np.array([4 * h, -3, -h]) / 30,
        "mass": np.array([4 * h**3, 13 * h**2, -3 * h**3]) / 420,
    }
    matrices = {name: _bordered(getattr(clamped, name), 2 * row) for name, row in rows.items()}
    loads = {"load": h * h / 6, "midpoint": 0.0, "start": 0.0, "tilt": 0.0}
    vectors = {name: np.append(first, getattr(clamped, name)) for name, first in loads.items()}
    curvature = np.zeros((PLACES, 2 * elements))

    def flexibility(N):
        tangent = matrices["bending"] - np.asarray(N)[..., None, None] * matrices["geometric"]
        return np.linalg.solve(tangent, vectors["midpoint"][:, None])[..., -1, 0]

    made = {**matrices, **vectors, "curvature": curvature, "flexibility": flexibility}
    return replace(clamped, **made)


def _bordered(matrix, row):
    """Put an unknown before those of a symmetric matrix; row: its first entries."""
    whole = np.pad(matrix, ((1, 0), (1, 0)))
    whole[0, : row.size] = whole[: row.size, 0] = row
    return whole


def thresholds(device: Device, basis: Basis, f0: list[float]) -> np.ndarray:
    """Find the thresholds of a device whose beam is that of a basis, (f0,)."""
    beam, modes = device.beam, few(MODES, 3)
    modal, barrier = reduce_to_modes(beam, basis, modes), find_barrier(beam, basis, modes)
    unit, _, second = saddle_and_second(unit_beams(basis, beam), modes)
    travel = (unit.midpoint @ second[0]) * beam.rise
    barrier = barrier._replace(second=barrier.first + travel)
    model = Model("elements", device, basis, modal, barrier, steps_of(device, modal))
    probe = Probe(model.with_step(STEP), to_rows(0, f0, C), Run(horizon=HORIZON))
    return lowest_snap(probe, (300.0, 3000.0), TOLERANCE)

"""The beam in nodal unknowns, and its mass: coefficients, axial force and energies."""

from typing import NamedTuple

import numpy as np

from ..beam.basis import Basis
from ..beam.modal import pulse_load, settled
from ..device.device import Device
from ..numerics.kernels import compiled, fma
from ..numerics.linalg import apply, solve_all


class System(NamedTuple):
    """Coefficients of eqs. (2), (4) and (5) in n nodal unknowns; units um, ng, us.

    inertia, inverse_inertia, bending, geometric: (n, n); load, midpoint: (n,), as in `Basis`
    slope_start: (n,), G q0, of the shape at rest
    axial: E A / (2 L), uN/um
    mass, spring, penalty: M (ng), K (uN/um), lambda (uN/um)
    gap: z0, between mass and midpoint at rest, um
    beam_damping: rate alpha of the force -alpha Mb du/dt on the beam, 1/us
    stop_toward, stop_away: travel of the mass up to a stop, um; restitution: of both stops
    start: (n,), u at the begin of a run; side: 1, or -1 for runs from the second shape
    """

    inertia: np.ndarray
    inverse_inertia: np.ndarray
    bending: np.ndarray
    geometric: np.ndarray
    slope_start: np.ndarray
    load: np.ndarray
    midpoint: np.ndarray
    axial: float
    mass: float
    spring: float
    penalty: float
    gap: float
    beam_damping: float
    stop_toward: float
    stop_away: float
    restitution: float
    start: np.ndarray
    side: float


def nodal_system(device: Device, basis: Basis, start: np.ndarray | None = None) -> System:
    """Collect the coefficients of a device with a penalty contact, on a basis of its beam.

    start: u of the second shape, (n,), if a run begins there
    """
    scaled = settled(basis, device.beam).scaled_to(device.beam)
    return System(
        inertia=scaled.mass,
        inverse_inertia=solve_all(scaled.mass, np.eye(scaled.load.size)),
        bending=scaled.bending,
        geometric=scaled.geometric,
        slope_start=apply(scaled.geometric, scaled.start),
        load=pulse_load(device, scaled.load, scaled.midpoint),
        midpoint=scaled.midpoint,
        axial=float(device.beam.axial_stiffness),
        mass=device.mass,
        spring=device.spring,
        penalty=device.contact,
        gap=device.gap,
        beam_damping=device.beam.damping,
        stop_toward=device.stop_toward,
        stop_away=device.stop_away,
        restitution=float(device.restitution),
        start=np.zeros(scaled.load.size) if start is None else start,
        side=1.0 if start is None else -1.0,
    )


@compiled
def dot(a: np.ndarray, b: np.ndarray) -> float:
    """Return a . b."""
    total = 0.0
    for i in range(a.size):
        total = fma(a[i], b[i], total)
    return total


@compiled
def multiply(matrix: np.ndarray, vector: np.ndarray, result: np.ndarray) -> None:
    """Set result to matrix vector, in place."""
    for i in range(vector.size):
        total = 0.0
        for j in range(vector.size):
            total = fma(matrix[i, j], vector[j], total)
        result[i] = total


@compiled
def axial_force(
    system: System, u: np.ndarray, bending_u: np.ndarray, geometric_u: np.ndarray
) -> float:
    """Set bending_u = Kb u and geometric_u = G u; returns N = -EA/2L (2 u.G q0 + u.G u), uN."""
    quadratic = 0.0
    for i in range(u.size):
        bending_row, geometric_row = 0.0, 0.0
        for j in range(u.size):
            bending_row = fma(system.bending[i, j], u[j], bending_row)
            geometric_row = fma(system.geometric[i, j], u[j], geometric_row)
        bending_u[i], geometric_u[i] = bending_row, geometric_row
        quadratic += u[i] * (geometric_row + 2 * system.slope_start[i])
    return -system.axial * quadratic


@compiled
def free_energy(
    system: System, u: np.ndarray, velocity: np.ndarray, of_mass: tuple[float, float], N: float
) -> float:
    """Return kinetic, bending, axial and spring energy in total, pJ; of_mass: y and dy/dt."""
    (y, y_velocity), product = of_mass, np.empty(u.size)
    multiply(system.inertia, velocity, product)
    beam = dot(velocity, product) / 2 + N**2 / (4 * system.axial)
    multiply(system.bending, u, product)
    beam += dot(u, product) / 2
    return beam + (system.mass * y_velocity**2 / 2 + system.spring * y**2 / 2)


@compiled
def contact_energy(system: System, u: np.ndarray, y: float) -> float:
    """Return the energy of the penalty contact, pJ."""
    overlap = max(0.0, dot(system.midpoint, u) - y - system.gap)
    return system.penalty * overlap**2 / 2


@compiled
def beam_loss(system: System, velocity: np.ndarray, product: np.ndarray) -> float:
    """Return the power that the beam's own damping takes, pJ/us; product: room, (n,)."""
    multiply(system.inertia, velocity, product)
    return system.beam_damping * dot(velocity, product)

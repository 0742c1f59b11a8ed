"""The beam, the mass and its spring, in internal units: um, ng, us, so uN, MPa and pJ."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

BISTABILITY_LIMIT = 4 / math.sqrt(3)
THINNEST = 1e6
"""Most of rise over thickness: beyond, the digits of a float no longer hold bending and stretch."""


@dataclass(frozen=True)
class Beam:
    """Clamped beam, stress-free in its first shape; a value that cannot be raises ValueError.

    span, rise, thickness, depth: um
    youngs_modulus: MPa
    density: ng/um^3
    damping: rate at which the beam's own velocity decays, 1/us
    """

    span: float
    rise: float
    thickness: float
    depth: float
    youngs_modulus: float
    density: float
    damping: float = 0.0

    def __post_init__(self):
        for field in fields(self)[:-1]:
            _require_positive(f"device.beam.{field.name}", getattr(self, field.name))
        if not 0 <= self.damping < math.inf:
            raise ValueError(f"device.beam.damping: {self.damping} is not 0 or a positive number")
        if not self.bistability > BISTABILITY_LIMIT:
            raise ValueError(
                f"device.beam.rise: {self.rise:g} um gives Q = rise/thickness = "
                f"{self.bistability:.6g}; a second stable shape needs Q > {BISTABILITY_LIMIT:.3f}"
            )
        if self.bistability > THINNEST:
            raise ValueError(
                f"device.beam.thickness: {self.thickness:g} um gives Q = rise/thickness = "
                f"{self.bistability:.6g}; write one that gives Q up to {THINNEST:g}"
            )

    @property
    def area(self) -> float:
        """A = depth thickness, um^2."""
        return self.depth * self.thickness

    @property
    def inertia(self) -> float:
        """I = depth thickness^3 / 12, um^4."""
        return self.area * self.thickness * self.thickness / 12

    @property
    def mass_per_length(self) -> float:
        """rho A, ng/um."""
        return self.density * self.area

    @property
    def bending_stiffness(self) -> float:
        """E I, uN um^2."""
        return self.youngs_modulus * self.inertia

    @property
    def axial_stiffness(self) -> float:
        """E A / (2 span), uN/um: the axial force per unit of the integral of w'^2."""
        return self.youngs_modulus * self.area / (2 * self.span)

    @property
    def weight(self) -> float:
        """rho A span, the beam's mass, ng."""
        return self.mass_per_length * self.span

    @property
    def stiffness_unit(self) -> float:
        """E I / span^3, uN/um."""
        return self.bending_stiffness / (self.span * self.span * self.span)

    @property
    def bistability(self) -> float:
        """Q = rise / thickness."""
        return self.rise / self.thickness

    @property
    def second_equilibrium(self) -> float:
        """Midpoint of the second stable shape, w2 = -rise (1 + sqrt(1 - 16 / (3 Q^2))) / 2, um."""
        ratio = BISTABILITY_LIMIT / self.bistability
        return -self.rise * (1 + math.sqrt(1 - ratio * ratio)) / 2


@dataclass(frozen=True)
class Device:
    """Beam, and a mass on a spring that strikes it; a value that cannot be raises ValueError.

    mass: ng
    spring, contact: uN/um; contact = math.inf is a hard contact
    gravity: the unit of the shock's amplitude N, um/us^2
    """

    beam: Beam
    mass: float
    spring: float
    contact: float
    gravity: float

    def __post_init__(self):
        for name in ("mass", "spring", "gravity"):
            _require_positive(f"device.{name}", getattr(self, name))
        if not self.contact > 0:
            raise ValueError(f"device.contact: {self.contact} is not a positive number or inf")


def device_from(values: Mapping) -> Device:
    """Rebuild a device from `dataclasses.asdict` of it."""
    return Device(**{**values, "beam": Beam(**values["beam"])})


def _require_positive(key, value):
    if not 0 < value < math.inf:
        raise ValueError(f"{key}: {value} is not a positive, finite number")

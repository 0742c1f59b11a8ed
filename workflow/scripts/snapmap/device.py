"""The beam, the mass and its spring, in internal units: um, ng, us, so uN, MPa and pJ.

Each value is a number or, of a batch of devices, an array, (devices,).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields

import numpy as np

BISTABILITY_LIMIT = 4 / math.sqrt(3)
THINNEST = 1e6
"""Most of rise over thickness: beyond, the digits of a float no longer hold bending and stretch."""

Value = float | np.ndarray


@dataclass(frozen=True)
class Beam:
    """Clamped beam, stress-free in its first shape; a value that cannot be raises ValueError.

    span, rise, thickness, depth: um
    youngs_modulus: MPa
    density: ng/um^3
    damping: rate at which the beam's own velocity decays, 1/us
    """

    span: Value
    rise: Value
    thickness: Value
    depth: Value
    youngs_modulus: Value
    density: Value
    damping: Value = 0.0

    def __post_init__(self):
        for name in BEAM_VALUES[:-1]:
            _require_positive(f"device.beam.{name}", getattr(self, name))
        damping, Q = self.damping, self.bistability
        decays = np.greater_equal(damping, 0) & np.less(damping, np.inf)
        _require(decays, "device.beam.damping: {} is not 0 or a positive number", damping)
        two_shapes = (
            "device.beam.rise: {:g} um gives Q = rise/thickness = {:.6g}; a second stable shape "
            f"needs Q > {BISTABILITY_LIMIT:.3f}"
        )
        _require(np.greater(Q, BISTABILITY_LIMIT), two_shapes, self.rise, Q)
        too_thin = (
            "device.beam.thickness: {:g} um gives Q = rise/thickness = {:.6g}; write one that "
            f"gives Q up to {THINNEST:g}"
        )
        _require(np.less_equal(Q, THINNEST), too_thin, self.thickness, Q)

    @property
    def area(self) -> Value:
        """A = depth thickness, um^2."""
        return self.depth * self.thickness

    @property
    def inertia(self) -> Value:
        """I = depth thickness^3 / 12, um^4."""
        return self.area * self.thickness * self.thickness / 12

    @property
    def mass_per_length(self) -> Value:
        """rho A, ng/um."""
        return self.density * self.area

    @property
    def bending_stiffness(self) -> Value:
        """E I, uN um^2."""
        return self.youngs_modulus * self.inertia

    @property
    def axial_stiffness(self) -> Value:
        """E A / (2 span), uN/um: the axial force per unit of the integral of w'^2."""
        return self.youngs_modulus * self.area / (2 * self.span)

    @property
    def weight(self) -> Value:
        """rho A span, the beam's mass, ng."""
        return self.mass_per_length * self.span

    @property
    def stiffness_unit(self) -> Value:
        """E I / span^3, uN/um."""
        return self.bending_stiffness / (self.span * self.span * self.span)

    @property
    def bistability(self) -> Value:
        """Q = rise / thickness."""
        return self.rise / self.thickness

    @property
    def bending_frequency(self) -> Value:
        """The first of a straight clamped beam, (4.7300/L)^2 sqrt(EI / rho A), rad/us."""
        root = 4.730040744862704 / self.span
        per_length = self.density * self.area
        return root * root * np.sqrt(self.bending_stiffness / per_length)

    @property
    def second_equilibrium(self) -> Value:
        """Midpoint of the second stable shape, w2 = -rise (1 + sqrt(1 - 16 / (3 Q^2))) / 2, um."""
        ratio = BISTABILITY_LIMIT / self.bistability
        return -self.rise * (1 + np.sqrt(1 - ratio * ratio)) / 2


@dataclass(frozen=True)
class Device:
    """Beam, and a mass on a spring that strikes it; a value that cannot be raises ValueError.

    mass: ng
    spring, contact: uN/um; contact = math.inf is a hard contact
    gravity: the unit of the shock's amplitude N, um/us^2
    """

    beam: Beam
    mass: Value
    spring: Value
    contact: Value
    gravity: Value

    def __post_init__(self):
        for name in ("mass", "spring", "gravity"):
            _require_positive(f"device.{name}", getattr(self, name))
        stiff = "device.contact: {} is not a positive number or inf"
        _require(np.greater(self.contact, 0), stiff, self.contact)

    @property
    def own_frequency(self) -> Value:
        """The lower of the mass's own, sqrt(spring / mass), and the beam's first, rad/us.

        A light mass, or one on a stiff spring, rests on a beam that snaps by its own inertia.
        """
        return np.minimum(np.sqrt(self.spring / self.mass), self.beam.bending_frequency)

    def __len__(self) -> int:
        """Number of devices in a batch; 1 for a single device."""
        return int(np.size(self.mass))

    def pick(self, which: int | np.ndarray) -> "Device":
        """One device of a batch, or a batch of some: indices, or a mask, (devices,)."""
        values = asdict(self)
        return _from_values({**values.pop("beam"), **values}, lambda value: value[which])

    def vary(self, values: Mapping[str, np.ndarray]) -> "Device":
        """The same devices but for some values, each (devices,), by their names in VALUES."""
        whole = asdict(self)
        return _from_values({**whole.pop("beam"), **whole, **values}, np.asarray)


BEAM_VALUES = tuple(field.name for field in fields(Beam))
VALUES = (*BEAM_VALUES, "mass", "spring", "contact")
"""Names of the values that tell one device from another."""


UNITS = {
    **dict.fromkeys(("span", "rise", "thickness", "depth"), "um"),
    **{"youngs_modulus": "MPa", "density": "ng/um^3", "damping": "1/us", "mass": "ng"},
    **{"spring": "uN/um", "contact": "uN/um", "gravity": "um/us^2"},
}
"""Internal units, as a config spells them."""


def device_from(values: Mapping) -> Device:
    """Rebuild a device from `dataclasses.asdict` of it."""
    return Device(**{**values, "beam": Beam(**values["beam"])})


def values_of(device: Device | Mapping[str, Device]) -> dict:
    """The values of a device, or of several by name, as plain numbers."""
    if isinstance(device, Mapping):
        return {name: asdict(one) for name, one in device.items()}
    return asdict(device)


def devices_from(values: Mapping) -> Device | dict[str, Device]:
    """Rebuild what `values_of` was given."""
    if "beam" in values:
        return device_from(values)
    return {name: device_from(one) for name, one in values.items()}


def batch(devices: Sequence[Device]) -> Device:
    """Make a batch of single devices."""
    columns = [{**asdict(device.beam), **asdict(device)} for device in devices]
    keys = [key for key in columns[0] if key != "beam"]
    whole = {key: np.array([one[key] for one in columns], float) for key in keys}
    return _from_values(whole, np.asarray)


def is_bistable(beam: Beam, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """Whether the beam with other values, each (size,), has a second stable shape; (size,)."""
    rise, thickness = (values.get(key, getattr(beam, key)) for key in ("rise", "thickness"))
    return np.broadcast_to(np.divide(rise, thickness) > BISTABILITY_LIMIT, (size,))


def _from_values(values, convert):
    beam = {key: convert(values[key]) for key in BEAM_VALUES}
    rest = {key: convert(value) for key, value in values.items() if key not in beam}
    return Device(beam=Beam(**beam), **rest)


def _require_positive(key, value):
    holds = np.greater(value, 0) & np.less(value, np.inf)
    _require(holds, f"{key}: {{}} is not a positive, finite number", value)


def _require(holds, complaint, *values):
    """Raise ValueError with the first values for which it does not hold."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

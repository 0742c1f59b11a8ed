"""A device: beam, mass and spring, in internal units: um, ng, us, and hence uN, MPa and pJ.

Each value is a number, or an array, (devices,), for a batch of devices.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields

import numpy as np

from ..files.text import show
from .checks import numbers, require, require_quantity, warn_of_si
from .curved_beam import BEAM_VALUES, Beam
from .quantities import QUANTITIES, keys_of
from .shape import Value

# ASSUME: silicon strikes silicon, unless a config says otherwise.
RESTITUTION = 0.5
REFERENCE = 20.0
"""Temperature, degC, at which the values of a device hold by default."""
ZERO = 273.15
"""Absolute temperature, K, of 0 degC."""
ALONE = {"mass": 0.0, "spring": 1.0, "contact": 1.0, "gap": math.inf}
"""Values of a beam that no mass ever meets; those of spring and contact have no effect."""
OF_MASS = *ALONE, *keys_of("stops").values()
"""Names of the values that a beam alone does not need."""


@dataclass(frozen=True)
class Device:
    """A beam and a mass on a spring; an impossible value raises ValueError.

    mass: ng; 0, with a gap of math.inf, for a beam alone
    spring: uN/um
    contact: stiffness of the contact, uN/um; math.inf for hard contact
    gravity: unit of N, um/us^2, where pulses shake the frame, as they do if force is 0
    force: unit of N, uN, where pulses push the midpoint of a beam alone
    gap: um, between mass and midpoint at rest
    stop_toward, stop_away: travel of the mass up to a stop, um; math.inf without a stop
    restitution: speed of the mass after a stop over that before, from 0 to 1
    temperature, reference_temperature: degC; at the former the beam's values hold, at the latter C
    modulus_slope: relative change of Young's modulus, 1/K
    expansion_mismatch: thermal expansion of the beam minus that of the frame, 1/K
    damper_exponent: power of the absolute temperature with which C grows
    strength, strength_modulus: Weibull's scale, MPa, and modulus; math.inf: the beam never breaks
    strength_threshold: stress below which no beam breaks, MPa
    contact_at: w(L/2), um, at which the beam touches an electrode; -math.inf without one

    >>> sizes = {"span": 600.0, "rise": 10.0, "thickness": 2.0, "depth": 22.0}
    >>> beam = snapmap.Beam(**sizes, youngs_modulus=150e3, density=2.33e-3)
    >>> snapmap.Device(beam=beam, mass=1e4, spring=5.5, contact=40.0, gravity=9.81e-6).mass
    10000.0
    """

    beam: Beam
    mass: Value
    spring: Value
    contact: Value
    gravity: Value
    gap: Value = 0.0
    force: Value = 0.0
    stop_toward: Value = math.inf
    stop_away: Value = math.inf
    restitution: Value = RESTITUTION
    temperature: Value = REFERENCE
    reference_temperature: Value = REFERENCE
    modulus_slope: Value = 0.0
    expansion_mismatch: Value = 0.0
    damper_exponent: Value = 0.0
    strength: Value = math.inf
    strength_modulus: Value = math.inf
    strength_threshold: Value = 0.0
    contact_at: Value = -math.inf

    def __post_init__(self):
        if not isinstance(self.beam, Beam):
            raise ValueError(f"device.beam: {show(self.beam)} is not a Beam")
        known = numbers(self.mass) is not None and numbers(self.gap) is not None
        alone = known and np.equal(self.mass, 0) & self.is_alone
        for name in (field.name for field in fields(self) if field.name != "beam"):
            value = getattr(self, name)
            if name in ALONE and np.any(alone):
                value = np.where(alone, 1.0, value)
            require_quantity(name, value)
        pushed = "device.force: {:g} uN acts on a beam without a mass; write mass: none"
        require(alone | np.equal(self.force, 0), pushed, self.force)
        stopped = "device.stops: need a mass; leave them out"
        require(~(alone & self.has_stops), stopped)
        if not np.any(self.force):  # under which gravity has no effect
            warn_of_si("", "gravity", vars(self))
        if np.any(self.has_electrode):
            closed = "device.contact_at: {:g} um is not below the midpoint at rest, {:g} um"
            rest = self.beam.height
            require(np.less(self.contact_at, rest), closed, self.contact_at, rest)

    @property
    def own_frequency(self) -> Value:
        """The lower one of `mass_frequency` and `beam.bending_frequency`, rad/us.

        With a light mass or a stiff spring the beam snaps by its own inertia.
        """
        return np.minimum(self.mass_frequency, self.beam.bending_frequency)

    @property
    def mass_frequency(self) -> Value:
        """Frequency of mass and spring, sqrt(spring / mass), rad/us; inf without a mass."""
        with np.errstate(divide="ignore"):
            return np.sqrt(np.divide(self.spring, self.mass))

    @property
    def is_alone(self) -> bool | np.ndarray:
        """Whether no mass ever meets the beam."""
        return np.isinf(self.gap)

    @property
    def has_stops(self) -> bool | np.ndarray:
        """Whether the mass has a stop on either side."""
        return np.isfinite(self.stop_toward) | np.isfinite(self.stop_away)

    @property
    def has_electrode(self) -> bool | np.ndarray:
        """Whether the beam can touch an electrode."""
        return np.isfinite(self.contact_at)

    @property
    def damper_factor(self) -> Value:
        """C at the device's temperature over C at the reference temperature."""
        if not np.any(self.damper_exponent):
            return np.ones(np.shape(self.temperature))[()]
        ratio = np.add(self.temperature, ZERO) / np.add(self.reference_temperature, ZERO)
        return np.vectorize(float.__pow__)(ratio, self.damper_exponent)[()]

    def __len__(self) -> int:
        """Return the number of devices in a batch; 1 for a single device."""
        return int(np.size(self.mass))

    def pick(self, which: int | np.ndarray) -> "Device":
        """Pick a device of a batch by its index, or a smaller batch by indices or a mask."""
        return _from_values(_values_of(self), lambda value: value[which])

    def vary(self, values: Mapping[str, np.ndarray]) -> "Device":
        """Return the same devices with other values, each (devices,), by their names in VALUES.

        With a temperature among them, the others hold at the reference temperature.
        Raises ValueError if a beam has no second shape.
        """
        device = _from_values({**_values_of(self), **self.warmed(values)}, np.asarray)
        device.beam.require_second_shape()
        return device

    def at(self, temperature: float) -> "Device":
        """Return a single device at a temperature, degC; ValueError if it has no second shape."""
        return batch([self]).vary({"temperature": np.array([temperature])}).pick(0)

    def warmed(self, values: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """Add modulus and stress, if the temperature is among the values for `vary`.

        E = E0 (1 + slope dT),  stress = stress0 - E0 mismatch dT
        """
        if "temperature" not in values:
            return values
        # ASSUME: nothing else depends on temperature: expansion changes sizes by some 1e-4.
        dT_before = self.temperature - self.reference_temperature
        dT = values["temperature"] - self.reference_temperature
        at_reference = self.beam.youngs_modulus / (1 + self.modulus_slope * dT_before)
        relaxed = self.beam.residual_stress + at_reference * self.expansion_mismatch * dT_before
        modulus = values.get("youngs_modulus", at_reference)
        stress = values.get("residual_stress", relaxed)
        return {
            **values,
            "youngs_modulus": modulus * (1 + self.modulus_slope * dT),
            "residual_stress": stress - modulus * self.expansion_mismatch * dT,
        }


_NAMES = (*BEAM_VALUES, *(field.name for field in fields(Device)))
_NUMBERS = [key for key in _NAMES if key in QUANTITIES]
VALUES = tuple(key for key in _NUMBERS if QUANTITIES[key].long_name)
"""Names of the values in which devices of a study may differ."""
SIGNED = tuple(key for key in VALUES if QUANTITIES[key].range.low < 0)
FROM_ZERO = tuple(key for key in VALUES if QUANTITIES[key].range.low_fits and key not in SIGNED)
"""Names of the values that may be negative (SIGNED) or zero; all others are positive."""


def batch(devices: Sequence[Device]) -> Device:
    """Make a batch of single devices."""
    rows = [_values_of(device) for device in devices]
    columns = {key: np.array([row[key] for row in rows], float) for key in rows[0]}
    return _from_values(columns, np.asarray)


def is_bistable(device: Device, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """Return whether the beam with other values, each (size,), has a second shape: (size,)."""
    values = asdict(device.beam) | device.warmed(values)
    beam = Beam(**{key: values[key] for key in BEAM_VALUES})
    return np.broadcast_to(beam.is_bistable, (size,))


def _values_of(device):
    values = asdict(device)
    return values.pop("beam") | values


def _from_values(values, convert):
    beam = {key: convert(values[key]) for key in BEAM_VALUES}
    rest = {key: convert(value) for key, value in values.items() if key not in beam}
    return Device(beam=Beam(**beam), **rest)

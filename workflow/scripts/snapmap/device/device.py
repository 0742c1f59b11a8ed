"""A device: beam, mass and spring, in internal units: um, ng, us, and hence uN, MPa and pJ.

Each value is a number, or an array, (devices,), for a batch of devices.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields

import numpy as np

from ..values import quantities
from ..values.kinds import Number, Quantity, kind_of
from ..values.records import assemble, hints, record
from ..values.units import plain_numbers
from .curved_beam import BEAM_VALUES, Beam
from .usual import require

# ASSUME: silicon strikes silicon, unless a config says otherwise.
RESTITUTION = 0.5
REFERENCE = 20.0
"""Temperature, degC, at which the values of a device hold by default."""
ZERO = 273.15
"""Absolute temperature, K, of 0 degC."""
ALONE = {"mass": 0.0, "spring": 1.0, "contact": 1.0, "gap": math.inf}
"""Values of a beam that no mass ever meets; those of spring and contact have no effect."""
STOPS = ("stop_toward", "stop_away", "restitution")
OF_MASS = *ALONE, *STOPS
"""Names of the values that a beam alone does not need."""


@record
class Device:
    """A beam, and a mass on a spring that strikes it; an impossible value raises ValueError.

    A plain number counts in um, ng, uN/um, MPa, um/us^2 and degC; text has its unit.

    Examples
    --------
    >>> sizes = {"span": "600 um", "rise": 10.0, "thickness": 2.0, "depth": 22.0}
    >>> beam = snapmap.Beam(**sizes, youngs_modulus="150 GPa", density="2330 kg/m^3")
    >>> device = {"mass": "1e-8 kg", "spring": 5.5, "contact": 40.0, "gravity": "9.81 m/s^2"}
    >>> snapmap.Device(beam=beam, **device).mass
    10000.0
    """

    beam: Beam
    """dimensions and material of the beam"""
    mass: quantities.Mass
    """moving mass; `none` for a beam alone, without spring, contact, gap, stops and C"""
    spring: quantities.Stiffness | quantities.LeftOut = None
    """stiffness of the spring that holds the mass; required, unless `mass` is none"""
    contact: quantities.Contact | quantities.LeftOut = None
    """stiffness of the place of impact, or `hard`; required, unless `mass` is none"""
    gravity: quantities.Acceleration | quantities.LeftOut = None
    """the unit of N; required, or `force`"""
    gap: quantities.Gap = 0.0
    """distance between mass and midpoint at rest"""
    force: quantities.Force = 0.0
    """the unit of N if the pulse pushes the midpoint of a beam without mass; replaces `gravity`"""
    stop_toward: quantities.Travel = math.inf
    """travel of the mass from rest to a stop, towards the beam or away; no stop if left out"""
    stop_away: quantities.Travel = math.inf
    """travel of the mass from rest to a stop, towards the beam or away; no stop if left out"""
    restitution: quantities.Restitution = RESTITUTION
    """share of its speed that the mass keeps at a stop"""
    temperature: quantities.Temperature | quantities.LeftOut = None
    """temperature at which modulus and stress hold; that of `reference_temperature` if left out"""
    reference_temperature: quantities.Temperature = REFERENCE
    """temperature at which C holds"""
    modulus_slope: quantities.Expansion = 0.0
    """relative change of Young's modulus"""
    expansion_mismatch: quantities.Expansion = 0.0
    """thermal expansion of the beam minus that of the frame"""
    damper_exponent: quantities.Exponent = 0.0
    """power of the absolute temperature with which C grows"""
    strength: quantities.Strength = math.inf
    """stress at which the beam breaks, never if left out; with a Weibull modulus, the excess over
    `strength_threshold` at which 63 % of beams break"""
    strength_modulus: quantities.WeibullModulus = math.inf
    """Weibull modulus of the strength: the larger, the less scatter; no scatter if left out"""
    strength_threshold: quantities.LeastStrength = 0.0
    """stress below which no beam breaks"""
    contact_at: quantities.Position = -math.inf
    """w(L/2) where the beam touches an electrode; no electrode if left out"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find values that a device lacks, with a mass or without one."""
        needed = [*(() if is_none(written.get("mass")) else ("spring", "contact"))]
        needed += () if "force" in written else ("gravity",)
        missing = [key for key in needed if key not in written]
        return {key: f"missing; write {kind_of(hints(cls)[key]).asks}" for key in missing}

    def __post_init__(self):
        """Complete what follows from other values; ValueError if some do not fit each other."""
        alone = np.equal(self.mass, 0)
        if np.all(alone):
            far = np.full(alone.shape, math.inf) if alone.ndim else math.inf
            object.__setattr__(self, "gap", far)
        missing = {"spring": 1.0, "contact": 1.0, "gravity": 1.0}
        missing["temperature"] = self.reference_temperature
        for key, value in missing.items():
            if getattr(self, key) is None:
                object.__setattr__(self, key, value)
        far = "gap: {:g} um is not finite; write mass: none for a beam alone"
        require(alone | np.isfinite(self.gap), far, self.gap)
        pushed = "force: {:g} uN acts on a beam without a mass; write mass: none"
        require(alone | np.equal(self.force, 0), pushed, self.force)
        if np.any(self.has_electrode):
            closed = "contact_at: {:g} um is not below the midpoint at rest, {:g} um"
            rest = self.beam.height
            require(np.less(self.contact_at, rest), closed, self.contact_at, rest)

    @property
    def own_frequency(self) -> Number:
        """The lower one of `mass_frequency` and `beam.bending_frequency`, rad/us.

        With a light mass or a stiff spring the beam snaps by its own inertia.
        """
        return np.minimum(self.mass_frequency, self.beam.bending_frequency)

    @property
    def mass_frequency(self) -> Number:
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
    def damper_factor(self) -> Number:
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
        return _from_values(values_of(self), lambda value: value[which])

    def vary(self, values: Mapping[str, np.ndarray]) -> "Device":
        """Return the same devices with other values, each (devices,), by their names in VALUES.

        With a temperature among them, the others hold at the reference temperature.
        Raises ValueError if a beam has no second shape.
        """
        for key, value in values.items():
            try:
                KINDS[key].take(value)
            except ValueError as error:
                raise ValueError(f"{key}: {error}") from None
        require(np.greater(values.get("mass", 1.0), 0), "mass: a beam alone is no value of an axis")
        changed = values_of(self) | self.warmed(values)
        device = _from_values(changed, np.asarray) if values else self
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


def is_none(mass: object) -> bool:
    """Tell whether a mass is none: the word, 0, or a batch of zeros."""
    if isinstance(mass, str):
        return mass == "none"
    numbers = plain_numbers(mass)
    return numbers is not None and not np.any(numbers)


_KINDS = {key: kind_of(hint) for key, hint in {**hints(Beam), **hints(Device)}.items()}
KINDS = {key: kind for key, kind in _KINDS.items() if isinstance(kind, Quantity)}
"""Kind of each number of a device, by name."""
FIXED = {
    *("gravity", "force", "reference_temperature", "modulus_slope", "expansion_mismatch"),
    *("damper_exponent", "strength", "strength_modulus", "strength_threshold", "contact_at"),
}
VALUES = tuple(key for key in KINDS if key not in FIXED)
"""Names of the values in which devices of a study may differ."""


def batch(devices: Sequence[Device]) -> Device:
    """Make a batch of single devices."""
    rows = [values_of(device) for device in devices]
    columns = {key: np.array([row[key] for row in rows], float) for key in rows[0]}
    return _from_values(columns, np.asarray)


def is_bistable(device: Device, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """Return whether the beam with other values, each (size,), has a second shape: (size,)."""
    values = values_of(device) | device.warmed(values)
    beam = assemble(Beam, {key: values[key] for key in BEAM_VALUES})
    return np.broadcast_to(beam.is_bistable, (size,))


def values_of(device: Device) -> dict[str, Number]:
    """Give all values of a device, those of its beam among them, by name."""
    names = ((part, field.name) for part in (device.beam, device) for field in fields(part))
    return {name: getattr(part, name) for part, name in names if name != "beam"}


def _from_values(values, convert):
    beam = {key: convert(values[key]) for key in BEAM_VALUES}
    rest = {key: convert(value) for key, value in values.items() if key not in beam}
    return assemble(Device, {"beam": assemble(Beam, beam), **rest})

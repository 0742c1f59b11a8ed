"""The beam, the mass and its spring, in internal units: um, ng, us, so uN, MPa and pJ.

Each value is a number or, of a batch of devices, an array, (devices,).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields

import numpy as np

from .quantities import KINDS, QUANTITIES
from .shape import (
    BISTABILITY_LIMIT,
    COSINE,
    SHAPES,
    TILT,
    Value,
    coefficients,
    cosine_at_rest,
    first_force,
    least_bistability,
    least_compression,
    least_compression_of_cosine,
    midpoint,
    second_force,
)

# ASSUME: silicon that meets silicon; a config says its own.
RESTITUTION = 0.5
CLAMP = {"axial": "clamp_axial"}
"""Values of the beam by their keys in the config's section `clamp`."""
STOPS = {"toward": "stop_toward", "away": "stop_away", "restitution": "restitution"}
"""Likewise of the device in its section `stops`."""
THERMAL = {
    "reference": "reference_temperature",
    "modulus": "modulus_slope",
    "mismatch": "expansion_mismatch",
    "damping": "damper_exponent",
}
"""Likewise in its section `thermal`."""
REFERENCE = 20.0
"""Temperature, degC, at which the values of a device hold unless it says another."""
ZERO = 273.15
"""K, of 0 degC."""
STRENGTH = {
    "scale": "strength",
    "modulus": "strength_modulus",
    "threshold": "strength_threshold",
}
"""Likewise in its section `strength`."""
ALONE = {"mass": 0.0, "spring": 1.0, "contact": 1.0, "gap": math.inf}
"""Values of a device whose beam no mass ever meets; its spring and contact are of no account."""
OF_MASS = *ALONE, *STOPS.values()
"""Values that a beam alone has no use for."""
THINNEST = 1e6
"""Most of rise over thickness: beyond, the digits of a float no longer hold bending and stretch."""
FLAT = 1e-8
"""Rise of a straight beam, over that to which it buckles: so its first shape is one of two."""


@dataclass(frozen=True)
class Beam:
    """Clamped beam, stress-free in its first shape; a value that cannot be raises ValueError.

    span, rise, thickness, depth: um; rise 0 is a straight beam, which compression must buckle
    youngs_modulus: MPa
    density: ng/um^3
    damping: drag on the beam over its momentum, 1/us; swings decay at half of it
    residual_stress: along the axis as made, before the beam bends to relieve it; tension positive,
        MPa
    imperfection: largest displacement in the first antisymmetric shape, as made, um
    free: whether it may tilt, 1 or 0: a guided beam moves symmetrically
    clamp_axial: stiffness of each clamp along the beam, uN/um; math.inf is rigid
    shape: as made, "cosine", "arc" (a circle's) or "parabola"
    cosine_2, ..., cosine_5: (1 - cos(2 n pi x/L))/2 in it, over the rise, which stays as it is
    """

    span: Value
    rise: Value
    thickness: Value
    depth: Value
    youngs_modulus: Value
    density: Value
    damping: Value = 0.0
    residual_stress: Value = 0.0
    imperfection: Value = 0.0
    free: Value = 0.0
    clamp_axial: Value = math.inf
    shape: str | np.ndarray = COSINE
    cosine_2: Value = 0.0
    cosine_3: Value = 0.0
    cosine_4: Value = 0.0
    cosine_5: Value = 0.0

    def __post_init__(self):
        for name in SIZES:
            check = _require_from_zero if name == "rise" else _require_positive
            check(f"device.beam.{name}", getattr(self, name))
        known = np.isin(self.shape, SHAPES)
        _require(known, f"device.beam.shape: {{}} is not one of {', '.join(SHAPES)}", self.shape)
        for name in COSINES:
            value = getattr(self, name)
            _require(np.isfinite(value), f"device.beam.{name}: {{}} is not finite", value)
        soft = "device.beam.clamp.axial: {} is not a positive number"
        _require(np.greater(self.clamp_axial, 0), soft, self.clamp_axial)
        for name in ("damping", "imperfection"):
            _require_from_zero(f"device.beam.{name}", getattr(self, name))
        stress, Q = self.residual_stress, np.divide(self.rise, self.thickness)
        _require(np.isfinite(stress), "device.beam.residual_stress: {} is not finite", stress)
        if self.is_cosine.all():
            self.require_second_shape()
        straight = (
            "device.beam.imperfection: {:g}; a free beam without one never tilts, write 0.01 um"
        )
        tilts = np.greater(self.imperfection, 0) | np.equal(self.free, 0)
        _require(tilts, straight, self.imperfection)
        guided = "device.beam.imperfection: {:g} um is of a free beam; write guide: free"
        fits = np.equal(self.imperfection, 0) | np.not_equal(self.free, 0)
        _require(fits, guided, self.imperfection)
        too_thin = (
            "device.beam.thickness: {:g} um gives Q = rise/thickness = {:.6g}; write one that "
            f"gives Q up to {THINNEST:g}"
        )
        _require(np.less_equal(Q, THINNEST), too_thin, self.thickness, Q)

    def require_second_shape(self) -> None:
        """Raise ValueError if the beam, or one of them, has no second stable shape.

        Another shape than a cosine is told so where it is shaken: slowly pushed it may be any.
        """
        bistable, stress = self.is_bistable, self.residual_stress
        if np.all(bistable):
            return
        Q = np.divide(self.rise, self.thickness)
        needed = self.bistability_limit
        two_shapes = (
            "device.beam: rise/thickness = {:g} um/{:g} um = {:.6g}; a second stable shape needs "
            "more than {:.3f}"
        )
        at_fault = self.rise, self.thickness, Q, needed
        holds = bistable | np.greater(Q, needed)
        _require(holds | np.less(stress, 0) | np.equal(self.rise, 0), two_shapes, *at_fault)
        pressed = f"{two_shapes}, or a residual stress up to {{:.5g}} MPa"
        _require(holds, pressed, *at_fault, self.most_stress)
        beyond = (
            "device.beam.residual_stress: {:g} MPa leaves no second stable shape; there is one up "
            "to {:.5g} MPa"
        )
        _require(bistable, beyond, stress, self.most_stress)

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
        """E A / (2 span), uN/um, less what the clamps give: force per integral of w'^2."""
        return self.youngs_modulus * self.area / (2 * self.span) * self.held

    @property
    def held(self) -> Value:
        """Share of the beam's axial stiffness that clamps which give leave it, up to 1."""
        return 1 / (1 + 2 * self.youngs_modulus * self.area / (self.clamp_axial * self.span))

    @property
    def weight(self) -> Value:
        """rho A span, the beam's mass, ng."""
        return self.mass_per_length * self.span

    @property
    def stiffness_unit(self) -> Value:
        """E I / span^3, uN/um."""
        return self.bending_stiffness / (self.span * self.span * self.span)

    @property
    def made_rise(self) -> Value:
        """The rise, um; of a straight beam next to none: the length in which forms are held."""
        if np.all(self.rise):
            return self.rise
        beyond = np.maximum(self.compression - 1, FLAT)
        buckled = self.thickness * np.sqrt(4 / 3 * beyond / self.held)
        return np.where(np.equal(self.rise, 0), FLAT * buckled, self.rise)[()]

    @property
    def bistability(self) -> Value:
        """Q = rise / thickness, of clamps that give times the root of what they leave."""
        return self.made_rise / self.thickness * np.sqrt(self.held)

    @property
    def bistability_limit(self) -> Value:
        """Rise over thickness above which there is a second stable shape without stress."""
        limit = np.full(np.shape(self.is_cosine), BISTABILITY_LIMIT)
        if not self.is_cosine.all():
            limit = np.where(self.is_cosine, limit, least_bistability(self.cosines))
        return (limit / np.sqrt(self.held))[()]

    @property
    def cosines(self) -> np.ndarray:
        """The shape as made, as `shape.coefficients` gives it, (..., TERMS)."""
        added = [getattr(self, name) for name in COSINES]
        return coefficients(self.shape, self.made_rise / self.span, added)

    @property
    def is_cosine(self) -> np.ndarray:
        """Whether the shape as made is the first cosine alone, an array."""
        found = np.equal(self.shape, COSINE)
        for name in COSINES:
            found = found & np.equal(getattr(self, name), 0)
        return np.asarray(found)

    @property
    def is_bistable(self) -> bool | np.ndarray:
        """Whether it has a second stable shape, if it is guided."""
        Q, compression, plain = self.bistability, self.compression, self.is_cosine
        at_rest = np.greater(Q, BISTABILITY_LIMIT)
        holds = np.where(compression == 0, at_rest, compression > least_compression_of_cosine(Q))
        if plain.all():
            return holds[()]
        return np.where(plain, holds, compression > least_compression(Q, self.cosines))[()]

    @property
    def bending_frequency(self) -> Value:
        """The first of a straight clamped beam, (4.7300/L)^2 sqrt(EI / rho A), rad/us."""
        root = 4.730040744862704 / self.span
        per_length = self.density * self.area
        return root * root * np.sqrt(self.bending_stiffness / per_length)

    @property
    def buckling_stress(self) -> Value:
        """Compression at which the flat beam buckles, 4 pi^2 EI / (A span^2), MPa."""
        root = math.pi * self.thickness / self.span
        return self.youngs_modulus * root * root / 3

    @property
    def compression(self) -> Value:
        """Residual stress over that of buckling, compression positive, less what clamps give."""
        return -np.divide(self.residual_stress, self.buckling_stress) * self.held

    @property
    def most_stress(self) -> Value:
        """Residual stress, MPa, above which there is no second stable shape."""
        Q, plain = self.bistability, self.is_cosine
        least = least_compression_of_cosine(Q)
        if not plain.all():
            least = np.where(plain, least, least_compression(Q, self.cosines))
        return -least * self.buckling_stress / self.held

    @property
    def height(self) -> Value:
        """Midpoint of the first stable shape, um: the rise, unless there is residual stress."""
        share = self._at_rest(1, first_force)
        return np.where(np.equal(self.residual_stress, 0), self.rise, self.made_rise * share)[()]

    @property
    def second_equilibrium(self) -> Value:
        """Midpoint of the second stable shape of a guided beam, um; NaN if it has none.

        Of a cosine without residual stress w2 = -rise (1 + sqrt(1 - 16 / (3 Q^2))) / 2.
        """
        ratio = BISTABILITY_LIMIT / self.bistability
        with np.errstate(invalid="ignore"):
            made = -self.rise * (1 + np.sqrt(1 - ratio * ratio)) / 2
        share = self._at_rest(-1, second_force)
        closed = self.is_cosine & np.equal(self.residual_stress, 0)
        return np.where(closed, made, self.made_rise * share)[()]

    def _at_rest(self, side, force):
        """w(L/2)/rise on one side, 1 or -1; force: gives the axial force there for any shape."""
        Q, compression, plain = self.bistability, self.compression, self.is_cosine
        share = cosine_at_rest(Q, compression, side)
        if plain.all():
            return share
        a = self.cosines
        other = np.where(
            self.is_bistable | (side > 0), midpoint(a, force(Q, compression, a)), np.nan
        )
        return np.where(plain, share, other)

    @property
    def stays_if_free(self) -> bool | np.ndarray:
        """Whether the second shape of a perfect beam is stable against tilting."""
        share = self.second_equilibrium / self.made_rise
        # The axial force there is N_1 (1 - 1/share).
        stays, plain = 1 - 1 / share < TILT, self.is_cosine
        if plain.all():
            return stays
        force = second_force(self.bistability, self.compression, self.cosines)
        return np.where(plain, stays, force < TILT)[()]


@dataclass(frozen=True)
class Device:
    """Beam, and a mass on a spring that strikes it; a value that cannot be raises ValueError.

    mass: ng; 0 with a gap of math.inf for a beam alone
    spring, contact: uN/um; contact = math.inf is a hard contact
    gravity: the unit of the shock's amplitude N, um/us^2
    force: the unit of N, uN, where the pulse is a force on the midpoint of a beam alone, downward,
        and 0 where it is an acceleration of the frame
    gap: between mass and midpoint at rest, um
    stop_toward, stop_away: way of the mass from rest to a rigid stop, towards the beam and away
        from it, um; math.inf for none
    restitution: share of its speed with which the mass leaves a stop, 0 to 1
    temperature: at which the other values hold, degC; `vary` takes it to others
    reference_temperature: at which they were given, degC
    modulus_slope: change of Young's modulus over itself, 1/K
    expansion_mismatch: thermal expansion of the beam less that of what it is clamped to, 1/K
    damper_exponent: C grows with the absolute temperature to this power
    strength: tensile stress at which the beam breaks, MPa, math.inf for never; or the scale of a
        Weibull distribution of it, with strength_modulus and strength_threshold, MPa
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

    def __post_init__(self):
        alone = np.equal(self.mass, 0) & self.is_alone
        _require_from_zero("device.gap", np.where(alone, 0.0, self.gap))
        _require_from_zero("device.force", self.force)
        pushed = "device.force: {:g} uN is of a beam alone; write mass: none"
        _require(alone | np.equal(self.force, 0), pushed, self.force)
        stopped = "device.stops: are of a mass, and there is none; leave them out"
        _require(~(alone & self.has_stops), stopped)
        for key in ("toward", "away"):
            way = getattr(self, STOPS[key])
            _require(np.greater(way, 0), f"device.stops.{key}: {{}} is not a positive number", way)
        for key in ("scale", "modulus"):
            value = getattr(self, STRENGTH[key])
            _require(np.greater(value, 0), f"device.strength.{key}: {{}} is not positive", value)
        _require_from_zero("device.strength.threshold", self.strength_threshold)
        share = np.greater_equal(self.restitution, 0) & np.less_equal(self.restitution, 1)
        _require(share, "device.stops.restitution: {} is not from 0 to 1", self.restitution)
        for key, name in (
            ("temperature", "temperature"),
            ("thermal.reference", THERMAL["reference"]),
        ):
            value = getattr(self, name)
            _require(
                np.greater(value, -ZERO), f"device.{key}: {{}} degC is not above -273.15", value
            )
        _require_positive("device.mass", np.where(alone, 1.0, self.mass))
        for name in ("spring", "gravity"):
            _require_positive(f"device.{name}", getattr(self, name))
        stiff = "device.contact: {} is not a positive number or inf"
        _require(np.greater(self.contact, 0), stiff, self.contact)

    @property
    def own_frequency(self) -> Value:
        """The lower of the mass's own, sqrt(spring / mass), and the beam's first, rad/us.

        A light mass, or one on a stiff spring, rests on a beam that snaps by its own inertia.
        """
        return np.minimum(self.mass_frequency, self.beam.bending_frequency)

    @property
    def mass_frequency(self) -> Value:
        """The mass's own, sqrt(spring / mass), rad/us; inf without a mass."""
        with np.errstate(divide="ignore"):
            return np.sqrt(np.divide(self.spring, self.mass))

    @property
    def is_alone(self) -> bool | np.ndarray:
        """Whether no mass ever meets the beam."""
        return np.isinf(self.gap)

    @property
    def has_stops(self) -> bool | np.ndarray:
        """Whether the mass meets a stop on either side."""
        return np.isfinite(self.stop_toward) | np.isfinite(self.stop_away)

    @property
    def damper_factor(self) -> Value:
        """C at the device's temperature over that at the reference."""
        if not np.any(self.damper_exponent):
            return np.ones(np.shape(self.temperature))[()]
        ratio = np.add(self.temperature, ZERO) / np.add(self.reference_temperature, ZERO)
        return np.vectorize(float.__pow__)(ratio, self.damper_exponent)[()]

    def __len__(self) -> int:
        """Number of devices in a batch; 1 for a single device."""
        return int(np.size(self.mass))

    def pick(self, which: int | np.ndarray) -> "Device":
        """One device of a batch, or a batch of some: indices, or a mask, (devices,)."""
        values = asdict(self)
        return _from_values({**values.pop("beam"), **values}, lambda value: value[which])

    def vary(self, values: Mapping[str, np.ndarray]) -> "Device":
        """The same devices but for some values, each (devices,), by their names in VALUES.

        Where the temperature is among them, the others are those at the reference.
        """
        whole = asdict(self)
        return _from_values({**whole.pop("beam"), **whole, **self.warmed(values)}, np.asarray)

    def warmed(self, values: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """Values for `vary`, with the modulus and the stress at the temperature among them.

        E = E0 (1 + slope dT),  stress = stress0 - E0 mismatch dT
        """
        if "temperature" not in values:
            return values
        # ASSUME: all else stays as it is: expansion moves sizes by some 1e-4.
        here = self.temperature - self.reference_temperature
        there = values["temperature"] - self.reference_temperature
        own = self.beam.youngs_modulus / (1 + self.modulus_slope * here)
        relaxed = self.beam.residual_stress + own * self.expansion_mismatch * here
        modulus = values.get("youngs_modulus", own)
        stress = values.get("residual_stress", relaxed)
        return {
            **values,
            "youngs_modulus": modulus * (1 + self.modulus_slope * there),
            "residual_stress": stress - modulus * self.expansion_mismatch * there,
        }


BEAM_VALUES = tuple(field.name for field in fields(Beam))
SIZES = BEAM_VALUES[:6]
COSINES = tuple(key for key in BEAM_VALUES if key.startswith("cosine_"))
"""What may be added to the shape, in order."""
_NAMES = (*BEAM_VALUES, *(field.name for field in fields(Device)))
# The axis `shape` is the pulse's.
_NUMBERS = [key for key in _NAMES if key in QUANTITIES and key != "shape"]
VALUES = tuple(key for key in _NUMBERS if QUANTITIES[key].long_name)
"""Names of the values that tell one device from another."""
SIGNED = tuple(key for key in VALUES if KINDS[QUANTITIES[key].kind].signed)
FROM_ZERO = tuple(key for key in VALUES if KINDS[QUANTITIES[key].kind].zero and key not in SIGNED)
"""Those that may be negative, or zero; all others are positive."""


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
    kind = {"shape": str}
    whole = {key: np.array([one[key] for one in columns], kind.get(key, float)) for key in keys}
    return _from_values(whole, np.asarray)


def is_bistable(device: Device, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """Whether the beam with other values, each (size,), has a second stable shape; (size,)."""
    values = asdict(device.beam) | device.warmed(values)
    beam = _Unchecked(**{key: values[key] for key in BEAM_VALUES})
    return np.broadcast_to(beam.is_bistable, (size,))


class _Unchecked(Beam):
    """One that may have no second stable shape."""

    def __post_init__(self):
        pass


def _from_values(values, convert):
    beam = {key: convert(values[key]) for key in BEAM_VALUES}
    rest = {key: convert(value) for key, value in values.items() if key not in beam}
    found = Device(beam=Beam(**beam), **rest)
    found.beam.require_second_shape()
    return found


def _require_positive(key, value):
    holds = np.greater(value, 0) & np.less(value, np.inf)
    _require(holds, f"{key}: {{}} is not a positive, finite number", value)


def _require_from_zero(key, value):
    holds = np.greater_equal(value, 0) & np.less(value, np.inf)
    _require(holds, f"{key}: {{}} is not 0 or a positive number", value)


def _require(holds, complaint, *values):
    """Raise ValueError with the first values for which it does not hold."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))

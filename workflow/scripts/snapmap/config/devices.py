"""The sections of a device in a config, and the function that reads a device alone."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import PrivateAttr, ValidationError, create_model

from ..beam.modal import natural_frequency
from ..device.argument import ExistingPath
from ..device.curved_beam import COSINES
from ..device.device import ALONE, VALUES, Beam, Device
from ..device.quantities import QUANTITIES, keys_of
from .keys import Section, either, lines_of, many, part, path, quantity, word
from .measured_shape import read_shape
from .yaml_file import ConfigError, read_document

AS_MEASURED = 0.1
"""Largest relative difference of span and rise from those of a measured shape."""
LEAST_TILT = 1e-6
"""Tilt of a measured shape, um, below which it is only rounding."""


class ShapeSection(Section):
    """The shape of the beam as made, {cosines: [...]} or {file: ...}."""

    cosines: many(
        quantity("part"),
        "a list of up to 5 amplitudes of 1 - cos(2 n pi x/L), scaled to the rise",
        out="`file`",
        least=1,
    )
    file: path("a measured shape, CSV: x (um) and w (um), from clamp to clamp", out="`cosines`")

    def make(self) -> None:
        """Raise ValueError unless one of the two keys is written."""
        if len(self.given) != 1 or len(self.cosines or ()) > len(COSINES) + 1:
            raise ValueError("write one of cosines, up to 5, and file")


class ValuesSection(Section):
    """Values of the device."""

    at: ClassVar[str]
    """Path of the section below `device`."""

    def values(self) -> dict[str, float]:
        """Give the values that are written, by their names in the device."""
        names = keys_of(self.at)
        return {names[key]: value for key, value in self.given.items() if key in names}


def section_of(at: str, **kinds: str) -> type[ValuesSection]:
    """Make the section at a path below `device`, with a key for each value that stands there.

    kinds: kinds of values by name, where they differ from those of axes (QUANTITIES)
    """
    fields = {}
    for key, name in keys_of(at).items():
        of = QUANTITIES[name]
        fields[key] = quantity(kinds.get(name, of.kind), of.what, of.example, of.default)
    section = create_model("Values", __base__=ValuesSection, **fields)
    section.at = at
    return section


class ClampSection(section_of("beam.clamp")):
    """Stiffness of the clamps."""


class BeamSection(section_of("beam", rise="distance")):
    """Dimensions and material of the beam."""

    known_as = "device.beam"
    shape: part(ShapeSection, out="a cosine")
    clamp: part(ClampSection, out="rigid")
    guide: word("guided", "free", what="a free beam can tilt", out="`guided`")
    quality_factor: quantity(
        "quality",
        "quality factor of the first symmetric mode; replaces `damping`",
        out="`damping`",
    )

    _measured: str = PrivateAttr("")

    def make(self) -> Beam:
        """Make the beam."""
        free = self.guide == "free"
        if self.has("imperfection") and not free:
            raise ValueError(".imperfection: needs a beam free to tilt; write guide: free")
        if self.has("quality_factor") and self.has("damping"):
            raise ValueError(".quality_factor: replaces damping; write one of them")
        clamp = self.clamp.values() if self.clamp else {}
        beam = Beam(**self.values() | clamp | self._of_shape(free), free=float(free))
        if not self.has("quality_factor"):
            return beam
        # ASSUME: the factor is that of the first symmetric mode, of the beam clear of the mass. All
        # modes have the same drag: their quality factors are in proportion to their frequencies.
        return replace(beam, damping=natural_frequency(beam) / self.quality_factor)

    @property
    def measured(self) -> str:
        """One line on a shape that was read from a file, or an empty one."""
        return self._measured

    def _of_shape(self, free):
        """Give the values that the shape sets, by name."""
        if not self.shape:
            return {}
        cosines, tilt = self.shape.cosines, {}
        if file := self.shape.file:
            measured = read_shape(file)
            self._measured = f"{file}: {measured.words}"
            cosines = measured.cosines
            for name, size in (("span", measured.length), ("rise", measured.rise)):
                written = getattr(self, name)
                if not abs(size - written) < AS_MEASURED * written:
                    where = f"{written:g} um, where {file} has {size:.4g} um"
                    raise ValueError(f".{name}: {where}; is a unit wrong?")
            if free and not self.has("imperfection") and measured.tilt > LEAST_TILT:
                tilt = {"imperfection": measured.tilt}
        if beside := next((name for name in COSINES if self.has(name)), None):
            raise ValueError(f".{beside}: repeats the cosines of shape; write one of them")
        rise = sum(cosines[::2])
        if not rise > 0:
            raise ValueError(f".shape.cosines: the odd ones add up to {rise:g}, not above 0")
        return tilt | dict(zip(COSINES, (cosine / rise for cosine in cosines[1:]), strict=False))


class StopsSection(section_of("stops")):
    """Travel of the mass from rest up to a stop."""


class ThermalSection(section_of("thermal")):
    """How modulus, stress and C depend on the temperature."""


class StrengthSection(section_of("strength")):
    """A Weibull distribution of strengths."""


class DeviceSection(section_of("", mass="body")):
    """The beam, the mass on its spring, and what they meet."""

    known_as = "device"
    beam: part(BeamSection)
    stops: part(StopsSection, out="the mass travels freely")
    thermal: part(ThermalSection, out="they do not")
    strength: either(
        StrengthSection,
        quantity("strength"),
        "a stress at which the beam breaks, or a mapping: a Weibull distribution",
        example="1.5 GPa, {scale: 3 GPa, modulus: 10}",
        out="the beam never breaks",
    )
    quality_factor: quantity(
        "quality",
        "quality factor of mass and spring; replaces `sweep.C`",
        "94",
        "`sweep.C`",
    )

    @classmethod
    def beside(cls, device: Mapping) -> dict[tuple, str]:
        """Find keys that a device lacks, or has too many, with a mass or without one."""
        alone, pushed, needs = device.get("mass") == "none", "force" in device, cls.needs()
        needed = [] if alone else ["spring", "contact"]
        if not pushed:
            needed.append("gravity")
        faults = {name: f"missing; write {needs[name]}" for name in needed if name not in device}
        if alone:
            extra = [*(name for name in ALONE if name != "mass"), "stops", "quality_factor"]
            line = "needs a mass; leave it out"
            faults |= {name: line for name in extra if name in device}
        if pushed and "gravity" in device:
            faults["gravity"] = "excludes force, as N counts multiples of either; write one of them"
        return {(name,): line for name, line in faults.items()}

    def make(self) -> Device:
        """Make the device at its reference temperature; other temperatures are an axis."""
        values = {"gravity": 1.0, **self.values(), **(ALONE if self.mass == 0 else {})}
        for section in (self.stops, self.thermal, self.strength):
            if isinstance(section, ValuesSection):
                values |= section.values()
            elif section:
                values["strength"] = section
        if "reference_temperature" in values:
            values["temperature"] = values["reference_temperature"]
        return Device(beam=self.beam.made, **values)

    @property
    def C(self) -> float | None:
        """Damping of the mass by its quality factor, uN us/um; None without such a factor."""
        if self.mass == 0:
            return 0.0
        if not self.has("quality_factor"):
            return None
        return float(np.sqrt(self.spring * self.mass) / self.quality_factor)


RARE_LAST = sorted(VALUES, key=lambda name: QUANTITIES[name].left_out is not None)
"""Names of all values of the device; those that may be left out come last."""


def of_device(make, names=RARE_LAST):
    """Make a section with a key for each value of the device; make: makes one of name and kind."""
    fields = {name: make(name, QUANTITIES[name].kind) for name in names}
    return create_model("OfDevice", __base__=Section, **fields)


def load_device(path: ExistingPath) -> Device:
    """Read the device of a config file; other sections of the file are ignored.

    A warning gives the C (uN us/um) of a mass with a `quality_factor`. An invalid file raises
    ConfigError.

    >>> snapmap.load_device("config/config.yaml").beam.thickness
    2.0
    """
    document = read_document(path)
    if "device" not in document:
        raise ConfigError(f"device: missing; write {DeviceSection.what()}")
    section = _section(document["device"])
    lines = [f"device, {section.beam.measured}"] if section.beam.measured else []
    if section.has("quality_factor"):
        lines.append(
            f"device.quality_factor: is C = {section.C:.6g} uN*us/um; pass this C to each function"
        )
    for line in lines:
        warnings.warn(line, stacklevel=3)
    return section.made


def read_device(section: Mapping) -> Device:
    """Make the device of a section of a config; raises ConfigError."""
    return _section(section).made


def _section(device):
    try:
        return DeviceSection.model_validate(device)
    except ValidationError as error:
        raise ConfigError(*lines_of(error, "device")) from None


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """Give the device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device

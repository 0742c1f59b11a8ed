"""The devices of a config."""

import warnings
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from ..beam.cosines import buckling_shapes
from ..beam.equilibria import find_barrier, least_travel
from ..device import Beam, Device
from .keys import lines_of
from .models import DeviceSection
from .yaml_file import ConfigError, read_document

TILTING = 8
"""Shapes of each kind by which it is told whether a free beam has a second one."""


def load_device(path: str | Path) -> Device:
    """Read the device of a config file, whatever its other sections; raises ConfigError.

    Its `quality_factor` stands for a C, which is no value of the device: a warning says which.

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
            f"device.quality_factor: stands for C = {section.C:.6g} uN*us/um; give it to each call"
        )
    for line in lines:
        warnings.warn(line, stacklevel=3)
    return section.made


def read_device(section: Mapping) -> Device:
    """The device of a section of a config; raises ConfigError."""
    return _section(section).made


def _section(given):
    try:
        return DeviceSection.model_validate(given)
    except ValidationError as error:
        raise ConfigError(*lines_of(error, "device")) from None


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """The device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device


def tilting(beam: Beam) -> str:
    """One line on what a beam that is guided, or free to tilt, means for its labels, or nothing."""
    if not beam.free and not beam.stays_if_free:
        ratio = beam.rise / beam.thickness
        return (
            f"rise/thickness = {ratio:.4g}: labels hold for a guided beam only; one free to tilt "
            "does not stay in the second shape"
        )
    if beam.free and find_barrier(beam, buckling_shapes(TILTING)).energy == 0:
        return (
            "free to tilt, the beam has no stable second shape: a snap is the midpoint's first "
            "arrival where a guided beam has its own, and nothing latches"
        )
    return ""


def stopped(device: Device) -> str:
    """One line on stops that leave the mass no room to snap the beam, or nothing."""
    if not device.has_stops:
        return ""
    way, needed = device.stop_toward, least_travel(device)
    if way <= device.gap:
        return f"stops.toward: {way:.4g} um is not beyond the gap; the mass never meets the beam"
    if way < needed:
        return (
            f"stops.toward: {way:.4g} um is short of the saddle, {needed:.4g} um from rest: a slow "
            "push does not snap the beam, and a fast one only by the speed that it gives the beam"
        )
    return ""


def pushed(device: Device) -> str:
    """One line on what N counts of a beam that is pushed at its midpoint, or nothing."""
    if not device.force:
        return ""
    return (
        f"N counts {device.force:g} uN of force on the midpoint, wherever multiples of g are named"
    )


def unwarmed(device: Device) -> str:
    """One line on a device of which a temperature changes nothing."""
    if device.modulus_slope or device.expansion_mismatch or device.damper_exponent:
        return ""
    return "temperature: changes nothing without device.thermal; write its coefficients there"

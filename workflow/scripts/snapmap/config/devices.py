"""The sections of a device in a config, and the function that reads a device alone."""

import warnings
from collections.abc import Mapping
from dataclasses import KW_ONLY, fields, replace
from os import PathLike
from typing import Annotated

import numpy as np

from ..beam.modal import natural_frequency
from ..device.curved_beam import BEAM_VALUES, COSINES
from ..device.device import OF_MASS, Beam, Device
from ..values.faults import Faults
from ..values.kinds import Fitting, kind_of
from ..values.quantities import ExistingPath, Quality
from ..values.records import assemble, read, record
from .kinds import Amplitudes, StudyPath
from .measured_shape import read_shape
from .yaml_file import read_document

AS_MEASURED = 0.1
"""Largest relative difference of span and rise from those of a measured shape."""
LEAST_TILT = 1e-6
"""Tilt of a measured shape, um, below which it is only rounding."""


@record
class Shape:
    """The shape of the beam as made, {cosines: [...]} or {file: ...}."""

    cosines: Amplitudes | None = None
    """amplitudes of 1 - cos(2 n pi x/L), up to 5, scaled to the rise"""
    file: StudyPath | None = None
    """a measured shape, CSV: x (um) and w (um), from clamp to clamp"""

    def __post_init__(self):
        """Raise ValueError unless one of the two is there."""
        if (self.cosines is None) == (self.file is None):
            raise ValueError("write one of cosines, up to 5, and file")


@record
class BeamSection(Beam):
    """Dimensions and material of the beam."""

    _: KW_ONLY
    shape: Shape | None = None
    """shape as made; a cosine if left out"""
    quality_factor: Quality | None = None
    """quality factor of the first symmetric mode; replaces `damping`"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find values that exclude each other."""
        if "quality_factor" in written and "damping" in written:
            return {"quality_factor": "replaces damping; write one of them"}
        if "shape" in written:
            twice = dict.fromkeys(COSINES, "repeats the cosines of shape; write one of them")
            return {key: line for key, line in twice.items() if key in written}
        return {}

    def __post_init__(self):
        """Set what the shape sets; ValueError for values that do not fit each other."""
        object.__setattr__(self, "measured", "")
        vars(self).update(self._of_shape())
        super().__post_init__()

    @property
    def made(self) -> Beam:
        """The beam."""
        beam = assemble(Beam, {key: getattr(self, key) for key in BEAM_VALUES})
        if self.quality_factor is None:
            return beam
        # ASSUME: the factor is that of the first symmetric mode, of the beam clear of the mass. All
        # modes have the same drag: their quality factors are in proportion to their frequencies.
        return replace(beam, damping=natural_frequency(beam) / self.quality_factor)

    def _of_shape(self):
        """Give the values that the shape sets, by name, and a line on a measured one."""
        if not self.shape:
            return {}
        cosines, further = self.shape.cosines, {}
        if file := self.shape.file:
            try:
                measured = read_shape(file)
            except ValueError as error:
                raise ValueError(f"shape.file: {error}") from None
            further["measured"] = f"{file}: {measured.words}"
            cosines = measured.cosines
            for name, size in (("span", measured.length), ("rise", measured.rise)):
                written = getattr(self, name)
                if not abs(size - written) < AS_MEASURED * written:
                    where = f"{written:g} um, where {file} has {size:.4g} um"
                    raise ValueError(f"{name}: {where}; is a unit wrong?")
            if self.free and not self.imperfection and measured.tilt > LEAST_TILT:
                further["imperfection"] = measured.tilt
        rise = sum(cosines[::2])
        if not rise > 0:
            raise ValueError(f"shape.cosines: the odd ones add up to {rise:g}, not above 0")
        return further | dict(zip(COSINES, (x / rise for x in cosines[1:]), strict=False))


@record
class DeviceSection(Device):
    """The beam, the mass on its spring, and what they meet."""

    beam: BeamSection
    """dimensions and material of the beam"""
    _: KW_ONLY
    quality_factor: Quality | None = None
    """quality factor of mass and spring; replaces `sweep.C`"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find values that a device lacks, or has too many, with a mass or without one."""
        faults = super().beside(written)
        if written.get("mass") == "none":
            extra = [key for key in (*OF_MASS, "quality_factor") if key in written]
            faults |= dict.fromkeys(extra[1:], "needs a mass; leave it out")
        if "force" in written and "gravity" in written:
            line = "excludes force, as N counts multiples of either; write one of them"
            faults["gravity"] = line
        return faults

    @property
    def made(self) -> Device:
        """The device."""
        values = {field.name: getattr(self, field.name) for field in fields(Device)}
        return assemble(Device, values | {"beam": self.beam.made})

    @property
    def C(self) -> float | None:
        """Damping of the mass by its quality factor, uN us/um; None without such a factor."""
        if self.mass == 0:
            return 0.0
        if self.quality_factor is None:
            return None
        return float(np.sqrt(self.spring * self.mass) / self.quality_factor)


def _is_source(value):
    return isinstance(value, Mapping) or kind_of(ExistingPath).fits(value)


_SOURCE = Fitting("the path of a file that is there, or a mapping of a device", _is_source)
Source = Annotated[str | PathLike | Mapping, _SOURCE]


def load_device(source: Source) -> Device:
    """Read the device of a config.

    Parameters
    ----------
    source
        Path of a config, whose other sections are ignored, or its section `device` as a mapping.

    Returns
    -------
    Device
        The device. A warning gives the C (uN us/um) of a mass with a `quality_factor`.

    Raises
    ------
    ValueError
        A line for each fault of the section.

    Examples
    --------
    >>> snapmap.load_device("config/config.yaml").beam.thickness
    2.0
    """
    is_section = isinstance(source, Mapping)
    document = {"device": source} if is_section else read_document(source)
    if "device" not in document:
        raise Faults("device: missing; write a mapping: the beam, the mass and what they meet")
    section = read(DeviceSection, document["device"], "device")
    lines = [f"device, {section.beam.measured}"] if section.beam.measured else []
    if section.quality_factor is not None:
        lines.append(
            f"device.quality_factor: is C = {section.C:.6g} uN*us/um; pass this C to each function"
        )
    for line in lines:
        warnings.warn(line, stacklevel=3)
    return section.made


def read_device(section: Mapping) -> Device:
    """Make the device of a section of a config; raises Faults."""
    return read(DeviceSection, section, "device").made


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """Give the device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device

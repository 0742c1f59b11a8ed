"""The sections of a device in a config, its measured shape, and how a device alone is read."""

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, fields, replace
from os import PathLike
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from ..beam.modal import natural_frequency
from ..device.curved_beam import BEAM_VALUES, COSINES
from ..device.device import OF_MASS, Beam, Device
from ..device.shape import TERMS, TILT
from ..files.named import naming, read_named
from ..files.tables import read_table
from ..numerics.linalg import apply, dot, multiply, solve
from ..numerics.portable import sine
from ..values.faults import Faults, warn
from ..values.kinds import Fitting, kind_of
from ..values.quantities import ExistingPath, Quality
from ..values.records import assemble, read, record
from .kinds import Amplitudes, StudyPath
from .yaml_file import read_document

MOST = 20_000
LEAST = 20
PROFILE = 2_000_000, f"write at most {MOST} points"
"""Most bytes of a file with a shape, and the remedy for more, as `read_named` takes both."""
LENGTHS = {"um": 1.0, "µm": 1.0, "μm": 1.0, "nm": 1e-3, "mm": 1e3, "m": 1e6}
FARTHEST = 0.1
"""Largest distance of the fit from the points, rms over the rise, that a clamped beam may have."""


class Measured(NamedTuple):
    """Cosines that fit a measured shape, beside a straight line for its inclination; all in um.

    cosines: amplitudes of (1 - cos(2 n pi x/L))/2
    tilt: largest displacement in the first antisymmetric shape
    rms, most: distance of the points from the fit
    points: number of points; length: distance of the last from the first
    """

    cosines: list[float]
    tilt: float
    rms: float
    most: float
    points: int
    length: float

    @property
    def rise(self) -> float:
        """Height of the midpoint over the clamps."""
        return sum(self.cosines[::2])

    @property
    def words(self) -> str:
        """A line on how well the cosines fit what was read."""
        return (
            f"{TERMS} cosines fit {self.points} points to {self.rms:.2g} um (rms), "
            f"{self.most:.2g} um at most; rise {self.rise:.4g} um, tilt {self.tilt:.2g} um"
        )


def read_shape(path: str | Path) -> Measured:
    """Read a measured shape; raises ValueError, one line, with file and fault.

    path: CSV with two columns, whose header has their units, as `x (um),w (um)`; rows are points
        from clamp to clamp, in any order
    """
    with naming(path):
        content = read_named(path, *PROFILE)
        x, w = read_table(content, {"x": LENGTHS, "w": LENGTHS}, most=MOST).values()
        if x.size < LEAST:
            raise ValueError(f"has {x.size} points; write {LEAST} or more")
        if not np.ptp(x) > 0:
            raise ValueError("has all points at one x; write points from clamp to clamp")
        length = float(np.ptp(x))
        measured = _fit((x - x.min()) / length, w, length)
        if not measured.rms <= FARTHEST * measured.rise:
            raise ValueError(
                f"differs by {measured.rms:.3g} um (rms) from {TERMS} cosines of a rise of "
                f"{measured.rise:.3g} um; write w along one beam, from clamp to clamp"
            )
        return measured


def _fit(x, w, length):
    """Fit by least squares a line, the cosines and the first antisymmetric shape, `psi_1`."""
    mu = 2 * math.pi * math.sqrt(TILT)
    half = sine(mu / (4 * math.pi))
    tilted = [sine(mu * s / (2 * math.pi)) / half - 2 * s for s in (x - 0.5).tolist()]
    columns = np.column_stack(
        [
            *(np.ones(x.size), x - 0.5),
            [[(1 - sine(n * s + 0.25)) / 2 for n in range(1, TERMS + 1)] for s in x.tolist()],
            mu / (4 * math.pi) * np.array(tilted),
        ]
    )
    fit = solve(multiply(columns.T, columns), apply(columns.T, w))
    residual = w - apply(columns, fit)
    rms, most = math.sqrt(dot(residual, residual) / x.size), float(np.abs(residual).max())
    cosines = (fit[2:-1] * math.copysign(1.0, fit[2])).tolist()  # also if drawn upside down
    tilt = abs(float(fit[-1]))
    return Measured(cosines, tilt=tilt, rms=rms, most=most, points=x.size, length=length)


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

    elsewhere = dict.fromkeys(BEAM_VALUES, "; write it under beam")
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
    if section.beam.measured:
        warn(f"device, {section.beam.measured}")
    if section.quality_factor is not None:
        warn(
            f"device.quality_factor: is C = {section.C:.6g} uN*us/um; pass this C to each function"
        )
    return section.made


def read_device(section: Mapping) -> Device:
    """Make the device of a section of a config; raises Faults."""
    return read(DeviceSection, section, "device").made


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """Give the device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device

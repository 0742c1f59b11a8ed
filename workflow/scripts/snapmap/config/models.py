"""The sections of a config: their keys, what these hold, and what a key left out stands for."""

import re
from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import Field, PrivateAttr, create_model

from ..arguments import OPTIONS, Argument
from ..axes import COORDINATES, axis_behind
from ..beam.modal import damped
from ..curved_beam import COSINES
from ..device import (
    ALONE,
    CLAMP,
    REFERENCE,
    RESTITUTION,
    STOPS,
    STRENGTH,
    THERMAL,
    VALUES,
    Beam,
    Device,
)
from ..io.measured_shape import read_shape
from ..io.named import sha256_of
from ..io.recorded import RECORD
from ..io.tables import ROWS, read_points
from ..pulse import DIRECTIONS, SHAPES, SHARES, VERSED_SINE
from ..quantities import KINDS, QUANTITIES
from ..shape import COSINE
from ..shape import SHAPES as AS_MADE
from ..shocks import MAKERS, Shocks, make_shocks
from ..solver.adaptive import TOLERANCE
from ..solver.settings import THRESHOLD_TOLERANCE, Settings
from ..spectra.psd import REACH, Spectrum
from ..spectra.srs import check_points
from ..tolerances.samples import INDEX_SAMPLES, OF_DEVICE, SHOCK_FACTORS, Tolerances
from ..tolerances.samples import KINDS as SPREADS
from .keys import (
    Section,
    argument,
    axis,
    either,
    flag,
    key,
    many,
    part,
    path,
    quantity,
    word,
    words,
)
from .shocks import Requirement, SpectrumTest, Vibration
from .units import read, show
from .views import HANDOUT_CASE, MOST_MAPS

AS_MEASURED = 0.1
"""By how much span and rise may differ from a measured shape's, relative."""
LEAST_TILT = 1e-6
"""Of a measured shape, um; below it there is none but rounding."""
TIMED = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and last as long as they last."""
OF_SPECTRA = {"psd": ("duration", "probability"), "srs": ("direction",)}
"""What may stand beside a spectrum."""
LEVELS = {"psd": ("density", "g^2/Hz", "0.04"), "srs": ("level", "g", "1500")}
"""What a spectrum has at its frequencies: name, unit and an example."""
# ASSUME: of devices whose strengths scatter all but one in a thousand must survive.
SURVIVES = 0.999
_DRAWN = Tolerances._field_defaults
SHAPE = word(*SHAPES, out=f"`{VERSED_SINE}`")
SHARE = quantity("share", "of the duration, in which a trapezoid rises, or falls", "10 %", "`10 %`")


def _within(section, error):
    """An error of a part, whose line names it as from without, as one within it."""
    return ValueError(str(error).removeprefix(section).removeprefix(": "))


class ShapeSection(Section):
    """Of the beam as made: one of the two."""

    cosines: many(
        quantity("part"),
        "a list of up to 5 numbers, of 1 - cos(2 n pi x/L) each; the midpoint keeps the rise",
        out="`file`",
        least=1,
    )
    file: path("a measured shape, CSV: x (um) and w (um), from clamp to clamp", out="`cosines`")

    def make(self) -> None:
        """Name anything but one of the two."""
        if len(self.given) != 1 or len(self.cosines or ()) > len(COSINES) + 1:
            raise ValueError("write one of cosines, up to 5, and file")


class ClampSection(Section):
    """What the clamps give."""

    axial: quantity("stiffness", "of each clamp along the beam", "20 kN/m")


def _cosine(n):
    return quantity("part", QUANTITIES[f"cosine_{n}"].long_name, out="`0`")


class BeamSection(Section):
    """Dimensions and material of the beam."""

    span: quantity("length", "clamp to clamp")
    rise: quantity("distance", "of the midpoint, as made; 0 if straight, for compression", "10 um")
    shape: either(
        ShapeSection,
        word(*AS_MADE),
        f"one of {', '.join(AS_MADE)}, or a mapping of cosines or file",
        example="arc, {cosines: [1, 0.1]}, {file: shape.csv}",
        out=f"`{COSINE}`",
    )
    clamp: part(ClampSection, out="rigid")
    thickness: quantity("length", "in the direction of motion", "2 um")
    depth: quantity("length", "out of the plane of motion", "22 um")
    youngs_modulus: quantity("modulus")
    density: quantity("density")
    damping: quantity("rate", "drag over momentum; swings decay at half of it", out="`0 /us`")
    quality_factor: quantity(
        "quality",
        "in place of damping, of the first symmetric mode about the rest; axes and tolerances "
        "leave the damping as it is",
        out="`damping`",
    )
    residual_stress: quantity(
        "stress", "along the beam before it bends to relieve it, tension > 0", out="`0 MPa`"
    )
    guide: word("guided", "free", what="free, it may tilt", out="`guided`")
    imperfection: quantity(
        "distance",
        "largest displacement, as made, in the first antisymmetric shape of a free beam",
        "0.01 um",
        "required if `guide` is `free`",
    )
    cosine_2: _cosine(2)
    cosine_3: _cosine(3)
    cosine_4: _cosine(4)
    cosine_5: _cosine(5)

    _measured: str = PrivateAttr("")

    def make(self) -> Beam:
        """The beam."""
        free = self.guide == "free"
        if self.has("imperfection") and not free:
            raise ValueError(".imperfection: is of a free beam; write guide: free")
        if self.has("quality_factor") and self.has("damping"):
            raise ValueError(".quality_factor: stands beside damping; write one of them")
        apart = "guide", "shape", "clamp", "quality_factor"
        values = {name: value for name, value in self.given.items() if name not in apart}
        values |= _by_name(self.clamp, CLAMP) | self._of_shape(free)
        try:
            beam = Beam(**values, free=float(free))
            damp = self.has("quality_factor")
            return damped(beam, self.quality_factor) if damp else beam
        except ValueError as error:
            raise _within("device.beam", error) from None

    @property
    def measured(self) -> str:
        """One line on a shape that was read from a file, or nothing."""
        return self._measured

    def _of_shape(self, free):
        """The values that the shape sets."""
        if not isinstance(self.shape, ShapeSection):
            return {"shape": self.shape} if self.shape else {}
        terms, tilt = self.shape.cosines, {}
        if file := self.shape.file:
            measured = read_shape(file)
            self._measured = f"{file}: {measured.words}"
            terms = measured.cosines
            for name, has in (("span", measured.length), ("rise", measured.rise)):
                own = getattr(self, name)
                if not abs(has - own) < AS_MEASURED * own:
                    where = f"{own:g} um, where {file} has {has:.4g} um"
                    raise ValueError(f".{name}: {where}; is a unit wrong?")
            if free and not self.has("imperfection") and measured.tilt > LEAST_TILT:
                tilt = {"imperfection": measured.tilt}
        if beside := next((name for name in COSINES if self.has(name)), None):
            raise ValueError(f".{beside}: stands beside the cosines of shape; write one")
        rise = sum(terms[::2])
        if not rise > 0:
            raise ValueError(f".shape.cosines: the odd ones add up to {rise:g}; write more")
        return tilt | dict(zip(COSINES, (term / rise for term in terms[1:]), strict=False))


class StopsSection(Section):
    """How far the mass travels from rest, either way, up to a stop."""

    toward: quantity("length", "from rest to the stop towards the beam", "14 um", "none there")
    away: quantity("length", "from rest to the stop away from the beam", "6 um", "none there")
    restitution: quantity(
        "restitution", "share of the speed kept at a stop", "0.7", f"`{RESTITUTION:g}`"
    )


class ThermalSection(Section):
    """What the axis temperature does to the modulus, the stress and C."""

    reference: quantity("temperature", "of all other values", "20 degC", f"`{REFERENCE:g} degC`")
    modulus: quantity("expansion", "of Young's modulus over itself", out="`0`")
    mismatch: quantity("expansion", "expansion of the beam less its frame's", "2.3e-6 /K", "`0`")
    damping: quantity("exponent", "C grows with this power of the temperature in K", out="`0`")


class StrengthSection(Section):
    """A Weibull distribution of the stress at which beams break."""

    scale: quantity("strength", "at this much over the threshold 63 % break", "3 GPa")
    modulus: quantity("quality", "the larger, the less the strengths differ", "10")
    threshold: quantity("strength", "up to which none breaks", "1.446 GPa", "`0 MPa`")


def _by_name(section, names):
    """What a section of a device says, by the device's own names."""
    return {names[name]: value for name, value in section.given.items()} if section else {}


class DeviceSection(Section):
    """The beam, the mass on its spring, and what they meet."""

    beam: part(BeamSection)
    mass: quantity(
        "body",
        "of the body that strikes the beam; none is a beam alone, without spring, contact, gap, "
        "stops and C",
        "1e-8 kg, none",
    )
    spring: quantity("stiffness", "what holds the mass", out="required, unless `mass` is none")
    contact: quantity(
        "contact", "where mass touches beam; or hard", "40 N/m, hard", "required, as the spring"
    )
    gap: quantity("distance", "between mass and midpoint at rest", "1 um", "`0 um`")
    stops: part(StopsSection, out="the mass travels freely")
    thermal: part(ThermalSection, out="an axis temperature changes nothing")
    strength: either(
        StrengthSection,
        quantity("strength"),
        "a stress at which the beam breaks, or a mapping of a Weibull distribution",
        example="1.5 GPa, {scale: 3 GPa, modulus: 10}",
        out="the beam never breaks",
    )
    quality_factor: quantity(
        "quality",
        "in place of sweep.C, of the mass on its spring, clear of the beam; axes and tolerances "
        "leave C as it is",
        "94",
        "`sweep.C`",
    )
    gravity: quantity("acceleration", "the unit of N", out="required, or `force`")
    force: quantity(
        "force",
        "on the midpoint of a beam alone: the unit of N, of pulses that push there and do not "
        "shake the frame",
        out="`gravity`",
    )

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """Name what a device lacks, or has too much of, with a mass and without one."""
        alone, pushed = given.get("mass") == "none", "force" in given
        needed = [*([] if alone else ["spring", "contact"]), *([] if pushed else ["gravity"])]
        needs = cls.needs()
        said = {name: f"missing; write {needs[name]}" for name in needed if name not in given}
        if alone:
            extra = [*ALONE, "stops", "quality_factor"]
            extra = [name for name in extra if name in given and name != "mass"]
            said |= dict.fromkeys(extra, "is of the mass, and there is none; leave it out")
        if pushed and "gravity" in given:
            said["gravity"] = "stands beside force; N counts multiples of one of them"
        return {(name,): line for name, line in said.items()}

    def make(self) -> Device:
        """The device at its reference: its temperature is an axis."""
        apart = "beam", "stops", "strength", "thermal", "quality_factor"
        values = {name: value for name, value in self.given.items() if name not in apart}
        thermal = _by_name(self.thermal, THERMAL)
        if "reference_temperature" in thermal:
            thermal["temperature"] = thermal["reference_temperature"]
        weibull = isinstance(self.strength, StrengthSection)
        strength = {"strength": self.strength} if self.strength else {}
        values |= ALONE if self.mass == 0 else {}
        values |= _by_name(self.stops, STOPS) | thermal
        values |= _by_name(self.strength, STRENGTH) if weibull else strength
        try:
            return Device(**{"gravity": 1.0, "beam": self.beam.made, **values})
        except ValueError as error:
            raise _within("device", error) from None

    @property
    def C(self) -> float | None:
        """Of the mass, uN us/um; None without a quality factor."""
        if self.mass == 0:
            return 0.0
        if not self.has("quality_factor"):
            return None
        return float(np.sqrt(self.spring * self.mass) / self.quality_factor)


class ModelSection(Section):
    """How a cell is simulated."""

    name: word(*OPTIONS)
    elements: argument("model.elements", "on the half beam", out="`5`")
    cosines: argument("model.cosines", "symmetric", out="as many as `modes`")
    modes: argument(
        "model.modes",
        "of the beam's own to keep",
        out="`5` cosines; of elements all, with hard contact three quarters",
    )
    mass_matrix: argument("model.mass_matrix", out="`consistent`")
    tolerance: quantity(
        "share", "error of the threshold that auto may make", out=f"`{100 * TOLERANCE:g} %`"
    )
    step: argument(
        "model.step",
        "one for every question, over the stability limit of central differences in linear bending",
        out="of `reference` `0.8`; elsewhere as question, pulse and device require",
    )


class Blow(Section):
    """A blow {shape, N, duration, rise, fall}, {wait: a time}, or {repeat: a number}."""

    shape: SHAPE
    rise: SHARE
    fall: SHARE
    N: quantity("number", "the peak over those of others", "2", "`1`")
    duration: quantity("pulse", out="`wait` or `repeat`, alone")
    wait: quantity("pulse", out="none")
    repeat: argument("pulse.repeat", "how often all before it comes in all", out="once")


class Drop(Section):
    """A free fall, its blow, and every flight and blow of the rebound."""

    height: quantity("length", "of the free fall", "1 m")
    duration: quantity("pulse", "of each blow")
    shape: SHAPE
    rise: SHARE
    fall: SHARE
    rebound: quantity("number", "velocity after a blow over before, 0 to 0.99", "0.3", "`0`")


class SineSweep(Section):
    """A sine whose frequency goes from one to another, logarithmically."""

    start: Annotated[quantity("frequency", example="20 Hz"), Field(alias="from")]
    stop: Annotated[quantity("frequency", example="2 kHz"), Field(alias="to")]
    duration: quantity("pulse", example="10 s")


def _shapes(value):
    several = value if isinstance(value, list | tuple) else [value]
    known = all(isinstance(one, str) and one in SHAPES for one in several)
    return known and 0 < len(several) == len(set(several))


class PulseSection(Section):
    """The shock: a shape, or a file, train, drop or sweep."""

    shape: argument(
        Argument(f"one of {', '.join(SHAPES)}, or a list of these, which then is an axis", _shapes),
        example="half sine, [half sine, sawtooth]",
        out=f"`{VERSED_SINE}`",
    )
    rise: SHARE
    fall: SHARE
    file: path("a recorded shock in the study's folder, CSV or UFF", out="`shape`")
    train: many(
        Blow,
        "a list of blows {shape, N, duration, rise, fall}, {wait: a time} and {repeat: how often "
        "all before it comes in all}",
        "[{duration: 0.5 ms}, {wait: 20 ms}, {repeat: 5}]",
        "`shape`",
        least=1,
    )
    drop: part(Drop, out="`shape`")
    sweep: part(SineSweep, out="`shape`")
    direction: word(
        *(*DIRECTIONS, "both"), what="+z presses the mass on the beam; both are an axis", out="`+z`"
    )

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """Name what stands beside a shock that is more than a shape."""
        if timed := next((name for name in TIMED if name in given), None):
            others = [name for name in ("shape", *SHARES, *TIMED) if name != timed]
            said = [name for name in others if name in given]
            return {(name,): f"stands beside {timed}; write one of them" for name in said}
        return {}

    def values(self) -> dict:
        """What `make_shocks` takes, with the SHA-256 of a file."""
        names = [*PulseSection.model_fields]
        values = self.model_dump(include=names, exclude_unset=True, by_alias=True)
        try:
            return values | ({"sha256": sha256_of(self.file, *RECORD)} if self.file else {})
        except ValueError as error:
            raise ValueError(f".file: {error}") from None

    def make(self) -> Shocks:
        """The shocks."""
        try:
            return make_shocks(self.values())
        except ValueError as error:
            raise _within("pulse", error) from None


def _one_time(given, lasts_itself=False, at=()):
    """Name f0 and duration beside each other, or neither of them."""
    if "f0" in given and "duration" in given:
        return {(*at, "duration"): "is one over f0, which is there, too; write one of them"}
    if "f0" in given or "duration" in given or lasts_itself:
        return {}
    return {(*at, "f0"): "missing; write frequencies (1/time), or duration"}


def frequency_of(duration: float) -> float:
    """Hz, of a pulse of so many us, to 14 digits: 0.5 ms is 2000 Hz."""
    return float(f"{1e6 / duration:.14g}")


def _points(name, what, example):
    """Pairs of a spectrum."""
    quantity_of, unit, such = LEVELS[name]

    def level(value):
        number, _, own = str(value).strip().partition(" ")
        if own.replace("²", "^2").replace("**", "^") != unit:
            raise ValueError(
                f"{show(value)} is no {quantity_of}; write one such as '{such} {unit}'"
            )
        return read(number, "number")

    pair = tuple[quantity("frequency"), key(level, quantity_of)]
    need = f"a list of two pairs or more of a frequency and a {quantity_of}, ascending, {what}"
    return many(pair, need, example, "one shock", least=2)


def _title(value):
    return isinstance(value, str) and re.fullmatch(r"[^\W_][\w .,:()/%+-]{0,59}", value) is not None


def _survival(value):
    return SURVIVES * value if isinstance(value, bool) else read(value, "share")


class RequirementSection(PulseSection):
    """A shock, with its name, N and time, that must or must not trip the device; or a spectrum."""

    name: argument(
        Argument("a name of its own: letters, digits, spaces, .,:()/%+-_, at most 60", _title)
    )
    N: quantity("number", "above 0", out="required, but of a drop or with `psd`, `srs`")
    snaps: flag("whether the device must trip")
    survives: key(
        _survival,
        "true, false or a share: whether a beam that has a strength must stay whole",
        example="99.99 %",
        out=f"`true`, which asks for `{100 * SURVIVES:g} %`",
    )
    f0: quantity(
        "frequency", out="required, or `duration`, or a shock or spectrum that lasts itself"
    )
    duration: quantity("pulse", "instead of f0", out="`f0`")
    shape: SHAPE
    psd: _points(
        "psd",
        "instead of N: random vibration over the duration",
        "[[20 Hz, 0.01 g^2/Hz], [2000 Hz, 0.04 g^2/Hz]]",
    )
    srs: _points(
        "srs",
        "instead of N: a shock response spectrum (quality factor 10)",
        "[[100 Hz, 100 g], [1000 Hz, 1500 g], [10 kHz, 1500 g]]",
    )
    probability: quantity(
        "share",
        "how likely vibration may trip the device, or miss it",
        "1 %",
        f"`{100 * REACH:g} %`",
    )
    direction: word(*DIRECTIONS, what="+z presses the mass on the beam", out="`+z`")

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """Name what stands beside a spectrum, or lacks with it or without one."""
        spectrum = next((name for name in OF_SPECTRA if name in given), None)
        if spectrum is None:
            return super().beside(given) | _one_time(given, any(name in given for name in TIMED))
        known = "name", "snaps", spectrum, *OF_SPECTRA[spectrum]
        others = [name for name in cls.model_fields if name in given and name not in known]
        faults = {(name,): f"stands beside {spectrum}; leave it out" for name in others[-1:]}
        if not faults and spectrum == "psd" and "duration" not in given:
            faults["duration",] = "missing; write a time such as '3 min'"
        return faults

    def make(self) -> Requirement | Vibration | SpectrumTest:
        """What is required."""
        points = [list(pair) for pair in self.psd or self.srs or ()]
        try:
            if self.psd:
                Spectrum(points)
            elif self.srs:
                check_points(points)
        except ValueError as error:
            raise ValueError(f".{error}") from None
        if self.psd:
            chance = self.probability or REACH
            return Vibration(self.name, points, 1e-6 * self.duration, self.snaps, chance)
        if self.srs:
            return SpectrumTest(self.name, points, self.direction or "+z", self.snaps)
        shocks = super().make()
        N = self.N if self.has("N") else shocks.pulse.own_N
        if N is None:
            raise ValueError(f".N: missing; write {self.needs()['N']}")
        if not N > 0:
            raise ValueError(f".N: {N:g} is not above 0; a direction of -z pushes the other way")
        f0 = frequency_of(self.duration) if self.duration else self.f0
        survives = self.survives if self.has("survives") else SURVIVES
        f0 = f0 or shocks.own_frequency()
        return Requirement(self.name, self.values(), N, f0, self.snaps, survives)


RARE_LAST = sorted(VALUES, key=lambda name: QUANTITIES[name].left_out is not None)
"""Values of the device."""


def _of_device(make, names=RARE_LAST):
    """A section with a key for each value of the device."""
    fields = {name: make(name, QUANTITIES[name].kind) for name in names}
    return create_model("OfDevice", __base__=Section, **fields)


_Axes = _of_device(lambda _, kind: axis(kind, "in place of the device's", out="the device's own"))


class SweepSection(_Axes):
    """The axes N, f0 (or duration), C and any value of the device; how each cell is followed."""

    N: axis("number", "the shock's peak over gravity", "{from: 600, to: 2400, points: 91}")
    f0: axis(
        "frequency",
        "one over the shock's duration",
        "{from: 100 Hz, to: 30 kHz, points: 31, spacing: log}",
        "required, or `duration`, or a pulse that has its own",
    )
    duration: axis("pulse", "of the shock, instead of f0", "[0.3 ms, 0.5 ms]", "`f0`")
    C: axis(
        "damper",
        "on the mass",
        "[0.025 uN*us/um, 25 uN*us/um]",
        "required, or `device.quality_factor`, or no mass",
    )
    not_bistable: word(
        *("refuse", "skip"), what="if no second shape is stable; skip marks absent", out="`refuse`"
    )
    horizon: quantity("duration", "for which a cell is followed after the pulse's end")
    until: argument(
        "until", "a cell is followed until its well is proven, or its snap", out="`settled`"
    )
    repeat: flag(
        "whether each cell is run again with another step", out="`true` where `until` is `settled`"
    )
    energy_tolerance: argument(
        "energy_tolerance",
        "the share of the pulse's work by which a believed run's energy ledger may miss",
        out=f"`{Settings().energy_tolerance:g}`",
    )
    threshold_tolerance: argument(
        "tolerance", "of thresholds in N, relative", out=f"`{THRESHOLD_TOLERANCE:g}`"
    )

    def make(self) -> Settings:
        """How each cell is followed."""
        names = "horizon", "until", "repeat", "energy_tolerance"
        given = {name: self.given[name] for name in names if self.has(name)}
        return Settings(**{"repeat": self.until in (None, "settled"), **given})


def _scatter(name, kind, example=""):
    """A width, or a mapping of its kind to one; a share stays text."""

    def width(given):
        if isinstance(given, str) and given.strip().endswith("%"):
            return f"{100 * read(given, 'share'):.12g} %"
        if name in SHOCK_FACTORS:
            raise ValueError(f"{show(given)} is no share; write one such as '5 %'")
        try:
            return read(given, kind)
        except ValueError as error:
            share = f", or a share such as '{given} %'" if isinstance(given, int | float) else ""
            raise ValueError(f"{error}{share}") from None

    def convert(given):
        if not isinstance(given, Mapping):
            return width(given)
        if len(given) != 1 or next(iter(given)) not in SPREADS:
            raise ValueError(f"{show(given)} is not of one of {', '.join(SPREADS)}, with its width")
        return {spread: width(value) for spread, value in given.items()}

    value = "" if name in SHOCK_FACTORS else " or a value"
    need = f"a standard deviation, as a share{value}, or a mapping of its kind to such a width"
    return key(convert, need, example=example, out="it does not scatter")


class TolerancesSection(_of_device(_scatter, OF_DEVICE)):
    """What scatters from device to device, or from shock to shock.

    Kinds are normal, uniform (half the width), lognormal, and truncated at two standard deviations.
    """

    C: _scatter("C", "", "10 %")
    N: _scatter("N", "", "2 %")
    duration: _scatter("duration", "", "{uniform: 5 %}")
    together: argument(
        "together",
        "each moved by one draw",
        example="[[thickness, depth]]",
        out="each value by a draw of its own",
    )
    samples: argument("samples", "devices that are drawn", out=f"`{_DRAWN['samples']}`")
    index_samples: argument(
        "index_samples",
        "of those by which the Sobol indices are estimated; cut down to a power of two",
        out=f"`{INDEX_SAMPLES}`, or `samples` if these are fewer",
    )
    seed: argument("seed", "of the draws", out=f"`{_DRAWN['seed']}`")

    def make(self) -> Tolerances:
        """What scatters."""
        options = {name: self.given[name] for name in Tolerances._fields if self.has(name)}
        scatters = {name: width for name, width in self.given.items() if name not in options}
        made = Tolerances(scatters, **options)
        if (made.index_samples or 0) > made.samples:
            most = f"is more than samples, {made.samples}"
            raise ValueError(f".index_samples: {made.index_samples} {most}")
        return made


def _span(name, kind, example=""):
    """Where an unknown is looked for."""
    pair = tuple[quantity(kind), quantity(kind)]
    need = f"a pair of values: where it is looked for, each {KINDS[kind].name}"
    return Annotated[pair, words(need, "", example, "it is known")]


class UnknownsSection(_of_device(_span)):
    """One to four values of the device, or C, with the range of each."""

    C: _span("C", "damper", "[1 uN*us/um, 100 uN*us/um]")


class CalibrationSection(Section):
    """Shots that were measured, and what is read off them."""

    shots: path(
        "a table in the study's folder, CSV: columns N, f0 (Hz) or duration (ms), tripped (yes, "
        "no) and, if wanted, direction, shape, file (a recorded shock), unit (a specimen's name)",
        "shots.csv",
    )
    unknowns: part(UnknownsSection)
    C: quantity(
        "damper", "of the shots", out="that of `sweep`, if it is one value, unless it is unknown"
    )


_Values = _of_device(
    lambda _, kind: quantity(kind, "in place of the device's", out="the device's own")
)


class CellSection(_Values):
    """A cell whose time history is drawn."""

    N: quantity("number")
    f0: quantity("frequency", out="required, or `duration`")
    duration: quantity("pulse", "instead of f0", out="`f0`")
    C: quantity("damper")
    device: argument(
        Argument("the name of one of the devices", lambda name: isinstance(name, str)),
        out="the first",
    )

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """One of f0 and duration is there."""
        return _one_time(given)


AXES = [name for name in QUANTITIES if axis_behind(name) in COORDINATES]


def _axis_name(what, *but):
    need = f"the name of an axis{' but '.join(['', *but])}"
    return argument(Argument(need, lambda value: value in AXES and value not in but), what)


_PLACE = Annotated[
    dict[str, object],
    words(
        "a mapping of axes to where on them to look; the nearest value is taken",
        out="where the device itself stands; else in the middle, and for maps no N",
    ),
]


class MapSection(Section):
    """A map over two axes that differ."""

    x: _axis_name("to the right")
    y: _axis_name("upward; without N the thresholds are drawn")
    at: _PLACE


class LinesSection(Section):
    """A figure of thresholds over two axes that differ."""

    x: _axis_name("to the right", "N")
    lines: _axis_name("a line for each value", "N")
    at: _PLACE


def _own_points(file):
    """Path and SHA-256 of a table of points, all in order."""
    sha256 = sha256_of(file, *ROWS)
    read_points(file, sha256)
    return file, sha256


class Document(Section):
    """Device (or devices), model and sweep; if wanted, what else is made of them."""

    device: part(DeviceSection, out="required, or `devices`")
    devices: Annotated[
        dict[object, DeviceSection],
        words("a mapping of devices by name, which are an axis", out="`device`", min_length=1),
    ]
    model: part(ModelSection)
    pulse: part(PulseSection, out="a versed sine along +z")
    requirements: many(
        RequirementSection, "a list of shocks that must or must not trip the device", out="none"
    )
    sweep: part(SweepSection)
    tolerances: part(TolerancesSection, out="every device is as drawn")
    calibration: part(CalibrationSection, out="none")
    histories: many(
        CellSection,
        "a list of cells {N, f0 or duration, C} whose time history is drawn",
        out="the cell nearest to N = {N:g}, f0 = {f0:g} Hz, C = {C:g} uN*us/um".format(
            **HANDOUT_CASE
        ),
    )
    maps: many(
        MapSection,
        "a list of maps {x, y, at} to draw",
        out=f"N over f0 for each point of the other axes, {MOST_MAPS} of them at most",
    )
    thresholds: many(
        LinesSection,
        "a list of figures {x, lines, at} of thresholds over an axis",
        out="over each axis of several values, lines for `device` or C",
    )
    marks: path(
        "a table in the study's folder, CSV, of shocks that maps of N over f0 show: columns N, "
        "f0 (Hz) or duration (ms) and, if wanted, name, snapped (yes, no)",
        "points.csv",
        "none",
        _own_points,
    )

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """What sections lack, or have too much of, by others."""
        faults, sweep, several = {}, given.get("sweep"), given.get("devices")
        if "device" not in given and "devices" not in given:
            faults["device",] = f"missing; write {cls.needs()['device']}"
        elif "device" in given and "devices" in given:
            faults["devices",] = "stand beside device; write one of them"
        several = several if isinstance(several, Mapping) else {}
        for name in several:
            if not (isinstance(name, str) and re.fullmatch("[A-Za-z][A-Za-z0-9_-]{0,30}", name)):
                need = "a name of letters, digits, - and _, at most 31 of them"
                faults["devices", name] = f"{show(name)} is not {need}"
        if isinstance(sweep, Mapping):
            pulse = given.get("pulse")
            itself = isinstance(pulse, Mapping) and any(name in pulse for name in TIMED)
            faults |= _one_time(sweep, itself, ("sweep",))
            faults |= _dampers(given, sweep, several)
        return faults

    def make(self) -> Device | dict[str, Device]:
        """The device, or several by name; names of requirements that come twice."""
        names = [one.name for one in self.requirements or ()]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(f".requirements: {show(twice)} comes twice; write another")
        if self.device:
            return self.device.made
        return {name: section.made for name, section in self.devices.items()}

    def devices_by_name(self) -> dict[str, DeviceSection]:
        """Their sections; one alone is called `device`."""
        return self.devices or {"device": self.device}


def _dampers(given, sweep, several):
    """C stands under sweep, or follows from the quality factor of each device."""
    at = {("devices", name): one for name, one in several.items()} or {
        ("device",): given.get("device")
    }
    at = {where: one for where, one in at.items() if isinstance(one, Mapping)}
    if at and all(one.get("mass") == "none" for one in at.values()):
        extra = {("sweep", "C"): "is of the mass, and there is none; leave it out"}
        return extra if "C" in sweep else {}
    factors = [(*where, "quality_factor") for where, one in at.items() if "quality_factor" in one]
    if "C" in sweep:
        return dict.fromkeys(factors, "stands beside sweep.C; write one of them")
    wanted = "dampers (force time per length) of the mass, or device.quality_factor"
    return {} if factors else {("sweep", "C"): f"missing; write {wanted}"}

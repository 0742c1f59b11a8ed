"""The shocks of a study, pulses, trains, drops and directions, of Python or of a config."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Annotated, NamedTuple

import numpy as np

from ..files.text import show
from ..values.faults import at_key, line_at
from ..values.kinds import Fitting, Whole
from ..values.quantities import Height, PulseTime, single
from ..values.records import build, record, told
from .pulse import (
    DIRECTIONS,
    SHAPES,
    SHARES,
    VERSED_SINE,
    Form,
    G,
    Pulse,
    ShapeName,
    make_pulse,
    read_pulse,
)

# ASSUME: a blow that ends with a jump returns to 0 along a line, in this share of its duration.
JOIN = 0.01
# ASSUME: rebounds below this share of the first impact's velocity are left out.
LEAST_REBOUND = 0.05
MOST_BLOWS = 100_000


_NUMBER = single("a plain number", "", "2", "(-inf, inf)")


def _peak(value):
    number = _NUMBER.take(value)
    if number == 0:
        raise ValueError("0 is no pulse; write a number above or below 0, or a wait")
    return number


Peak = Annotated[float, Fitting("a plain number", by=_peak, json={"type": "number"})]
Times = Annotated[int, Whole(1)]
Rebound = Annotated[float, single("a plain number", "", "0.3", "[0, 0.99]")]


@record
class Blow(Form):
    """A pulse {shape, N, duration, rise, fall}, {wait: a time}, or {repeat: a number}."""

    shape: ShapeName | None = None
    """how the acceleration goes over time; a versed sine, or for a requirement as in `pulse`, if
    left out"""
    _: KW_ONLY
    N: Peak = 1.0
    """peak relative to other pulses, below 0 for the other direction"""
    duration: PulseTime | None = None
    """duration of the pulse; required, except with `wait` or `repeat`"""
    wait: PulseTime | None = None
    """time without a pulse; alone in its item"""
    repeat: Times | None = None
    """how often the items before it occur in total; alone in its item"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find keys that exclude each other, or a duration that is missing."""
        for key in ("wait", "repeat"):
            if key in written and len(written) > 1:
                return {key: "stands alone in its item; write the others in an item of their own"}
        if not written.keys() & {"duration", "wait", "repeat"}:
            return {"duration": "missing; write a duration above 0"}
        return {}


@record
class Drop(Form):
    """A free fall, its impact, and the rebounds."""

    shape: ShapeName | None = None
    """how the acceleration of an impact goes over time; a versed sine, or for a requirement as in
    `pulse`, if left out"""
    _: KW_ONLY
    height: Height
    """height of the free fall"""
    duration: PulseTime
    """duration of each impact"""
    rebound: Rebound = 0.0
    """velocity after an impact over that before"""


class Part(NamedTuple):
    """A blow, or the wait or flight between two; its values are in units of N = 1.

    pieces: as in `numerics.pieces`, over time from the part's begin, us
    lasts: us; area: integral over time, us
    peak: 0 for a part that is no blow
    swing: duration of the fastest change, us
    """

    pieces: np.ndarray
    lasts: float
    peak: float = 0.0
    area: float = 0.0
    swing: float = math.inf


def make_train(items: Sequence[Blow | Mapping]) -> Pulse:
    """Make a pulse of blows; its peak is that of the blow with the largest one.

    Raises ValueError, one line, for other items or too many.
    """
    if isinstance(items, str | Mapping) or not isinstance(items, Sequence):
        raise ValueError(f".train: {show(items)} is not a list of pulses, waits and repeats")
    parts, section = [], []
    for place, item in enumerate(items):
        with at_key("train", place):
            item = build(Blow, item)
        section.append(told(item))
        if item.repeat is None:
            parts.append(_blow(item, item.N) if item.wait is None else _flat(item.wait, 0.0))
        elif len(parts) * item.repeat > MOST_BLOWS:
            more = f"makes over {MOST_BLOWS} pulses and waits; write fewer"
            raise ValueError(f".train[{place}].repeat: {more}")
        else:
            parts *= item.repeat
    return _joined("train", parts, section)


def make_drop(drop: Drop | Mapping) -> Pulse:
    """Make a pulse of a free fall from rest, a blow, and the flights and blows of its rebounds.

    A blow at velocity v changes it by (1 + rebound) v, from which its peak follows.
    Raises ValueError, one line, for another mapping or a blow below 1 g.
    """
    with at_key("drop"):
        drop = build(Drop, drop)
    rebound, velocity = drop.rebound, math.sqrt(2 * G * drop.height)
    peak = (1 + rebound) * velocity / _blow(drop).area
    if peak < G:
        line = f".drop: its impact has only {peak / G:.2g} g"
        raise ValueError(f"{line}; write a shorter duration")
    # In free fall the frame accelerates by -g; the jump at its end is small beside the blow.
    lasts, level, share = velocity / G, -G / peak, 1.0
    parts = [_flat(lasts, level), _blow(drop)]
    while (share := share * rebound) >= LEAST_REBOUND:
        parts += [_flat(2 * share * velocity / G, level), _blow(drop, share)]
    return replace(_joined("drop", parts, told(drop)), peak=peak)


def _blow(form, N=1.0):
    """Make a blow; if its shape ends with a jump, a line brings it back to 0."""
    pulse, duration = form.make(), form.duration
    pieces = pulse.pieces * [duration, N, N / duration, 1 / duration, N, N]
    area, jump, join = N * pulse.area * duration, N * pulse.ends[1], JOIN * duration
    if not jump:
        return Part(pieces, duration, abs(N), area, duration)
    pieces = np.vstack([pieces, [duration, jump, -jump / join, 0.0, 0.0, 0.0]])
    # Time steps as long as the line would miss a part of its area.
    return Part(pieces, duration + join, abs(N), area + jump * join / 2, 10 * join)


def _flat(lasts, value):
    """Make a part of constant value, in units of N = 1, that lasts so many us."""
    return Part(np.array([[0.0, value, 0.0, 0.0, 0.0, 0.0]]), lasts)


def _joined(name, parts, section):
    """Make a pulse of consecutive parts; its peak is their largest."""
    begins = np.cumsum([0.0, *(part.lasts for part in parts)])
    blows = np.array([part.peak > 0 for part in parts], bool)
    if not blows.any():
        raise ValueError(f".{name}: has no pulse; write one such as {{duration: 0.5 ms}}")
    lasts, peak = float(begins[-1]), max(part.peak for part in parts)
    pieces = np.vstack([part.pieces for part in parts])
    pieces[:, 0] += np.repeat(begins[:-1], [len(part.pieces) for part in parts])
    best = max(parts, key=lambda part: abs(part.area))
    alone = _scaled(best.pieces, best.lasts, peak)
    return Pulse(
        name,
        _scaled(pieces, lasts, peak),
        lasts,
        section={name: section},
        blows=begins[:-1][blows] / lasts,
        swing=min(part.swing for part in parts) / lasts,
        strongest=Pulse("blow", alone, best.lasts, swing=best.swing / best.lasts),
    )


def _scaled(pieces, lasts, peak):
    """Scale pieces over time, us, to pieces of a pulse, over x from 0 to 1 and with peak 1."""
    scaled = pieces * [1.0, 1 / peak, lasts / peak, lasts, 1 / peak, 1 / peak]
    scaled[:, 0] /= lasts
    return scaled


MAKERS = {"train": make_train, "drop": make_drop}
SECTION = {"shape", "file", *SHARES, *MAKERS}
"""Keys of a pulse."""
UNITS = {"duration": "us", "wait": "us", "height": "um"}
"""Units of values in that section; other values are shares or have no unit."""


@dataclass(frozen=True, eq=False)
class Shocks:
    """The pulses of a study and their directions; several of either are an axis.

    pulse: a pulse, or several by name
    direction: one of DIRECTIONS, or several
    """

    pulse: Pulse | Mapping[str, Pulse] = field(default_factory=make_pulse)
    direction: str | tuple[str, ...] = "+z"

    @property
    def shapes(self) -> dict[str, Pulse]:
        """All pulses by name, as before a direction is applied."""
        several = isinstance(self.pulse, Mapping)
        return dict(self.pulse) if several else {self.pulse.name: self.pulse}

    @property
    def directions(self) -> tuple[str, ...]:
        """All directions, also a single one."""
        return (self.direction,) if isinstance(self.direction, str) else self.direction

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Names along the axes `shape` and `direction`, where the study has them."""
        named = {"shape": self.pulse, "direction": self.direction}
        several = {key: names for key, names in named.items() if isinstance(names, Mapping | tuple)}
        return {key: np.array([*names]) for key, names in several.items()}

    @property
    def pulses(self) -> tuple[Pulse, ...]:
        """A pulse for each point of the axes, shapes first, with the sign of its direction."""
        return tuple(
            pulse if DIRECTIONS[direction] > 0 else pulse.reversed()
            for pulse in self.shapes.values()
            for direction in self.directions
        )

    def each(self) -> list["Shocks"]:
        """Split into shocks without axes, in the order of `pulses`."""
        return [
            Shocks(replace(pulse, name=name), direction)
            for name, pulse in self.shapes.items()
            for direction in self.directions
        ]

    def part(self, names: Mapping[str, Sequence[str]]) -> "Shocks":
        """Keep these names along the axes."""
        shapes = {name: self.pulse[name] for name in names.get("shape", ())}
        return Shocks(shapes or self.pulse, tuple(names.get("direction", ())) or self.direction)

    def first(self) -> "Shocks":
        """Keep the first shape in the first direction."""
        return Shocks(next(iter(self.shapes.values())), self.directions[0])

    def doubts(self, is_pressed: bool) -> list[str]:
        """Lines on records: their notes, and largest accelerations that pull the mass away.

        is_pressed: whether the mass is to press on the beam, as for a snap from the first shape
        """
        lines = [f"{pulse.name}: {note}" for pulse in self.shapes.values() for note in pulse.notes]
        for pulse in self.shapes.values():
            pushed = Shocks(pulse, self.direction).pulses
            if is_pressed and pulse.is_record and max(each.highest for each in pushed) < 1:
                other = next(way for way in DIRECTIONS if way not in self.directions)
                lines.append(
                    f"{pulse.name}: its largest acceleration pulls the mass away from the beam; "
                    f"if its sensor was mounted upside down, write direction: {other}"
                )
        return lines

    def own_frequency(self) -> float:
        """Return 1/duration, Hz, of shocks that last equally long; else ValueError, one line."""
        durations = {pulse.duration for pulse in self.shapes.values()}
        if durations == {None} or len(durations) > 1:
            raise ValueError("f0: missing; write frequencies in Hz, or a duration")
        return 1e6 / durations.pop()

    def values(self) -> dict:
        """Write what `make_shocks` reads, in internal units; {} for HANDOUT_SHOCK."""
        sections = {name: dict(pulse.section) for name, pulse in self.shapes.items()}
        values = sections if isinstance(self.pulse, Mapping) else dict(self.pulse.section)
        if values is sections and all(name in SHAPES for name in sections):
            shares = sections.get("trapezoid", {})
            values = {**shares, "shape": [*sections]}
        values = {} if values == {"shape": VERSED_SINE} else values
        if self.direction != "+z":
            both = self.directions == tuple(DIRECTIONS)
            values["direction"] = "both" if both else self.direction
        return values

    @property
    def files(self) -> dict[str, str]:
        """SHA-256 of each record that was read with one, by path."""
        sections = [pulse.section for pulse in self.shapes.values()]
        return {each["file"]: each["sha256"] for each in sections if "sha256" in each}

    def section(self) -> dict:
        """Write the section `pulse` of a config, with units; {} for HANDOUT_SHOCK."""
        section = _written(self.values())
        section.pop("sha256", None)
        return {"pulse": section} if section else {}


HANDOUT_SHOCK = Shocks()
"""A versed sine along +z, the default."""


def _pulses(value):
    """Make a pulse, or several by name."""
    if isinstance(value, list | tuple):
        pulses = [_pulse(section) for section in value]
        if not pulses or len({pulse.name for pulse in pulses}) < len(pulses):
            raise ValueError("write one shape or several, each once, or give them names")
        return {pulse.name: pulse for pulse in pulses}
    if isinstance(value, Mapping) and value and not value.keys() & SECTION:
        return {str(name): _pulse(section) for name, section in value.items()}
    if isinstance(value, Mapping) and isinstance(value.get("shape"), list):
        return {form["shape"]: _pulse(form) for form in each_form(value)}
    return _pulse(value)


def _directions(value):
    """Give one of DIRECTIONS, or several."""
    if value == "both":
        return tuple(DIRECTIONS)
    if isinstance(value, str) and value in DIRECTIONS:
        return value
    named = isinstance(value, list | tuple) and [*value]
    if not named or not {*map(str, named)} <= {*DIRECTIONS} or len({*named}) < len(named):
        raise _DIRECTIONS.refuse(value)
    return tuple(named)


_PULSES = Fitting(f"one of {', '.join(SHAPES)}, or what sampled or read_pulse makes", by=_pulses)
_DIRECTIONS = Fitting("+z, -z, both, or a list of these", by=_directions)
Pulses = Annotated[str | Pulse | Mapping | Sequence, _PULSES]
Directions = Annotated[str | Sequence[str], _DIRECTIONS]


def each_form(section: Mapping) -> list[dict]:
    """Give each shape of a section with its shares; without one a versed sine."""
    shares = {key: section[key] for key in SHARES if key in section}
    names = section.get("shape", VERSED_SINE)
    names = names if isinstance(names, list) else [names]
    # Shares belong to the trapezoid; without one the first shape refuses them.
    bearer = "trapezoid" if "trapezoid" in names else names[0]
    return [{"shape": name} | (shares if name == bearer else {}) for name in names]


def make_shocks(pulse=VERSED_SINE, direction="+z") -> Shocks:
    """Make shocks of `pulse` and `direction`; ValueError, one line.

    pulse: name of a shape; a `Pulse`; a mapping as the section `pulse` of a config, in internal
        units, such as {"train": ...}; or several as an axis, in a list or by names
    direction: "+z", "-z", several, or "both"; that of the mapping if it has one
    """
    if isinstance(pulse, Mapping) and "direction" in pulse:
        pulse, direction = dict(pulse), pulse["direction"]
        del pulse["direction"]
    pulse = VERSED_SINE if pulse == {} else pulse
    try:
        pulse = _PULSES.take(pulse)
    except ValueError as error:
        raise ValueError(line_at(("pulse",), str(error))) from None
    return Shocks(pulse, _DIRECTIONS.take(direction))


def _pulse(section):
    """Make a pulse of a section of a config or the name of a shape; leave a Pulse as it is."""
    if isinstance(section, Pulse):
        return section
    if isinstance(section, str) and section in SHAPES:
        return make_pulse(section)
    if not isinstance(section, Mapping):
        raise _PULSES.refuse(section)
    if "file" in section:
        with at_key("file"):
            return read_pulse(section["file"], section.get("sha256", ""))
    for key, make in MAKERS.items():
        if [*section] == [key]:
            return make(section[key])
    return build(Form, section).make()


def _written(section):
    """Write a section of a pulse, or a value in it, as in a config: with units."""
    if isinstance(section, list | tuple):
        return type(section)(map(_written, section))
    if not isinstance(section, Mapping):
        return section
    written = {key: _written(value) for key, value in section.items()}
    written |= {key: f"{section[key]:.15g} {unit}" for key, unit in UNITS.items() if key in section}
    return written | {key: f"{100 * section[key]:.15g} %" for key in SHARES if key in section}

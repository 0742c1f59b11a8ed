"""The section of the shock in a config."""

from collections.abc import Mapping

from ..device.argument import Argument
from ..files.named import sha256_of
from ..pulse.options import OF_PULSE
from ..pulse.pulse import DIRECTIONS, SHAPES, SHARES, VERSED_SINE
from ..pulse.recorded import RECORD, read_pulse
from ..pulse.shocks import MAKERS, Shocks, make_shocks
from .keys import Section, argument, many, part, path, quantity, word

TIMED = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and set their own duration."""
SHAPE = word(*SHAPES, out=f"`{VERSED_SINE}`")
SHARE = quantity("share", "part of the duration of a trapezoid", "10 %", "`10 %`")


class Blow(Section):
    """A blow {shape, N, duration, rise, fall}, {wait: a time}, or {repeat: a number}."""

    shape: SHAPE
    rise: SHARE
    fall: SHARE
    N: quantity("part", "peak relative to other blows", "2", "`1`")
    duration: quantity("pulse", out="`wait` or `repeat`, alone")
    wait: quantity("pulse", out="none")
    repeat: argument(OF_PULSE["repeat"], "how often all items before it occur", out="once")


class Drop(Section):
    """A free fall, its blow, and the rebounds."""

    height: quantity("length", "height of the free fall", "1 m")
    duration: quantity("pulse", "duration of each blow")
    shape: SHAPE
    rise: SHARE
    fall: SHARE
    rebound: quantity("part", "velocity after a blow over that before, 0 to 0.99", "0.3", "`0`")


def _shapes(value):
    names = value if isinstance(value, list | tuple) else [value]
    known = all(isinstance(name, str) and name in SHAPES for name in names)
    return known and 0 < len(names) == len(set(names))


def several_shapes(more, out):
    """Make the type of a key that has a shape, or a list of shapes."""
    shapes = Argument(f"one of {', '.join(SHAPES)}, {more}", _shapes)
    return argument(shapes, example="half sine, [half sine, sawtooth]", out=out)


PUSHES, PUSHED = (*DIRECTIONS, "both"), "+z presses the mass on the beam"
"""Values of a direction, and the meaning of the first."""


class PulseSection(Section):
    """The shock: a shape, or a file, train or drop."""

    known_as = "pulse"
    shape: several_shapes("or a list of these, each once, an axis", f"`{VERSED_SINE}`")
    rise: SHARE
    fall: SHARE
    file: path("a recorded shock in the study's folder, CSV", out="`shape`")
    train: many(
        Blow,
        "a list of blows {shape, N, duration, rise, fall}, {wait: a time} and {repeat: a number}",
        "[{duration: 0.5 ms}, {wait: 20 ms}, {repeat: 5}]",
        "`shape`",
        least=1,
    )
    drop: part(Drop, out="`shape`")
    direction: word(*PUSHES, what=f"{PUSHED}; both is an axis", out="`+z`")

    @classmethod
    def beside(cls, pulse: Mapping) -> dict[tuple, str]:
        """Find keys that a shock which sets its own duration excludes."""
        timed = next((name for name in TIMED if name in pulse), None)
        others = [key for key in ("shape", *SHARES, *TIMED) if key in pulse and key != timed]
        return {(key,): f"excludes {timed}; write one of them" for key in others if timed}

    def values(self) -> dict:
        """Give the values that are written, in internal units, with the SHA-256 of a file."""
        names = [*PulseSection.model_fields]
        values = self.model_dump(include=names, exclude_unset=True)
        try:
            return values | ({"sha256": sha256_of(self.file, *RECORD)} if self.file else {})
        except ValueError as error:
            raise ValueError(f".file: {error}") from None

    def make(self) -> Shocks:
        """Make the shocks."""
        return shocks_of(self.values())


def shocks_of(values: Mapping) -> Shocks:
    """Make the shocks of a section by its values, as `PulseSection.values` gives them."""
    if "file" in values:
        pulse = read_pulse(values["file"], values["sha256"])
        return make_shocks(pulse, values.get("direction", "+z"))
    return make_shocks(values)


def one_time(section, lasts_itself=False, at=()):
    """Find f0 and duration beside each other, or neither unless the shock sets its duration."""
    if "f0" in section and "duration" in section:
        return {(*at, "duration"): "excludes f0, which is 1/duration; write one of them"}
    if "f0" in section or "duration" in section or lasts_itself:
        return {}
    return {(*at, "f0"): "missing; write f0 or duration"}

"""The section of the shock, and those of shocks that must or must not trip the device."""

from collections.abc import Mapping

from ..applications.spectra.psd import REACH, Spectrum
from ..applications.spectra.srs import check_points
from ..device.argument import Argument
from ..files.named import sha256_of
from ..files.text import is_name
from ..pulse.pulse import (
    DIRECTIONS,
    SHAPES,
    SHARES,
    VERSED_SINE,
)
from ..pulse.recorded import RECORD, read_pulse
from ..pulse.shocks import MAKERS, Shocks, make_shocks
from ..solver.settings import FIRST, SECOND, STARTS
from ..study.study import ANY, CLOSING
from .keys import (
    Section,
    argument,
    key,
    many,
    part,
    path,
    quantity,
    word,
)
from .units import read, show
from .views import frequency_of

TIMED = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and last as long as they last."""
OF_SPECTRA = {"psd": ("duration", "probability"), "srs": ("direction",)}
"""What may stand beside a spectrum."""
LEVELS = {"psd": ("density", "g^2/Hz", "0.04"), "srs": ("level", "g", "1500")}
"""What a spectrum has at its frequencies: name, unit and an example."""
# ASSUME: of devices whose strengths scatter all but one in a thousand must survive.
SURVIVES = 0.999
SHAPE = word(*SHAPES, out=f"`{VERSED_SINE}`")
SHARE = quantity("share", "of the duration of a trapezoid", "10 %", "`10 %`")


class Blow(Section):
    """A blow {shape, N, duration, rise, fall}, {wait: a time}, or {repeat: a number}."""

    shape: SHAPE
    rise: SHARE
    fall: SHARE
    N: quantity("number", "the peak over those of others", "2", "`1`")
    duration: quantity("pulse", out="`wait` or `repeat`, alone")
    wait: quantity("pulse", out="none")
    repeat: argument("pulse.repeat", "how often all before it comes", out="once")


class Drop(Section):
    """A free fall, its blow, and the rebounds."""

    height: quantity("length", "of the free fall", "1 m")
    duration: quantity("pulse", "of each blow")
    shape: SHAPE
    rise: SHARE
    fall: SHARE
    rebound: quantity("number", "velocity after over before a blow, 0 to 0.99", "0.3", "`0`")


def _shapes(value):
    several = value if isinstance(value, list | tuple) else [value]
    known = all(isinstance(one, str) and one in SHAPES for one in several)
    return known and 0 < len(several) == len(set(several))


def _several_shapes(more, out):
    """One shape, or a list."""
    fits = Argument(f"one of {', '.join(SHAPES)}, {more}", _shapes)
    return argument(fits, example="half sine, [half sine, sawtooth]", out=out)


PUSHES, PUSHED = (*DIRECTIONS, "both"), "+z presses the mass on the beam"
"""Values of a direction, and what the first means."""


class PulseSection(Section):
    """The shock: a shape, or a file, train or drop."""

    known_as = "pulse"
    shape: _several_shapes("or a list of these, which then is an axis", f"`{VERSED_SINE}`")
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
    direction: word(*PUSHES, what=f"{PUSHED}; both are an axis", out="`+z`")

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """Name what stands beside a shock that is more than a shape."""
        if timed := next((name for name in TIMED if name in given), None):
            others = [name for name in ("shape", *SHARES, *TIMED) if name != timed]
            said = [name for name in others if name in given]
            return {(name,): f"stands beside {timed}; write one of them" for name in said}
        return {}

    def values(self) -> dict:
        """What it says, in internal units, with the SHA-256 of a file."""
        names = [*PulseSection.model_fields]
        values = self.model_dump(include=names, exclude_unset=True)
        try:
            return values | ({"sha256": sha256_of(self.file, *RECORD)} if self.file else {})
        except ValueError as error:
            raise ValueError(f".file: {error}") from None

    def make(self) -> Shocks:
        """The shocks."""
        return _shocks(self.values())


def _shocks(values):
    """Those of a section, by its values."""
    if "file" in values:
        pulse = read_pulse(values["file"], values["sha256"])
        return make_shocks(pulse, values.get("direction", "+z"))
    return make_shocks(values)


def one_time(given, lasts_itself=False, at=()):
    """Name f0 and duration beside each other, or neither of them."""
    if "f0" in given and "duration" in given:
        return {(*at, "duration"): "is one over f0, which is there, too; write one of them"}
    if "f0" in given or "duration" in given or lasts_itself:
        return {}
    return {(*at, "f0"): "missing; write frequencies (1/time), or duration"}


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
    need = f"a list of two pairs or more of a frequency and a {quantity_of}, ascending: {what}"
    return many(pair, need, example, "one shock", least=2)


def is_title(value: object) -> bool:
    """Whether it is a line that may stand in tables."""
    return isinstance(value, str) and len(value) <= 60 and is_name(value)


def _survival(value):
    return SURVIVES * value if isinstance(value, bool) else read(value, "share")


class RequirementSection(PulseSection):
    """A shock or spectrum that must, or must not, trip the device.

    It counts at each temperature of the sweep. Shape and direction that it leaves out are those of
    `pulse`; of several shapes or directions it counts under each.
    """

    name: argument(
        Argument("a name of its own: letters, digits, spaces, .,:()/%+-_, at most 60", is_title)
    )
    N: quantity("number", "above 0", out="required, but of a drop or with `psd`, `srs`")
    snaps: argument(
        Argument("true, false or any", lambda value: isinstance(value, bool) or value == ANY),
        "whether the device must trip; any: it may, or not",
    )
    survives: key(
        _survival,
        "true, false or a share: whether the beam must not break",
        example="99.99 %",
        out=f"`true`, that is `{100 * SURVIVES:g} %`",
    )
    closes_within: quantity(
        "pulse", "from its start until the beam is at contact_at", out="any time"
    )
    stays_closed: quantity("pulse", "until it opens again", out="any time")
    f0: quantity("frequency", out="required, or `duration`, or a shock with its own")
    duration: quantity("pulse", "instead of f0", out="`f0`")
    shape: _several_shapes("or a list of these, all of which count", "those of `pulse`")
    psd: _points(
        "psd",
        "random vibration",
        "[[20 Hz, 0.01 g^2/Hz], [2000 Hz, 0.04 g^2/Hz]]",
    )
    srs: _points(
        "srs",
        "a shock response spectrum (quality factor 10)",
        "[[100 Hz, 100 g], [1000 Hz, 1500 g], [10 kHz, 1500 g]]",
    )
    probability: quantity(
        "share",
        "that vibration may trip the device, or miss it",
        "1 %",
        f"`{100 * REACH:g} %`",
    )
    direction: word(*PUSHES, what=PUSHED, out="that of `pulse`")
    start: word(*STARTS, what="the shape in which the beam rests at first", out=f"`{FIRST}`")

    @classmethod
    def beside(cls, given: Mapping) -> dict[tuple, str]:
        """Name what stands beside a spectrum, or lacks with it or without one."""
        spectrum = next((name for name in OF_SPECTRA if name in given), None)
        if spectrum is None:
            return super().beside(given) | one_time(given, any(name in given for name in TIMED))
        known = "name", "snaps", spectrum, *OF_SPECTRA[spectrum]
        others = [name for name in cls.model_fields if name in given and name not in known]
        faults = {(name,): f"stands beside {spectrum}; leave it out" for name in others[-1:]}
        if not faults and spectrum == "psd" and "duration" not in given:
            faults["duration",] = "missing; write a time such as '3 min'"
        return faults

    def make(self) -> None:
        """Nothing by itself; ValueError for what cannot be in any study."""
        if self.has("N") and not self.N > 0:
            line = f".N: {self.N:g} is not above 0; a direction of -z pushes the other way"
            raise ValueError(line)
        try:
            if self.psd:
                Spectrum(self.points).require_record(1e-6 * self.duration)
            elif self.srs:
                check_points(self.points)
        except ValueError as error:
            raise ValueError(f".{error}") from None
        closing = [key for key in CLOSING if self.has(key)]
        if closing and (self.snaps is False or self.start == SECOND):
            more = ", and no start" if self.start else ""
            need = f"write snaps: true or any{more}"
            raise ValueError(f".{closing[0]}: is of a device that must trip; {need}")
        if self.snaps == ANY and (self.points or not (self.least_share or closing)):
            need = "" if self.points else ", or survives, closes_within or stays_closed"
            raise ValueError(f".snaps: any leaves nothing to check; write true or false{need}")

    @property
    def points(self) -> list[list[float]]:
        """Pairs of its spectrum, if it is one."""
        return [list(pair) for pair in self.psd or self.srs or ()]

    @property
    def least_share(self) -> float:
        """The least probability with which the beam must not break; 0 if it may."""
        return self.survives if self.has("survives") else SURVIVES

    def under(self, pulse: PulseSection | None) -> dict:
        """What is required: name, snaps and `shocks` with N and f0, or `psd`, or `srs`.

        pulse: the study's, whose shape and direction hold unless it has its own
        """
        required = {"name": self.name, "snaps": self.snaps}
        direction = self.direction or (pulse and pulse.direction) or "+z"
        if self.psd:
            over = {"duration": 1e-6 * self.duration, "probability": self.probability or REACH}
            return required | {"psd": self.points} | over
        if self.srs:
            return required | {"srs": self.points, "direction": direction}
        values = self.values()
        if not self.has("shape", *TIMED):
            values = self._inherited(pulse) | values
        values["direction"] = direction
        try:
            shocks = _shocks(values)
        except ValueError as error:
            raise ValueError(str(error).removeprefix("pulse")) from None
        own_N = [one.own_N for one in shocks.shapes.values()]
        N = self.N if self.has("N") else own_N[0]
        if N is None:
            raise ValueError(f".N: missing; write {self.needs()['N']}")
        f0 = frequency_of(self.duration) if self.duration else self.f0
        required |= {"N": N, "f0": f0 or shocks.own_frequency(), "shocks": shocks}
        closes = {name: self.given[name] for name in CLOSING if self.has(name)}
        required |= {"survives": self.least_share, "pulse": values} | closes
        return required | ({"start": self.start} if self.start == SECOND else {})

    @staticmethod
    def _inherited(pulse):
        """Shape and shares of the study's pulse, in internal units."""
        values = pulse.values() if pulse else {}
        if timed := next((name for name in TIMED if name in values), None):
            raise ValueError(
                f".shape: missing, as the study's pulse is a {timed} that lasts a time of its own; "
                f"write a shape such as half sine, or its {timed}"
            )
        return values

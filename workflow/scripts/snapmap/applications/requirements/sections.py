"""The section `requirements`: shocks that must, or must not, trip the device."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from ...config.keys import Section, argument, in_list, key, quantity, word
from ...config.shocks import (
    PUSHED,
    PUSHES,
    TIMED,
    PulseSection,
    one_time,
    several_shapes,
    shocks_of,
)
from ...config.units import read
from ...config.views import frequency_of
from ...device.argument import Argument
from ...files.text import is_title, show
from ...solver.settings import FIRST, STARTS
from ...study.study import ANY, ARRIVES, Study
from .required import Required, RequiredShock

# ASSUME: of devices whose strengths scatter all but one in a thousand must survive.
SURVIVES = 0.999
NAME = argument(
    Argument("a unique name of letters, digits, spaces, .,:()/%+-_, at most 60", is_title)
)
SNAPS = {
    ARRIVES: "it must arrive at its other shape, if only for a moment",
    ANY: "either is right",
}
"""What the words of `snaps` mean."""


def snaps(*words: str) -> object:
    """Make the key that tells whether a device must trip: true, false, or one of the words."""
    need = " or ".join([", ".join(["true", "false", *words[:-1]]), words[-1]])
    meanings = [f"`{word}`: {SNAPS[word]}" for word in words]
    what = "; ".join(["whether the device must trip and stay tripped", *meanings])
    fits = Argument(need, lambda value: isinstance(value, bool) or value in words)
    return argument(fits, what)


def _survival(value):
    return SURVIVES * value if isinstance(value, bool) else read(value, "share")


class ShockSection(PulseSection):
    """A shock that must, or must not, trip the device.

    A requirement holds at every temperature of the sweep. Its shape and direction are those of
    `pulse` unless it has its own; of several it holds under each.
    """

    kind: ClassVar = RequiredShock
    name: NAME
    N: quantity("number", "peak of the shock over gravity", out="required, but of a drop")
    snaps: snaps(ARRIVES, ANY)
    survives: key(
        _survival,
        "true, false or a share: whether, or how probably, the beam must not break",
        example="99.99 %",
        out=f"`true`, that is `{100 * SURVIVES:g} %`",
    )
    f0: quantity(
        "frequency",
        "1/duration of the shock",
        out="required, or `duration`, or a shock with its own",
    )
    duration: quantity("pulse", "duration of the shock; replaces f0", out="`f0`")
    shape: several_shapes("or a list of these, all of which count", "those of `pulse`")
    direction: word(*PUSHES, what=PUSHED, out="that of `pulse`")
    start: word(*STARTS, what="shape in which the beam rests at first", out=f"`{FIRST}`")

    @classmethod
    def beside(cls, written: Mapping) -> dict[tuple, str]:
        """Faults of keys that are missing or exclude each other, by their places."""
        return super().beside(written) | one_time(written, any(name in written for name in TIMED))

    def make(self) -> None:
        """Nothing by itself; ValueError for what cannot be in any study."""
        if self.has("N") and not self.N > 0:
            line = f".N: {self.N:g} is not above 0; a direction of -z pushes the other way"
            raise ValueError(line)
        if self.snaps == ANY and not (self.least_share or self.kind.more):
            need = "true or false, or survives"
            raise ValueError(f".snaps: any leaves nothing to check; write {need}")

    @property
    def least_share(self) -> float:
        """The least probability with which the beam must not break; 0 if it may."""
        return self.survives if self.has("survives") else SURVIVES

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredShock:
        """Make the requirement of a study.

        pulse: section of the study, whose shape and direction hold unless this section has its own
        gravity: of its devices, um/us^2, the unit of N
        """
        values = self.values()
        if not self.has("shape", *TIMED):
            values = self._inherited(pulse) | values
        values["direction"] = self.direction or (pulse and pulse.direction) or "+z"
        try:
            shocks = shocks_of(values)
        except ValueError as error:
            raise ValueError(str(error).removeprefix("pulse")) from None
        if not self.has("N") and not self.has("drop"):
            raise ValueError(f".N: missing; write {self.needs()['N']}")
        N = self.N if self.has("N") else shocks.pulse.peak / gravity
        f0 = frequency_of(self.duration) if self.duration else self.f0
        return self.kind(
            name=self.name,
            N=N,
            f0=f0 or shocks.own_frequency(),
            shocks=shocks,
            snaps=self.snaps,
            survives=self.least_share,
            start=self.start or FIRST,
            pulse=values,
        )

    @staticmethod
    def _inherited(pulse):
        """Values of the study's pulse, in internal units; ValueError if it sets its duration."""
        values = pulse.values() if pulse else {}
        if timed := next((name for name in TIMED if name in values), None):
            raise ValueError(
                f".shape: missing, as the study's {timed} sets its own duration; write a "
                f"shape such as half sine, or the {timed}"
            )
        return values


def requirement(kinds: Mapping[str, type[Section]]) -> object:
    """Make the type of an item of `requirements`; kinds: sections by a key that only they have."""

    def convert(value):
        kind = ShockSection
        if isinstance(value, Mapping):
            kind = next((kinds[key] for key in kinds if key in value), ShockSection)
        return kind.model_validate(value)

    return key(convert, ShockSection.what())


def read_requirements(
    sections: Sequence[Section], study: Study, pulse: PulseSection | None
) -> list[Required]:
    """Take the requirements of a config; raises ValueError, one line, for an invalid one.

    pulse: the study's section `pulse`, or None
    """
    from ...config.study import require_start  # which itself imports these sections

    names = [section.name for section in sections]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"{show(twice)} comes twice; write another name")
    gravity, requirements = float(next(iter(study.devices().values())).gravity), []
    for place, section in enumerate(sections):
        try:
            required = section.under(pulse, gravity)
            for device in study.devices().values():
                require_start(required.start, device)
        except ValueError as error:
            raise ValueError(in_list(place, str(error))) from None
        requirements.append(required)
    if requirements:
        temperatures = study.temperatures
        study.set_out({"temperature": temperatures} if temperatures else {})
    for required in requirements:
        required.require(study)
    return requirements

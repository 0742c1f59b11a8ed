"""The section of the shock in a config."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, fields
from typing import Annotated, Literal

from ..files.named import sha256_of
from ..pulse.pulse import DIRECTIONS, RECORD, SHAPES, SHARES, Form, ShapeName
from ..pulse.shocks import MAKERS, Blow, Drop, Shocks, make_shocks
from ..values.faults import at_key
from ..values.kinds import CONFIG, Fitting, kind_of
from ..values.records import record, told
from .kinds import StudyPath

TIMED = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and set their own duration."""


_NAME = kind_of(ShapeName)
_JSON = {"anyOf": [_NAME.schema(), {"type": "array", "items": _NAME.schema(), "minItems": 1}]}
_NEED = f"one of {', '.join(SHAPES)}, or a list of these, each once"


def _shapes(value):
    names = value if isinstance(value, list) else [value]
    for name in names:
        _NAME.convert(name, CONFIG)
    if not 0 < len(names) == len(set(names)):
        raise ValueError(f"{names} is not {_NEED}")
    return value


SeveralShapes = Annotated[str | list[str], Fitting(_NEED, by=_shapes, json=_JSON)]
Push = Literal[(*DIRECTIONS, "both")]


@record
class PulseSection(Form):
    """The shock: a shape, or a file, train or drop."""

    elsewhere = dict.fromkeys(("N", "f0", "duration", "C"), "; write it under sweep")
    _: KW_ONLY
    shape: SeveralShapes | None = None
    """how the acceleration goes over time; several are an axis; a versed sine if left out"""
    file: StudyPath | None = None
    """a recorded shock, CSV"""
    train: list[Blow] | None = None
    """pulses {shape, N, duration, rise, fall}, {wait: a time} and {repeat: a number}"""
    drop: Drop | None = None
    """a free fall, its impact, and the rebounds"""
    direction: Push | None = None
    """+z presses the mass on the beam; both is an axis; +z if left out"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find keys that a shock which sets its own duration excludes."""
        timed = next((name for name in TIMED if name in written), None)
        others = [key for key in ("shape", *SHARES, *TIMED) if key in written and key != timed]
        return {key: f"excludes {timed}; write one of them" for key in others if timed}

    def __post_init__(self):
        """Make the shocks; ValueError, which begins with `.key: `, for what cannot be one."""
        self.make_shocks()

    def make_shocks(self) -> Shocks:
        """Make the shocks."""
        return self.shocks_from(self.of_pulse())

    def of_pulse(self) -> dict:
        """Give what is written of the pulse."""
        return {key: value for key, value in told(self).items() if key in PULSE}

    def shocks_from(self, values: Mapping) -> Shocks:
        """Make shocks of values by their keys in PULSE; a file is hashed as it is read."""
        if "file" in values:
            with at_key("file"):
                values = {**values, "sha256": sha256_of(values["file"], *RECORD)}
        try:
            return make_shocks(values)
        except ValueError as error:
            raise ValueError(str(error).removeprefix("pulse")) from None


PULSE = tuple(field.name for field in fields(PulseSection))
"""Keys of a pulse."""

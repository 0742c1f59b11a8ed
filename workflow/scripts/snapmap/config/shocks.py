"""The section of the shock in a config."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, fields
from typing import Annotated, Literal

from ..files.named import sha256_of
from ..pulse.pulse import DIRECTIONS, SHAPES, SHARES, VERSED_SINE, Form, ShapeName
from ..pulse.recorded import RECORD, read_pulse
from ..pulse.shocks import MAKERS, Shocks, make_shocks
from ..pulse.trains import Blow, Drop
from ..values.faults import at_key
from ..values.kinds import Fitting, kind_of
from ..values.records import record, told
from .kinds import StudyPath

TIMED = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and set their own duration."""


def _are_shapes(value):
    names = value if isinstance(value, list) else [value]
    known = all(isinstance(name, str) and name in SHAPES for name in names)
    return known and 0 < len(names) == len(set(names))


_SHAPE = kind_of(ShapeName).schema()
_JSON = {"anyOf": [_SHAPE, {"type": "array", "items": _SHAPE, "minItems": 1}]}
_NEED = f"one of {', '.join(SHAPES)}, or a list of these, each once"
SeveralShapes = Annotated[str | list[str], Fitting(_NEED, _are_shapes, json=_JSON)]
Push = Literal[(*DIRECTIONS, "both")]


@record
class PulseSection(Form):
    """The shock: a shape, or a file, train or drop."""

    _: KW_ONLY
    shape: SeveralShapes | None = None
    """how the acceleration goes over time; several are an axis; a versed sine if left out"""
    file: StudyPath | None = None
    """a recorded shock, CSV"""
    train: list[Blow] | None = None
    """blows {shape, N, duration, rise, fall}, {wait: a time} and {repeat: a number}"""
    drop: Drop | None = None
    """a free fall, its blow, and the rebounds"""
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
        try:
            self.make_shocks()
        except ValueError as error:
            raise ValueError(str(error).removeprefix("pulse")) from None

    def values(self) -> dict:
        """Give the values that are written, in internal units, with the SHA-256 of a file."""
        mine = {field.name for field in fields(PulseSection)}
        values = {key: value for key, value in told(self).items() if key in mine}
        if self.train is not None:
            values["train"] = [told(item) for item in self.train]
        if self.drop is not None:
            values["drop"] = told(self.drop)
        try:
            return values | ({"sha256": sha256_of(self.file, *RECORD)} if self.file else {})
        except ValueError as error:
            raise ValueError(f"file: {error}") from None

    def make_shocks(self) -> Shocks:
        """Make the shocks."""
        return shocks_of(self.values())


def shocks_of(values: Mapping) -> Shocks:
    """Make the shocks of a section by its values, as `PulseSection.values` gives them."""
    values = dict(values)
    direction = values.pop("direction", "+z")
    if "file" in values:
        with at_key("file"):
            pulse = read_pulse(values["file"], values["sha256"])
        return make_shocks(pulse, direction)
    names = values.get("shape", VERSED_SINE)
    if not isinstance(names, list):
        return make_shocks(values or VERSED_SINE, direction)
    # Shares belong to the trapezoid; without one the first shape refuses them.
    bearer = "trapezoid" if "trapezoid" in names else names[0]
    forms = [values | {"shape": name} if name == bearer else {"shape": name} for name in names]
    return make_shocks(forms, direction)

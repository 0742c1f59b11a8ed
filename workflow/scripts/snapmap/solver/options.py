"""How a cell is simulated: a model by its name, with its options."""

from collections.abc import Mapping
from typing import Annotated, Literal

from typing_extensions import TypeAliasType

from ..files.text import describe, show
from ..values.damper import INTERNAL
from ..values.faults import Faults
from ..values.fields import hints
from ..values.kinds import Kind
from ..values.quantities import Count, Fraction, Modes
from ..values.reading import read_part
from ..values.records import build, record, told
from .laws import UNIT, UserLaws

TOLERANCE = 1e-3
"""Default relative error of a threshold that `auto` may make; its usual steps make as much."""


@record
class Auto:
    """The cheapest sufficient number of cosines for each cell.

    Examples
    --------
    >>> snapmap.Auto(tolerance=0.01)
    Auto(tolerance=0.01)
    """

    tolerance: Fraction = TOLERANCE
    """largest relative error of thresholds"""
    name: Literal["auto"] = "auto"
    """the model"""

    laws = None


@record
class Cosines:
    """Symmetric cosines.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> snapmap.Study(device, model=snapmap.Cosines(modes=3)).model
    Cosines(modes=3)
    """

    modes: Modes | None = None
    """number of modes; all if left out"""
    cosines: Count | None = None
    """number of symmetric cosines; left out, as many as `modes`, else 5"""
    laws: UserLaws | None = None
    """laws in place of the device's own forces: a Python file, or functions by name"""
    name: Literal["cosines"] = "cosines"
    """the model"""


@record
class Elements:
    """Hermite elements on the half beam, as in the handout.

    Examples
    --------
    >>> snapmap.Elements(modes=4).elements
    5
    """

    elements: Count = 5
    """number of elements on the half beam"""
    modes: Modes | None = None
    """number of modes; left out, all, or three quarters of them with hard contact"""
    laws: UserLaws | None = None
    """laws in place of the device's own forces: a Python file, or functions by name"""
    name: Literal["elements"] = "elements"
    """the model"""


@record
class Reference:
    """The handout's central differences in a plain loop; slow.

    Examples
    --------
    >>> snapmap.Reference(elements=10)
    Reference(elements=10)
    """

    elements: Count = 5
    """number of elements on the half beam"""
    name: Literal["reference"] = "reference"
    """the model"""

    laws = None


Chosen = Auto | Cosines | Elements | Reference
MODELS = {made.name: made for made in (Auto, Cosines, Elements, Reference)}


class ModelKind(Kind):
    """A model: its name, a mapping of name and options, or a record."""

    need = f"one of {', '.join(MODELS)}"
    records = tuple(MODELS.values())
    asks = f"a mapping of name, one of {', '.join(MODELS)}, and options"

    def take(self, value: object) -> Chosen:
        """Give the record of a value of Python."""
        if isinstance(value, Chosen):
            return value
        if isinstance(value, Mapping):
            return build(self._named(value, show), value)
        if not isinstance(value, str) or value not in MODELS:
            raise ValueError(f"{show(value)} is not {self.need}")
        return MODELS[value]()

    def read(self, value: object) -> Chosen:
        """Read a section of a config."""
        if not isinstance(value, Mapping):
            raise ValueError(f"{describe(value)} is not {self.asks}")
        wrong: tuple[str, ...] = ()
        try:
            made = self._named(value, describe)
        except ValueError as error:  # the options are those of the model that has most of them
            wrong = (str(error),)
            made = max(MODELS.values(), key=lambda made: len(value.keys() & hints(made).keys()))
        try:
            model = read_part(made, {**value, "name": made.name})
        except Faults as faults:
            wrong += faults.args
        if wrong:
            raise Faults(*wrong)
        return model

    def _named(self, value, say):
        if "name" not in value:
            raise ValueError(f".name: missing; write one of {', '.join(MODELS)}")
        if value["name"] not in [*MODELS]:
            raise ValueError(f".name: {say(value['name'])} is not one of {', '.join(MODELS)}")
        made = MODELS[value["name"]]
        if made in (Auto, Reference) and "laws" in value:
            raise ValueError(f".laws: {made.name} takes none; write name: elements, or cosines")
        return made


Model = TypeAliasType("Model", Annotated[str | Chosen | Mapping, ModelKind()])


def section_of(chosen: Chosen) -> dict[str, object]:
    """Write the section of a config; laws by their file, with its hash, or by their names."""
    options = {key: value for key, value in told(chosen).items() if key != "name"}
    if chosen.laws:
        options["laws"] = str(chosen.laws)
        options |= {"sha256": chosen.laws.sha256} if chosen.laws.file else {}
        options |= {UNIT: unit} if (unit := chosen.laws.unit_of_C) != INTERNAL else {}
    return {"name": chosen.name} | options

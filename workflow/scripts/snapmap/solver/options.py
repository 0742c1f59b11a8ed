"""How a cell is simulated: a model by its name, with its options."""

from collections.abc import Mapping
from typing import Annotated, Literal

from ..files.text import describe, show
from ..values.arguments import Reading, nearest
from ..values.faults import Faults
from ..values.kinds import Kind
from ..values.quantities import Count, Fraction, Modes
from ..values.records import build, hints, record, told
from ..values.units import OF_DAMPER
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
    """Hermite elements on the half beam.

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
    """Elements by central differences in a plain loop; slow.

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
PARTS = {"cosines": "modes", "elements": "elements"}
"""Option that a number before the name of a model gives."""


class ModelKind(Kind):
    """A model: its name, a mapping of name and options, or a record."""

    need = f"one of {', '.join(MODELS)}, or a number with it, as '3 cosines'"
    records = tuple(MODELS.values())
    asks = f"a mapping of name, one of {', '.join(MODELS)}, and options"

    def convert(self, value: object, reading: Reading) -> Chosen:
        """Give the record of a value."""
        if isinstance(value, Mapping):
            return self._of_section(value, reading)
        if not reading.written:
            if isinstance(value, Chosen):
                return value
            if isinstance(value, str):
                return self._of_name(value)
        raise self.refuse(value, reading)

    def _of_name(self, value):
        """Make a model by its name, behind a number of parts or not."""
        number, _, name = value.rpartition(" ")
        if name in PARTS and number.isdigit():
            return build(MODELS[name], {PARTS[name]: int(number)})
        if value not in MODELS:
            raise ValueError(f"{self.refuse(value)}{nearest(value, MODELS)}")
        return MODELS[value]()

    def _of_section(self, value, reading):
        """Read a section; of an unknown name, as the model that has most of its options."""
        wrong, name = [], value.get("name")
        if "name" not in value:
            wrong = [f".name: missing; write one of {', '.join(MODELS)}"]
        elif name not in [*MODELS]:
            say = describe if reading.written else show
            near = nearest(str(name), MODELS)
            wrong = [f".name: {say(name)} is not one of {', '.join(MODELS)}{near}"]
        elif name in (Auto.name, Reference.name) and "laws" in value:
            wrong = [f".laws: {name} takes none; write name: elements, or cosines"]
            value = {key: value[key] for key in value if key != "laws"}
        likely = max(MODELS.values(), key=lambda made: len(value.keys() & hints(made).keys()))
        made = MODELS[name] if name in [*MODELS] else likely
        try:
            model = build(made, {**value, "name": made.name}, reading)
        except Faults as faults:
            wrong += faults.args
        if wrong:
            raise Faults(*wrong)
        return model


Model = Annotated[str | Chosen | Mapping, ModelKind()]


def section_of(chosen: Chosen) -> dict[str, object]:
    """Write the section of a config; laws by their file, with its hash, or by their names."""
    options = {key: value for key, value in told(chosen).items() if key != "name"}
    if chosen.laws:
        options["laws"] = str(chosen.laws)
        options |= {"sha256": chosen.laws.sha256} if chosen.laws.file else {}
        options |= {UNIT: unit} if (unit := chosen.laws.unit_of_C) != OF_DAMPER else {}
    return {"name": chosen.name} | options

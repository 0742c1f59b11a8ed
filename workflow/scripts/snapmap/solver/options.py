"""The names of models and the options of each, from Python as in a config."""

from collections.abc import Mapping
from typing import Annotated, TypedDict

from ..device.argument import Argument, argument_of, integer, number, word
from .laws import Laws

OPTIONS = {
    "reference": ("elements", "laws"),
    "elements": ("elements", "modes"),
    "cosines": ("cosines", "modes"),
    "auto": ("tolerance",),
}
"""Of each model."""


class ModelOptions(TypedDict, total=False):
    """Options of models."""

    elements: Annotated[int, integer(1, 100)]
    cosines: Annotated[int, integer(1, 100)]
    modes: Annotated[int, integer(1, 200)]


class AutoOptions(ModelOptions, total=False):
    """The same where no argument of the function is a tolerance."""

    tolerance: Annotated[float, number("(0, 1)", "", "1e-3")]


OF_MODEL = {key: argument_of(kind) for key, kind in AutoOptions.__annotations__.items()}
OF_MODEL["laws"] = Argument(
    "a file of laws or what snapmap.reference makes", lambda value: isinstance(value, str | Laws)
)
"""What each option may be."""


def take_model(model: Mapping) -> dict[str, object]:
    """A model's name and options, converted; ValueError, one line, for one that cannot be."""
    name = str(word(*OPTIONS).take("model.name", model.get("name")))
    taken: dict[str, object] = {"name": name}
    for key, value in model.items():
        if key in OPTIONS[name]:
            taken[key] = OF_MODEL[key].take(f"model.{key}", value)
        elif key == "sha256" and isinstance(model.get("laws"), str):
            taken[key] = value
        elif key != "name":
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: is not an option of {name}; write one of {known}")
    return taken

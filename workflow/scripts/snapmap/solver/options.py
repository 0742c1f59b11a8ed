"""The names of models and their options, in Python as in a config."""

from collections.abc import Mapping
from typing import Annotated, TypedDict

from ..device.argument import Argument, argument_of, integer, number, word
from .laws import Laws

OPTIONS = {
    "reference": ("elements", "laws"),
    "elements": ("elements", "modes", "laws"),
    "cosines": ("cosines", "modes", "laws"),
    "auto": ("tolerance",),
}
"""Names of the options of each model."""


class ModelOptions(TypedDict, total=False):
    """Options of models, of functions whose `tolerance` is an argument of their own."""

    elements: Annotated[int, integer(1, 100)]
    cosines: Annotated[int, integer(1, 100)]
    modes: Annotated[int, integer(1, 200)]


class AutoOptions(ModelOptions, total=False):
    """Options of models, of all other functions."""

    tolerance: Annotated[float, number("(0, 1)", "", "1e-3")]


OF_MODEL = {key: argument_of(kind) for key, kind in AutoOptions.__annotations__.items()}
OF_MODEL["laws"] = Argument(
    "a file of laws or what snapmap.reference makes", lambda value: isinstance(value, str | Laws)
)
"""Description of each option."""


def take_model(model: Mapping) -> dict[str, object]:
    """Check and convert a model's name and options; raises ValueError, one line."""
    name = str(word(*OPTIONS).take("model.name", model.get("name")))
    options: dict[str, object] = {"name": name}
    for key, value in model.items():
        if key in OPTIONS[name]:
            options[key] = OF_MODEL[key].take(f"model.{key}", value)
        elif key == "sha256" and isinstance(model.get("laws"), str):
            options[key] = value
        elif key != "name":
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: is not an option of {name}; write one of {known}")
    return options

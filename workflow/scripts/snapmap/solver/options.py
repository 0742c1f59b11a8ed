"""The names of models and the options of each, from Python as in a config."""

from collections.abc import Mapping

from ..device.argument import integer, number, word

OPTIONS = {
    "reference": ("elements",),
    "elements": ("elements", "modes"),
    "cosines": ("cosines", "modes"),
    "auto": ("tolerance",),
}
"""Names of the options of each model."""
OF_MODEL = {
    "tolerance": number("(0, 1)", "", "1e-3"),
    "elements": integer(1, 100),
    "cosines": integer(1, 100),
    "modes": integer(1, 200),
}
"""What each option may be."""


def take_model(model: Mapping) -> dict:
    """Convert a model's name and options; ValueError, one line, for a value that cannot be."""
    name = word(*OPTIONS).take("model.name", model.get("name"))
    taken = {"name": name}
    for key, value in model.items():
        if key in OPTIONS[name]:
            taken[key] = OF_MODEL[key].take(f"model.{key}", value)
        elif key != "name":
            known = ", ".join(OPTIONS[name])
            raise ValueError(f"model.{key}: not an option of {name}; its options are {known}")
    return taken

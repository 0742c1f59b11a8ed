"""The devices of a study as their config has them, for the table of the page."""

import html
from collections.abc import Mapping, Sequence

from ..config.devices import read_device
from ..described import describe
from ..device import CLAMP, STOPS, STRENGTH
from ..quantities import QUANTITIES, Quantity

SHOWN = {
    "youngs_modulus": (1e-3, "GPa"),
    "density": (1e6, "kg/m³"),
    "mass": (1e-12, "kg"),
    "gravity": (1e6, "m/s²"),
}
"""Factor and unit of what is shown in other units than the axes have."""


def device_rows(document: Mapping) -> dict[str, list[tuple[str, str, str]]]:
    """Rows of each device by its name, "" if there is but one: key, words and value as HTML.

    document: the config of a study, every value with its unit
    """
    return {name: list(_rows(device)) for name, device in _devices(document).items()}


def vibrations(document: Mapping, C: Sequence[float]) -> dict[str, str]:
    """What is said of each device's frequencies, by its name as in `device_rows`; C: uN us/um."""
    said = {name: describe(read_device(device), C) for name, device in _devices(document).items()}
    return {name: html.escape(words) for name, words in said.items()}


STRUCK = {
    "": "is struck by a mass when the frame is shaken by one pulse of acceleration",
    "alone": "is shaken with its frame by one pulse of acceleration",
    "alone pushed": "is pushed at its midpoint by one pulse of force, of which N is the peak",
}
"""What the pulse does, by the kinds of the drawing."""


def kind_of(document: Mapping) -> str:
    """Whether all devices are a beam alone, and pushed at the midpoint; a key of STRUCK."""
    devices = _devices(document).values()
    alone = all(one.get("mass") == "none" for one in devices)
    pushed = alone and all("force" in one for one in devices)
    return "alone pushed" if pushed else "alone" if alone else ""


def words_of(key: str) -> str:
    """What a value of the device is called, with its symbol, as HTML."""
    quantity = QUANTITIES.get(key, Quantity(key))
    words = html.escape(quantity.words or key.replace("_", " "))
    return f"{words} <i>{quantity.symbol}</i>" if quantity.symbol else words


def _devices(document):
    devices = document.get("devices", {"": document.get("device", {})})
    return {html.escape(name): device for name, device in devices.items()}


def _rows(values):
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _rows(value)
        else:
            name = (CLAMP | STOPS | STRENGTH).get(key, key)
            yield name, words_of(name), _text(name, str(value))


def _text(key, written):
    """A value in the unit of its axis, or as it is written."""
    number, _, unit = written.partition(" ")
    if key not in QUANTITIES or not QUANTITIES[key].kind or unit != QUANTITIES[key].unit:
        return html.escape(written)
    factor, shown = SHOWN.get(key) or (1.0, QUANTITIES[key].spelt.page)
    return f"{float(number) * factor:.6g}\u00a0{shown}".strip()

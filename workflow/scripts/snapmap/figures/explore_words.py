"""Words of the page: how its axes are called and ticked, and the table of the device."""

import html
import re
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.ticker import LogLocator, MaxNLocator

from ..axes import NAMES
from ..config.devices import read_device
from ..described import describe
from ..device import CLAMP, STOPS, STRENGTH
from ..quantities import QUANTITIES, Quantity
from . import scales

DURATIONS = 8
"""Most durations ticked above the map, so that they stand apart on a phone."""
SHOWN = {
    "youngs_modulus": (1e-3, "GPa"),
    "density": (1e6, "kg/m³"),
    "mass": (1e-12, "kg"),
    "gravity": (1e6, "m/s²"),
}
"""Factor and unit of what is shown in other units than the axes have."""
STRUCK = {
    "": "is struck by a mass when the frame is shaken by one pulse of acceleration",
    "alone": "is shaken with its frame by one pulse of acceleration",
    "alone pushed": "is pushed at its midpoint by one pulse of force, of which N is the peak",
}
"""What the pulse does, by the kinds of the drawing."""


def plane(cells: xr.Dataset) -> tuple[str, str]:
    """Names of the axes to the right and upward: f0 and N, or else the longest others."""
    several = [key for key in cells.outcome.dims if cells.sizes[key] > 1]
    longest = sorted(several, key=cells.sizes.get, reverse=True)
    x = next((key for key in ("f0", *longest) if key in several and key != "N"), "f0")
    y = next((key for key in ("N", *longest) if key in several and key != x), "N")
    return x, y


def axis(cells: xr.Dataset, key: str) -> dict:
    """An axis as the page's code knows it: where its values stand, and their texts."""
    quantity, values = QUANTITIES[key], cells[key].values
    lead = f"{quantity.words} ".lstrip() if key in NAMES else f"{_typeset(quantity.words)} = "
    return {
        "name": key,
        "label": _label(key),
        "lead": lead,
        "values": scales.scale_of(key, values).places.tolist(),
        "texts": [say(value, quantity.spelt.page) for value in values.tolist()],
    }


def layout(scale: scales.Scale) -> dict:
    """An axis of the map, for plotly; values that are no numbers, or one alone, are ticked."""
    unit = QUANTITIES[scale.key].spelt.page
    title = f"{_label(scale.key)} ({unit})" if unit else _label(scale.key)
    ends = np.log10(scale.edges[[0, -1]]) if scale.is_log else scale.edges[[0, -1]]
    made = {"title": title, "range": ends.tolist(), "exponentformat": "none", "type": "linear"}
    if scale.is_log:
        # Two to a decade make plotly write 1, 2 and 5, which stand apart on a phone.
        made |= {"type": "log", "nticks": max(2, round(2 * np.ptp(ends)))}
    if scale.is_counted or scale.values.size == 1:
        every = -(-scale.values.size // scales.SEVERAL)
        texts = [say(value) for value in scale.values[::every].tolist()]
        made |= {"tickvals": scale.places[::every].tolist(), "ticktext": texts}
    return made


def durations(scale: scales.Scale) -> dict:
    """The axis above one of frequencies (Hz), ticked at durations (ms), for plotly."""
    ticks = 1e3 / scale.values
    if scale.values.size > 1:
        ends = 1e3 / scale.edges[[-1, 0]]
        wide = LogLocator(subs=(1, 2, 5)), LogLocator()
        for locator in wide if ends[1] > 4 * ends[0] else [MaxNLocator(5)]:
            ticks = locator.tick_values(*ends)
            ticks = ticks[(ticks >= ends[0]) & (ticks <= ends[1])]
            if ticks.size <= DURATIONS:
                break
    return {
        "title": {"text": "pulse duration 1/f<sub>0</sub> (ms)", "standoff": 4},
        "overlaying": "x",
        "matches": "x",
        "side": "top",
        "tickvals": (1e3 / ticks).tolist(),
        "ticktext": [say(tick) for tick in ticks.tolist()],
    }


def say(value: float | str, unit: str = "") -> str:
    """Four digits and a unit, or a name, as HTML."""
    if isinstance(value, str) or np.isinf(value):
        return html.escape(scales.number(value))
    digits = {"precision": 4, "fractional": False, "trim": "-"}
    tiny = 0 < abs(value) < 1e-4
    text = f"{value:.4g}" if tiny else np.format_float_positional(value, **digits)
    return f"{text}\u00a0{unit}" if unit else text


def _label(key):
    return _typeset(QUANTITIES[key].label or QUANTITIES[key].words)


def _typeset(text):
    """Formulas, in dollars, as HTML."""
    return re.sub(r"_(\w)", r"<sub>\1</sub>", text.replace("$", ""))


def device_rows(document: Mapping) -> dict[str, list[tuple[str, str, str]]]:
    """Rows of each device by its name, "" if there is but one: key, words and value as HTML.

    document: the config of a study, every value with its unit
    """
    return {name: list(_rows(device)) for name, device in _devices(document).items()}


def vibrations(document: Mapping, C: Sequence[float]) -> dict[str, str]:
    """What is said of each device's frequencies, by its name as in `device_rows`; C: uN us/um."""
    devices = _devices(document).items()
    return {name: html.escape(describe(read_device(device), C)) for name, device in devices}


def kind_of(document: Mapping) -> str:
    """Whether all devices are a beam alone, and pushed at the midpoint; a key of STRUCK."""
    devices = _devices(document).values()
    alone = all(one.get("mass") == "none" for one in devices)
    pushed = alone and all("force" in one for one in devices)
    return "alone pushed" if pushed else "alone" if alone else ""


def words_of(key: str) -> str:
    """What a value of the device is called, with its symbol, as HTML."""
    quantity = QUANTITIES.get(key, Quantity(key))
    text = html.escape(quantity.words or key.replace("_", " "))
    return f"{text} <i>{quantity.symbol}</i>" if quantity.symbol else text


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

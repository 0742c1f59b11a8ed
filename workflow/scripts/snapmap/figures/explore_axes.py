"""The axes of the page: what they are called, where their values stand, and how they are ticked."""

import html
import re

import numpy as np
import xarray as xr
from matplotlib.ticker import LogLocator, MaxNLocator

from ..axes import NAMES
from ..quantities import QUANTITIES
from . import scales

DURATIONS = 8
"""Most durations ticked above the map, so that they stand apart on a phone."""


def plane(cells: xr.Dataset) -> tuple[str, str]:
    """Names of the axes to the right and upward: f0 and N, or else the longest others."""
    several = [key for key in cells.outcome.dims if cells.sizes[key] > 1]
    longest = sorted(several, key=cells.sizes.get, reverse=True)
    x = next((key for key in ("f0", *longest) if key in several and key != "N"), "f0")
    y = next((key for key in ("N", *longest) if key in several and key != x), "N")
    return x, y


def axis_words(key: str) -> str:
    """What the quantity of an axis is called, as HTML."""
    quantity = QUANTITIES[key]
    return _typeset(quantity.label or quantity.words)


def axis(cells: xr.Dataset, key: str) -> dict:
    """An axis as the page's code knows it: where its values stand, and their texts."""
    label, unit = axis_words(key), QUANTITIES[key].spelt.page
    values = cells[key].values
    return {
        "name": key,
        "label": label,
        "lead": _lead(key),
        "values": scales.scale_of(key, values).places.tolist(),
        "texts": [say(value, unit) for value in values.tolist()],
    }


def layout(scale: scales.Scale) -> dict:
    """An axis of the map, for plotly; values that are no numbers, or one alone, are ticked."""
    label, unit = axis_words(scale.key), QUANTITIES[scale.key].spelt.page
    title = f"{label} ({unit})" if unit else label
    ends = np.log10(scale.edges[[0, -1]]) if scale.is_log else scale.edges[[0, -1]]
    kind = {"type": "linear"}
    if scale.is_log:
        # Two to a decade make plotly write 1, 2 and 5, which stand apart on a phone.
        kind = {"type": "log", "nticks": max(2, round(2 * np.ptp(ends)))}
    found = {"title": title, "range": ends.tolist(), "exponentformat": "none", **kind}
    if scale.is_counted or scale.values.size == 1:
        every = -(-scale.values.size // scales.SEVERAL)
        texts = [say(value) for value in scale.values[::every].tolist()]
        found |= {"tickvals": scale.places[::every].tolist(), "ticktext": texts}
    return found


def durations(scale: scales.Scale) -> dict:
    """The axis above one of frequencies (Hz), ticked at durations (ms), for plotly."""
    ticks = 1e3 / scale.values if scale.values.size == 1 else _ticks(*1e3 / scale.edges[[-1, 0]])
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
    tiny = 0 < abs(value) < 1e-4
    digits = {"precision": 4, "fractional": False, "trim": "-"}
    text = f"{value:.4g}" if tiny else np.format_float_positional(value, **digits)
    return f"{text}\u00a0{unit}" if unit else text


def _lead(key):
    """What stands before a value of an axis."""
    if key in NAMES:
        return f"{QUANTITIES[key].words} ".lstrip()
    return f"{_typeset(QUANTITIES[key].words)} = "


def _typeset(words):
    """Formulas, in dollars, as HTML."""
    return re.sub(r"_(\w)", r"<sub>\1</sub>", words.replace("$", ""))


def _ticks(least, most):
    """Round values in a range, DURATIONS of them at most."""
    wide = LogLocator(subs=(1, 2, 5)), LogLocator()
    for locator in wide if most > 4 * least else [MaxNLocator(5)]:
        ticks = locator.tick_values(least, most)
        ticks = ticks[(ticks >= least) & (ticks <= most)]
        if ticks.size <= DURATIONS:
            break
    return ticks

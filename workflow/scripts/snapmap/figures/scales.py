"""The names, scales and ticks of a study's axes in figures."""

import csv
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, MaxNLocator

from ..files.text import plain
from ..study.axes import DURATION, KIND_OF
from ..values.units import of_file, spelling
from . import captions, style

NONE = MappingProxyType({})
"""The attributes of a dataset without any."""
with open(Path(__file__).with_name("words.csv"), encoding="utf-8") as _file:
    _ROWS = [*csv.DictReader(_file)]

WORDS = {row["name"]: row["words"] for row in _ROWS}
"""Words before a value of each axis."""
LABELS = {row["name"]: row["label"] or row["words"] for row in _ROWS}
"""Name of each quantity along its axis."""
SEVERAL = 10
"""Most values of an axis that all have a tick; of more, every nth has."""
FEW = 5
"""Most values of the device or its damper that a map shows as columns, each with its tick."""
SPACE = 0.03
"""Share of an axis beyond its first and last value, for markers."""
THIN, FROM = "\u2009", 10_000
"""The space between thousands, and the least number that has it."""
SUBS, APART, LOOSE = ((1, 2, 3, 5), (1, 2, 5), (1, 3), (1,)), 1.1, 1.8
"""Digits that have ticks in a decade, densest choice first; the least room of a label; and that in
a user's own axes, which may become smaller."""
SHORT = 0.5
"""Decades below which a logarithmic axis has the ticks of a linear one."""


def unit_of(key: str, attributes: Mapping[str, str] = NONE) -> str:
    """Typeset the unit behind a value of an axis; "" for none.

    attributes: of the axis, which have the unit of C under a user's own law
    """
    if key == DURATION:
        return "ms"
    if key == "C" and "units" in attributes:
        return spelling(of_file(attributes["units"])).figures
    return spelling(KIND_OF[key].unit).figures if key in KIND_OF else ""


class Scale(NamedTuple):
    """The places of an axis' values in a figure.

    places: ascending, (values,); edges: edges of the cells around them, (values + 1,)
    is_log: whether the axis is logarithmic; is_counted: whether places count values
    unit: typeset
    """

    key: str
    values: np.ndarray
    places: np.ndarray
    edges: np.ndarray
    is_log: bool
    is_counted: bool
    unit: str


def scale_of(key: str, values: np.ndarray, attributes: Mapping[str, str] = NONE) -> Scale:
    """Choose a scale for ascending values, linear or logarithmic, by their spacing.

    Frequency and duration are always logarithmic; names, and values with a hard contact, are
    counted. attributes: of the axis, as for `unit_of`
    """
    unit = unit_of(key, attributes)
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        places = np.arange(values.size, dtype=float)
        return Scale(key, values, places, _edges(places, 0.5), False, True, unit)
    positive = (values > 0).all()
    is_log = key in ("f0", DURATION) or (positive and _is_geometric(values))
    if is_log:
        edges = np.exp(_edges(np.log(values), math.log(1.1)))
    else:
        edges = _edges(values, abs(values[0]) / 10 or 0.5)
    return Scale(key, values, values, edges, bool(is_log), False, unit)


def cells_of(key: str, values: np.ndarray, attributes: Mapping[str, str] = NONE) -> Scale:
    """Choose a scale for the cells of a map: few values, but those of the shock, are counted."""
    if values.size > FEW or key in ("f0", DURATION, "N"):
        return scale_of(key, values, attributes)
    return scale_of(key, values.astype(object), attributes)._replace(values=values)


def _edges(values, half):
    """Give the edges of cells around n ascending values, halfway between neighbours, (n + 1,).

    half: half the width of the cell of a single value
    """
    steps = np.diff(values) / 2 if values.size > 1 else np.array([half])
    return np.array(
        [values[0] - steps[0], *(values[:-1] + steps[: values.size - 1]), values[-1] + steps[-1]]
    )


def _is_geometric(values):
    """Tell whether steps between values differ less as ratios than as differences."""
    if values.size < 3:
        return values[-1] >= 10 * values[0]
    ratios, differences = np.diff(np.log(values)), np.diff(values)
    return ratios.std() / ratios.mean() < differences.std() / differences.mean()


def set_scale(ax: Axes, which: str, scale: Scale, attributes: Mapping[str, str] = NONE) -> None:
    """Scale and name an axis, "x" or "y", and choose its ticks; attributes: as for `axis_label`.

    Names are short in axes of a user's own.
    """
    axis = getattr(ax, f"{which}axis")
    is_row = scale.places.size > 1 and not scale.is_counted
    ends = scale.places if is_row else scale.edges
    ax.set(**{f"{which}scale": "log" if scale.is_log else "linear", f"{which}lim": ends[[0, -1]]})
    axis.set_label_text(label_in(ax, scale.key, attributes, scale.unit))
    if not is_row:
        tick_values(axis, scale.places, scale.values)
    else:
        tick(axis, ends[0], ends[-1], scale.is_log)


def leave_space(ax: Axes, scale: Scale) -> None:
    """Leave some space for markers at both ends of a horizontal axis that has several values."""
    if scale.places.size > 1 and not scale.is_counted:
        low, high = np.log(scale.places[[0, -1]]) if scale.is_log else scale.places[[0, -1]]
        ends = np.array([low, high]) + SPACE * (high - low) * np.array([-1, 1])
        ax.set_xlim(np.exp(ends) if scale.is_log else ends)


def tick_values(axis: Axis, places: np.ndarray, values: np.ndarray) -> None:
    """Put ticks at the values of an axis, or at every nth of many."""
    every = max(1, -(-values.size // SEVERAL))
    axis.set_ticks(places[::every], [number(value) for value in values[::every]])
    axis.set_ticks([], minor=True)


def tick(
    axis: Axis, low: float, high: float, is_log: bool = True, beside: Axis | None = None
) -> None:
    """Put ticks at round numbers between the ends of an axis, as close as there is room.

    An axis on which nothing was drawn has no ends, and gets no ticks.
    beside: axis of the same length, for a secondary axis, which does not know its own length yet
    """
    if not (0.0 if is_log else -math.inf) < low < high:
        axis.set_ticks([])
        axis.set_ticks([], minor=True)
        return
    decades = math.log10(high / low) if is_log else 0.0
    space = (beside or axis).get_tick_space() / (APART if style.is_ours(axis.axes) else LOOSE)
    if decades < SHORT:
        last = (1 - low / high) / math.log(high / low) if is_log else 1.0  # step, over the mean one
        most = int(np.clip(last * space, 2, 6))
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 3, 5, 10]))
    else:
        fitting = (subs for subs in SUBS if np.diff(np.log10([*subs, 10])).min() * space >= decades)
        axis.set_major_locator(LogLocator(subs=next(fitting, (1,))))
    axis.set_major_formatter(lambda value, _: number(value, 6))
    axis.set_minor_formatter("")


def axis_label(key: str, attributes: Mapping[str, str] = NONE, unit: str = "") -> str:
    """Write the label of an axis: its quantity, and the unit in brackets.

    attributes: attributes of the dataset, whose config says what N counts
    unit: typeset; by default the internal unit
    """
    unit = captions.multiples(attributes) if key == "N" else unit or unit_of(key)
    label = LABELS[key]
    return f"{label} ({unit})" if unit else label


def label_in(ax: Axes, key: str, attributes: Mapping[str, str] = NONE, unit: str = "") -> str:
    """Write `axis_label`, in axes of a user's own with the symbol alone, as they may be small."""
    label = axis_label(key, attributes, unit)
    return label if style.is_ours(ax) else label.replace(LABELS[key], WORDS[key] or LABELS[key], 1)


def study_axis(ax: Axes, scale: Scale, attributes: Mapping[str, str] = NONE) -> None:
    """Make x an axis of the study; frequencies (Hz) get the pulse's duration as upper axis.

    In axes of a user's own there is no room for that one.
    """
    set_scale(ax, "x", scale, attributes)
    if scale.key != "f0" or not style.is_ours(ax):
        return
    top = ax.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
    top.set_xlabel(axis_label(DURATION))
    if scale.values.size == 1:
        tick_values(top.xaxis, 1e3 / scale.values, 1e3 / scale.values)
    else:
        tick(top.xaxis, *_reciprocal(ax.get_xlim()[::-1]), beside=ax.xaxis)


def _reciprocal(values):
    """Convert f0 in Hz to a duration in ms, or back; matplotlib also asks for 0."""
    with np.errstate(divide="ignore"):
        return 1e3 / np.asarray(values)


def along(data: xr.Dataset, *axes: str) -> xr.Dataset:
    """Replace the axis f0 (Hz) of a dataset by the duration (ms), if that is one of the axes."""
    if DURATION not in axes:
        return data
    durations = data.assign_coords({DURATION: ("f0", 1e3 / data.f0.values)})
    return durations.swap_dims(f0=DURATION).sortby(DURATION)


def value_text(key: str, value: float | str, unit: str | None = None) -> str:
    """Typeset a value of an axis: `$C$ = 25 µN µs µm$^{-1}$`, `thickness 1.9 µm`.

    unit: typeset; by default the internal unit
    """
    words, unit = WORDS[key], unit_of(key) if unit is None else unit
    sign = " = " if "$" in words else " "
    text = number(value).replace("-", "−") if key == "direction" else number(value)
    return f"{words}{sign}{text} {unit if value != math.inf else ''}".strip()


def place_text(data: xr.Dataset, width: int = 50) -> str:
    """Typeset the place of a dataset on axes of a single value, in lines of `width` signs."""
    alone = (key for key in WORDS if key in data.coords and data[key].ndim == 0)
    texts = (value_text(k, data[k].item(), unit_of(k, data[k].attrs)) for k in alone)
    return captions.fill(texts, width)


def number(value: float | str, digits: int = 4) -> str:
    """Write a value in some digits, with spaces between thousands; names stay as they are."""
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "hard" if value == math.inf else "not known"
    sign, size = "−" if value < 0 else "", plain(abs(value), digits)
    thin = r"\," if rcParams["text.usetex"] else THIN
    return sign + (f"{float(size):,.0f}".replace(",", thin) if FROM <= float(size) < 1e7 else size)

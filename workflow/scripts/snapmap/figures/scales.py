"""How the axes of a study are named, spaced and ticked in figures."""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator

from ..axes import COORDINATES, DURATION, PULSE_AXES, SHOCK_AXES, axis_behind
from ..quantities import QUANTITIES

WORDS = {
    key: (quantity.words, "ms" if key == DURATION else quantity.spelt.figures)
    for key, quantity in QUANTITIES.items()
    if axis_behind(key) in COORDINATES
}
"""What stands for each axis before a value, and the unit behind it."""
SHORT, CLOSE_TICKS = 3.5, (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
"""Ratio of its ends below which a logarithmic axis is short, and how that is ticked."""
SEVERAL = 10
"""Most values that are ticked one by one where they are no numbers."""
MANY = 8
"""Values from which on an axis ends at the first and last of them, not at the edges of cells."""
THIN, FROM = "\u2009", 10_000
"""Space between thousands, of numbers from here on."""
SUBS = {1.6: (1, 2, 3, 5), 0.9: (1, 3), 0: (1,)}
"""Digits that are ticked in a decade, by the inches above which there is room for them."""
STEPS = (1, 2, 2.5, 3, 4, 5, 6)
"""Digits of the steps between ticks."""


class Scale(NamedTuple):
    """Where the values of an axis stand in a figure.

    places: (values,), increasing; edges: of the cells about them, (values + 1,)
    is_log: whether the axis is logarithmic; is_counted: whether places count values
    """

    key: str
    values: np.ndarray
    places: np.ndarray
    edges: np.ndarray
    is_log: bool
    is_counted: bool


def scale_of(key: str, values: np.ndarray) -> Scale:
    """Choose a scale for ascending values: that along which they are more evenly spaced.

    The frequency's is logarithmic, the amplitude's is not; names and a hard contact are counted.
    """
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        places = np.arange(values.size, dtype=float)
        return Scale(key, values, places, arithmetic_edges(places), False, True)
    positive = (values > 0).all()
    is_log = key in ("f0", DURATION) or (key != "N" and positive and _is_geometric(values))
    edges = geometric_edges(values) if is_log else arithmetic_edges(values)
    return Scale(key, values, values, edges, bool(is_log), False)


def set_scale(ax: Axes, which: str, scale: Scale) -> None:
    """Scale, name and tick one axis, "x" or "y"; a single value alone is ticked."""
    axis = getattr(ax, f"{which}axis")
    if scale.is_log:
        getattr(ax, f"set_{which}scale")("log")
    axis.set_label_text(axis_label(scale.key))
    if scale.is_counted:
        every = -(-scale.values.size // SEVERAL)
        axis.set_ticks(scale.places[::every], [number(value) for value in scale.values[::every]])
        axis.set_ticks([], minor=True)
    elif scale.values.size == 1:
        axis.set_ticks(scale.values, [f"{scale.values[0]:.6g}"])
        axis.set_ticks([], minor=True)
    elif scale.is_log:
        tick_log(axis, scale.values[[0, -1]], _inches(ax, which))
    else:
        _tick_evenly(axis, *scale.values[[0, -1]])
    ends = scale.places if scale.places.size >= MANY else scale.edges
    getattr(ax, f"set_{which}lim")(ends[0], ends[-1])


def axis_label(key: str) -> str:
    """What is written along an axis: its quantity, and the unit in brackets."""
    words, unit = WORDS[key]
    label = QUANTITIES[key].label or words
    return f"{label} ({unit})" if unit else label


def frequency_axis(ax: Axes, f0: np.ndarray) -> Axes:
    """Make x the frequency of the pulse, logarithmic, and add its duration above; returns that.

    f0: ascending, Hz
    """
    set_scale(ax, "x", scale_of("f0", f0))
    top = ax.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
    top.set_xlabel(axis_label(DURATION))
    if f0.size == 1:
        top.xaxis.set_ticks(1e3 / f0, [f"{1e3 / f0.item():.3g}"])
        top.xaxis.set_ticks([], minor=True)
    else:
        tick_log(top.xaxis, 1e3 / f0[[-1, 0]], _inches(ax, "x"))
    return top


def amplitude_axis(ax: Axes) -> None:
    """Make y the amplitude of the pulse, logarithmic, ticked 1, 2, 3, 5 in every decade."""
    ax.set_yscale("log")
    ax.set_ylabel(axis_label("N"))
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
    _write_numbers(ax.yaxis)


def tick_log(axis: Axis, ends: tuple[float, float], inches: float) -> None:
    """Tick a logarithmic axis of a length between two values, the denser the longer it is."""
    decades = math.log10(ends[1] / ends[0])
    if decades < 0.5:
        axis.set_major_locator(MaxNLocator(5))
    else:
        room = inches / decades
        axis.set_major_locator(LogLocator(subs=next(SUBS[least] for least in SUBS if room > least)))
    _write_numbers(axis)


def _inches(ax, which):
    box = ax.bbox.width if which == "x" else ax.bbox.height
    return box / ax.get_figure().dpi


def velocity_axis(ax: Axes) -> None:
    """Make x the velocity change of the pulse (m/s), logarithmic."""
    ax.set_xscale("log")
    ax.set_xlabel("velocity change of the pulse (m/s)")
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    _write_numbers(ax.xaxis)


def end_at_ticks(axis: Axis) -> None:
    """Move the ends of a logarithmic axis outward to where it is ticked, closely if it is short."""
    low, high = axis.get_view_interval()
    if high < SHORT * low:
        axis.set_major_locator(LogLocator(subs=CLOSE_TICKS))
    ticks = np.asarray(axis.get_major_locator().tick_values(low / 10, high * 10))
    below, above = ticks[ticks <= low * (1 + 1e-9)], ticks[ticks >= high * (1 - 1e-9)]
    ends = max(below, default=low), min(above, default=high)
    getattr(axis.axes, f"set_{axis.axis_name}lim")(ends)


def _tick_evenly(axis, first, last):
    """Tick an axis at round numbers, both ends among them where a round step allows."""
    step = next(_whole_steps(first, last), None)
    if step is None:
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    else:
        axis.set_major_locator(FixedLocator(np.arange(first, last + step / 2, step)))
    _write_numbers(axis)


def _whole_steps(first, last):
    """Round steps from the first number to the last, four to seven of them."""
    for count in (6, 5, 4, 7):
        step = (last - first) / count
        digits = step / 10.0 ** math.floor(math.log10(step))
        is_round = min(abs(digits - one) for one in STEPS) < 1e-9
        if is_round and abs(first / step - round(first / step)) < 1e-9:
            yield step


def _write_numbers(axis):
    axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 6)))
    axis.set_minor_formatter("")


def _reciprocal(values):
    """1/f0 in ms from f0 in Hz, and back; matplotlib asks for it at 0, too."""
    with np.errstate(divide="ignore"):
        return 1e3 / np.asarray(values)


def along(data: xr.Dataset, *axes: str) -> xr.Dataset:
    """Give a dataset over f0 (Hz) the duration (ms) as its axis, if it is one of these."""
    if DURATION not in axes:
        return data
    durations = data.assign_coords({DURATION: ("f0", 1e3 / data.f0.values)})
    return durations.swap_dims(f0=DURATION).sortby(DURATION)


def value_text(key: str, value: float | str) -> str:
    """Typeset a value of an axis: `$C$ = 25 µN µs µm$^{-1}$`, `thickness 1.9 µm`."""
    words, unit = WORDS[key]
    sign = " = " if "$" in words else " "
    return f"{words}{sign}{number(value)} {'' if value == math.inf else unit}".strip()


def place_text(data: xr.Dataset) -> str:
    """Typeset where on all other axes a dataset is: the device's in one line, the shock's below."""
    alone = [key for key in WORDS if key in data.coords and data[key].ndim == 0]
    texts = [value_text(key, data[key].item()) for key in alone]
    of_device = sum(key not in (*PULSE_AXES, *SHOCK_AXES) for key in alone)
    return "\n".join(filter(None, (", ".join(texts[:of_device]), ", ".join(texts[of_device:]))))


def number(value: float | str, digits: int = 4) -> str:
    """A value in four digits, thousands apart; a name as it is, and a hard contact in words."""
    if isinstance(value, str):
        return value
    if value == math.inf:
        return "hard"
    sign, size = "−" if value < 0 else "", float(f"{abs(value):.{digits}g}")
    if FROM <= size < 1e7:
        return f"{sign}{size:,.0f}".replace(",", THIN)
    return f"{sign}{size:.{digits}g}"


def arithmetic_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values: halfway between neighbours; (n + 1,)."""
    if values.size == 1:
        half = abs(values[0]) / 10 or 0.5
        return values + np.array([-half, half])
    middle = (values[:-1] + values[1:]) / 2
    return np.array([2 * values[0] - middle[0], *middle, 2 * values[-1] - middle[-1]])


def geometric_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values above 0: geometric means; (n + 1,)."""
    if values.size == 1:
        return values * np.array([1 / 1.1, 1.1])
    middle = np.sqrt(values[:-1] * values[1:])
    return np.array([values[0] ** 2 / middle[0], *middle, values[-1] ** 2 / middle[-1]])


def _is_geometric(values):
    """Whether steps between values differ less as ratios than as differences."""
    if values.size < 3:
        return values[-1] >= 10 * values[0]
    return _unevenness(np.log(values)) < _unevenness(values)


def _unevenness(values):
    steps = np.diff(values)
    return np.std(steps) / np.mean(steps)

"""How the axes of a study are named, spaced and ticked in figures."""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator

from ..axes import DEVICE, DIRECTION, DURATION, PULSE_AXES, SHAPE, SHOCK

WORDS = {
    DEVICE: ("device", ""),
    "span": ("span", "µm"),
    "rise": ("rise", "µm"),
    "thickness": ("thickness", "µm"),
    "depth": ("depth", "µm"),
    "youngs_modulus": ("Young's modulus", "MPa"),
    "density": ("density", "ng µm$^{-3}$"),
    "damping": ("damping of the beam", "µs$^{-1}$"),
    "residual_stress": ("residual stress", "MPa"),
    "imperfection": ("imperfection", "µm"),
    "mass": ("mass", "ng"),
    "spring": ("spring", "N/m"),
    "contact": ("contact", "N/m"),
    "gap": ("gap", "µm"),
    SHAPE: ("", ""),
    DIRECTION: ("along", ""),
    "C": ("$C$", "µN µs µm$^{-1}$"),
    "f0": ("$f_0$", "Hz"),
    DURATION: ("pulse duration $1/f_0$", "ms"),
    "N": ("$N$", ""),
}
LABELS = {
    SHAPE: "shape of the pulse",
    DIRECTION: "direction of the shock",
    "N": "pulse amplitude $N$ (multiples of $g$)",
    "f0": "pulse frequency $f_0$ (Hz)",
    "C": "damping of the mass $C$ (µN µs µm$^{-1}$)",
}
SEVERAL = 10
"""Most values that are ticked one by one where they are no numbers."""


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
    words, unit = WORDS[scale.key]
    axis.set_label_text(LABELS.get(scale.key, f"{words} ({unit})" if unit else words))
    if scale.is_counted:
        every = -(-scale.values.size // SEVERAL)
        axis.set_ticks(scale.places[::every], [number(value) for value in scale.values[::every]])
        axis.set_ticks([], minor=True)
    elif scale.values.size == 1:
        axis.set_ticks(scale.values, [f"{scale.values[0]:.6g}"])
        axis.set_ticks([], minor=True)
    elif scale.is_log and scale.key != "f0":
        wide = scale.values[-1] > 3 * scale.values[0]
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(5))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")


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
    of_device = sum(key not in (*PULSE_AXES, *SHOCK) for key in alone)
    return "\n".join(filter(None, (", ".join(texts[:of_device]), ", ".join(texts[of_device:]))))


def number(value: float | str) -> str:
    """A value in four digits, a name as it is, and a hard contact in words."""
    if isinstance(value, str):
        return value
    return "hard" if value == math.inf else f"{value:.4g}"


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

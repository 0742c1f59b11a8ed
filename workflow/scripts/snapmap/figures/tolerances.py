"""Devices as made: how probably one snaps, and which value that depends on."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import style
from .curves import LOOKS, MISSING, STAYS, cross
from .scales import WORDS, axis_label, frequency_axis, place_text, scale_of, set_scale

LINES = {0.01: ":", 0.1: "--", 0.5: "-", 0.9: "--", 0.99: ":"}
"""Of the shares of devices that snap."""
SNAP = {"-": "half of the devices snap", "--": "10 and 90 % snap", ":": "1 and 99 % snap"}
NOMINAL = {"color": "#d55e00", "linewidth": 1.0, "linestyle": "-."}
BOUNDS = {"color": "0.8", "linewidth": 0}
LATCHED = {"color": "#0072b2", "linewidth": 0.9}
STAYING = {
    share: {"color": LATCHED["color"], "markerfacecolor": face, **STAYS}
    for share, face in {0.5: "white", 0.99: LATCHED["color"]}.items()
}
"""Of the lowest N above which so large a share stays in the second shape."""
FIELD = {"cmap": "Greys", "vmin": 0, "vmax": 3, "edgecolors": "face", "rasterized": True}
"""Of shares; the darkest grey is one that lines are read on."""
FIRST = {"linestyle": ":", "markerfacecolor": "white", "markeredgewidth": 0.5, "markersize": 2.5}
"""Of indices of first order, beside the solid ones of all."""


def draw_probability(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the share of devices that snap over f0 and N, or over N alone if there is one f0.

    found: of one C; lines where 1, 10, 50, 90 and 99 % snap, and the nominal threshold
    """
    ax.set_title(place_text(found))
    f0, N = scale_of("f0", found.f0.values), scale_of("N", found.N.values)
    if f0.values.size == 1:
        shares = found.squeeze("f0")
        bounds = shares.probability_bound.transpose("bound", "N").values
        ax.fill_between(N.values, *bounds, **BOUNDS)
        ax.plot(N.values, shares.probability.values, color="black")
        ax.axvline(found.N_nominal.item(), **NOMINAL)
        if "latched" in found:
            ax.plot(N.values, shares.latched.values, **LATCHED)
        ax.set(xlabel=axis_label("N"), ylabel="share of devices that snap")
        ax.set(xlim=N.values[[0, -1]], ylim=(0, 1))
        return ax
    frequency_axis(ax, f0.values)
    set_scale(ax, "y", N)
    ax.pcolormesh(f0.edges, N.edges, found.probability.transpose("N", "f0").values, **FIELD)
    for share, dashes in LINES.items():
        line = found.N_quantile.sel(quantile=share).values
        ax.plot(f0.values, line, color="black", linestyle=dashes, linewidth=0.8)
    ax.plot(f0.values, found.N_nominal.values, **NOMINAL)
    for share, look in STAYING.items() if "latched" in found else ():
        stay = (found.latched >= share).transpose("f0", "N").values
        above = np.logical_and.accumulate(stay[:, ::-1], axis=1)[:, ::-1]
        line = np.where(above.any(axis=1), N.values[above.argmax(axis=1)], np.nan)
        ax.plot(f0.values, line, **look)
    return ax


def probability_keys(found: xr.Dataset) -> list[Artist]:
    """The legend of `draw_probability`."""
    keys: list[Artist] = [Patch(**BOUNDS, label="bounds at 95 %")]
    if found.f0.size > 1:
        keys = [Line2D([], [], color="black", linestyle=d, label=SNAP[d]) for d in SNAP]
    keys.append(Line2D([], [], **NOMINAL, label="threshold of the nominal device"))
    looks = {"share that stays snapped": LATCHED}
    if found.f0.size > 1:
        looks = {f"above it {100 * share:g} % stay snapped": STAYING[share] for share in STAYING}
    for words, look in looks.items() if "latched" in found else ():
        keys.append(Line2D([], [], **look, label=words))
    return keys


def draw_sensitivity(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the Sobol indices of each value over f0, with their bounds; found: of one C."""
    ax.set_title(place_text(found))
    f0 = scale_of("f0", found.f0.values)
    if f0.values.size > 1:
        frequency_axis(ax, f0.values)
    else:
        set_scale(ax, "x", f0)
    for value, (colour, marker) in _looks(found):
        index = found.sel(value=value)
        total, first = (index.sensitivity.sel(order=order).values for order in ("total", "first"))
        low, high = index.sensitivity_bound.sel(order="total").transpose("bound", "f0").values
        error, look = (
            np.maximum([total - low, high - total], 0),
            {"color": colour, "marker": marker},
        )
        ax.errorbar(f0.places, total, error, elinewidth=0.5, markersize=3, **look)
        ax.plot(f0.places, first, **look, **FIRST)
    unknown = found.sensitivity.sel(order="total").isnull().all("value").values
    cross(ax, f0.places[unknown], 0.02, "0.4")
    ax.set(ylim=(-0.05, 1.1), ylabel="share of the variance of the threshold")
    return ax


def sensitivity_keys(found: xr.Dataset) -> list[Artist]:
    """The legend of `draw_sensitivity`."""
    keys: list[Artist] = [
        Line2D([], [], color=colour, marker=marker, markersize=3, label=words_of(value))
        for value, (colour, marker) in _looks(found)
    ]
    keys.append(Line2D([], [], color="0.4", marker="o", **FIRST, label="that value alone"))
    if found.sensitivity.isnull().any():
        keys.append(Line2D([], [], color="0.4", **MISSING, label="not known: few devices snap"))
    return keys


def _looks(found):
    """Each value that scatters, with a colour and a marker."""
    return [(value, LOOKS[i % len(LOOKS)]) for i, value in enumerate(found.value.values.tolist())]


def words_of(value: str) -> str:
    """What a draw moves, in words: `thickness and depth`."""
    own = {"N": "$N$ of the shock", "duration": "duration of the pulse"}
    return " and ".join(own.get(key) or WORDS[key][0] for key in value.split("+"))


def batch_text(found: xr.Dataset, attributes: Mapping[str, str]) -> str:
    """How many devices were drawn, and by which model."""
    missing = int((found.bistable == 0).sum())
    lost = f", {missing} of them without a second stable shape" if missing else ""
    return f"{found.bistable.size} devices{lost}; {style.case(attributes)}"

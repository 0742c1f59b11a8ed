"""Devices as made: how probably one snaps, and which value that depends on."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ...figures import style
from ...figures.curves import LOOKS, STAYS, cross
from ...figures.scales import (
    WORDS,
    axis_label,
    place_text,
    scale_of,
    set_scale,
    study_axis,
)

LINES = {0.01: ":", 0.1: "--", 0.5: "-", 0.9: "--", 0.99: ":"}
"""Of the shares of devices that snap."""
SNAP = {"-": "half of the devices snap", "--": "10 and 90 % snap", ":": "1 and 99 % snap"}
NOMINAL = {"color": "#d55e00", "linewidth": 1.0, "linestyle": "-."}
NOMINAL["label"] = "threshold of the nominal device"
LATCHED = "#0072b2"
STAYING = {0.5: "white", 0.99: LATCHED}
"""Colour of the markers of the lowest N above which so large a share stays in the second shape."""
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
        ax.fill_between(N.values, *bounds, color="0.8", linewidth=0, label="bounds at 95 %")
        ax.plot(N.values, shares.probability.values, color="black")
        ax.axvline(found.N_nominal.item(), **NOMINAL)
        if "latched" in found:
            ax.plot(
                N.values, shares.latched.values, color=LATCHED, label="share that stays snapped"
            )
        ax.set(xlabel=axis_label("N", found.attrs), ylabel="share of devices that snap")
        ax.set(xlim=N.values[[0, -1]] if np.ptp(N.values) else N.edges[[0, -1]], ylim=(0, 1))
        return ax
    study_axis(ax, f0)
    set_scale(ax, "y", N, found.attrs)
    ax.pcolormesh(f0.edges, N.edges, found.probability.transpose("N", "f0").values, **FIELD)
    for share, dashes in LINES.items():
        line = found.N_quantile.sel(quantile=share).values
        ax.plot(f0.values, line, color="black", linestyle=dashes, label=SNAP[dashes])
    ax.plot(f0.values, found.N_nominal.values, **NOMINAL)
    for share, face in STAYING.items() if "latched" in found else ():
        stay = (found.latched >= share).transpose("f0", "N").values
        above = np.logical_and.accumulate(stay[:, ::-1], axis=1)[:, ::-1]
        line = np.where(above.any(axis=1), N.values[above.argmax(axis=1)], np.nan)
        look = {"color": LATCHED, "markerfacecolor": face, **STAYS}
        ax.plot(f0.values, line, label=f"above it {100 * share:g} % stay snapped", **look)
    return ax


def draw_sensitivity(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the Sobol indices of each value over f0, with their bounds; found: of one C."""
    ax.set_title(place_text(found))
    f0 = scale_of("f0", found.f0.values)
    study_axis(ax, f0)
    for i, value in enumerate(found.value.values.tolist()):
        index, (colour, marker) = found.sel(value=value), LOOKS[i % len(LOOKS)]
        total, first = (index.sensitivity.sel(order=order).values for order in ("total", "first"))
        low, high = index.sensitivity_bound.sel(order="total").transpose("bound", "f0").values
        bars = {"yerr": np.maximum([total - low, high - total], 0), "elinewidth": 0.5}
        look = {"color": colour, "marker": marker}
        ax.errorbar(f0.places, total, markersize=3, label=words_of(value), **bars, **look)
        ax.plot(
            f0.places, first, label="hollow: that value alone" if i == 0 else None, **look, **FIRST
        )
    unknown = found.sensitivity.sel(order="total").isnull().all("value").values
    cross(ax, f0.places[unknown], 0.02, "0.4", "not known: few devices snap")
    ax.set(ylim=(-0.05, 1.1), ylabel="share of the variance of the threshold")
    return ax


def words_of(value: str) -> str:
    """What a draw moves, in words: `thickness and depth`."""
    own = {"N": "$N$ of the shock", "duration": "duration of the pulse"}
    return " and ".join(own.get(key) or WORDS[key][0] for key in value.split("+"))


def batch_text(found: xr.Dataset, attributes: Mapping[str, str]) -> str:
    """How many devices were drawn, and by which model."""
    missing = int((found.bistable == 0).sum())
    lost = f", {missing} of them without a second stable shape" if missing else ""
    return f"{found.bistable.size} devices{lost}; {style.case(attributes)}"

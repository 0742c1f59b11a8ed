"""Measured shots over the threshold that was fitted to them."""

import textwrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase

from ...figures.captions import PAGE, literal
from ...figures.plane import POINT, TRIPPED
from ...figures.scales import WORDS, axis_label, number, scale_of, study_axis, tick, unit_of
from ...figures.style import labelled, legend, note_missing
from ...numerics.statistics import DEVIATIONS

THRESHOLD = {"color": "#d55e00", "linewidth": 1.0, "label": "fitted threshold"}
SURE = {"color": "#d55e00", "alpha": 0.35, "linewidth": 0, "label": "its 95 % interval"}
SCATTERS = {"color": "0.88", "linewidth": 0, "label": "where 95 % of the thresholds lie"}
SIDES = {False: ("did not trip (left of its frequency)", -1), True: ("tripped (right of it)", 1)}
ASIDE, WIDEST = 1.01, 1.2
"""Factors on f0 between tripped and other shots, and on the range of an axis beyond its data."""


def draw(figure: FigureBase, data: xr.Dataset) -> None:
    """Draw shots over the fitted threshold and its band, a panel for each shape and direction."""
    parts = panels(data)
    axes = figure.subplots(1, len(parts), squeeze=False)[0]
    for ax, part in zip(axes, parts, strict=True):
        draw_shots(ax, part)
    legend(figure, labelled(axes), calibration_text(data), 5)


def panels(data: xr.Dataset) -> list[xr.Dataset]:
    """Split shots by shape and direction; the attribute `panel` names both."""
    pairs = zip(data["shape"].values, data.direction.values, strict=True)
    names = np.array([f"{shape} along {way}".replace("-z", "−z") for shape, way in pairs])
    return [
        data.isel(shot=np.flatnonzero(names == name)).assign_attrs(data.attrs | {"panel": name})
        for name in dict.fromkeys(names.tolist())
    ]


def draw_shots(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw shots of one shape and direction over f0 and N, filled where the device tripped.

    A line is the fitted threshold, with its interval at 95 %. The wider band holds 95 % of the
    thresholds of single shots.
    """
    ax.set_title(literal(data.attrs["panel"]))
    f0, first = np.unique(data.f0.values, return_index=True)
    middle, low, high = (data[f"threshold{end}"].values[first] for end in ("", "_low", "_high"))
    if f0.size == 1:
        f0, (middle, low, high) = f0 * [1 / WIDEST, WIDEST], np.tile([middle, low, high], 2)
    wide = np.exp(DEVIATIONS * data.spread.sel(bound="estimate").item())
    study_axis(ax, scale_of("f0", f0))
    ax.set_xlim(min(f0[0], data.f0.min() / WIDEST), max(f0[-1], data.f0.max() * WIDEST))
    note_missing(ax, middle, "no threshold was fitted")
    ends = data.N.values.min() / WIDEST, data.N.values.max() * WIDEST
    ax.set(yscale="log", ylim=ends, ylabel=axis_label("N", data.attrs))
    tick(ax.yaxis, *ends)
    ax.fill_between(f0, low / wide, high * wide, **SCATTERS)
    ax.fill_between(f0, low, high, **SURE)
    ax.plot(f0, middle, **THRESHOLD)
    for tripped, (label, side) in SIDES.items():
        shots = data.isel(shot=np.flatnonzero(data.tripped.values == tripped))
        look = POINT | {"markersize": 3, "markerfacecolor": TRIPPED[tripped]}
        ax.plot(shots.f0 * ASIDE**side, shots.N, label=label, **look)
    return ax


def calibration_text(data: xr.Dataset) -> str:
    """Write the estimates with their intervals, and the spread."""
    words, units = [], dict(part.split(": ") for part in data.estimate.comment.split(", "))
    for name in data.unknown.values:
        unknown, unit = data.sel(unknown=name), unit_of(name, {"units": units[name]})
        middle, low, high = (number(unknown[key].item()) for key in ("estimate", "low", "high"))
        words.append(f"{WORDS[name]} {middle} {unit} ({low} to {high})")
    spread = number(100 * data.spread.sel(bound="estimate").item(), 2)
    return textwrap.fill(", ".join([*words, f"spread {spread} %"]), PAGE)

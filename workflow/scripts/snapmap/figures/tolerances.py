"""Devices as made: how probably one snaps, which value that depends on, what meets requirements."""

import textwrap
from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..tolerances.statistics import left_out, percents
from . import style
from .curves import LOOKS, MISSING, STAYS, cross, each_line
from .scales import (
    WORDS,
    arithmetic_edges,
    axis_label,
    frequency_axis,
    geometric_edges,
    place_text,
    scale_of,
    set_scale,
    value_text,
)

LINES = {0.01: ":", 0.1: "--", 0.5: "-", 0.9: "--", 0.99: ":"}
"""Of the shares of devices that snap."""
NOMINAL = {"color": "#d55e00", "linewidth": 1.0, "linestyle": "-."}
LATCHED = {"color": "#0072b2", "linewidth": 0.9}
STAYING = {
    share: {"color": LATCHED["color"], "markerfacecolor": face, **STAYS}
    for share, face in {0.5: "white", 0.99: LATCHED["color"]}.items()
}
"""Of the lowest N above which so large a share stays in the second shape."""
FIELD = {"cmap": "Greys", "vmin": 0, "vmax": 3, "edgecolors": "face", "rasterized": True}
"""Of shares; the darkest grey is one that lines are read on."""
FIRST = {"linestyle": ":", "markerfacecolor": "white", "markeredgewidth": 0.5}
"""Of indices of first order, beside the solid ones of all."""
NAME = 24
"""Signs in a line of a requirement's name beside its shares."""
FAILS = {"color": "0.9", "linewidth": 0}


def draw_probability(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the share of devices that snap over f0 and N, or over N alone if there is one f0.

    found: of one C; lines where 1, 10, 50, 90 and 99 % snap, and the nominal threshold
    """
    ax.set_title(place_text(found))
    return _draw_shares(ax, found) if found.f0.size == 1 else _draw_field(ax, found)


def _draw_field(ax, found):
    edges = geometric_edges(found.f0.values), arithmetic_edges(found.N.values)
    shares = found.probability.transpose("N", "f0").values
    frequency_axis(ax, found.f0.values)
    set_scale(ax, "y", scale_of("N", found.N.values))
    ax.pcolormesh(*edges, shares, **FIELD)
    for share, dashes in LINES.items():
        N = found.N_quantile.sel(quantile=share).values
        ax.plot(found.f0.values, N, color="black", linestyle=dashes, linewidth=0.8)
    ax.plot(found.f0.values, found.N_nominal.values, **NOMINAL)
    if "latched" in found:
        for share, look in STAYING.items():
            stay = (found.latched >= share).transpose("f0", "N").values
            above = np.logical_and.accumulate(stay[:, ::-1], axis=1)[:, ::-1]
            N = np.where(above.any(axis=1), found.N.values[above.argmax(axis=1)], np.nan)
            ax.plot(found.f0.values, N, **look)
    return ax


def _draw_shares(ax, found):
    shares, N = found.probability.squeeze("f0"), found.N.values
    bounds = found.probability_bound.squeeze("f0")
    ax.fill_between(N, *bounds.transpose("bound", "N").values, color="0.8", linewidth=0)
    ax.plot(N, shares.values, color="black")
    ax.axvline(found.N_nominal.item(), **NOMINAL)
    if "latched" in found:
        ax.plot(N, found.latched.squeeze("f0").values, **LATCHED)
    ax.set(xlabel=axis_label("N"), ylabel="share of devices that snap")
    ax.set(xlim=(N[0], N[-1]), ylim=(0, 1))
    return ax


def probability_keys(found: xr.Dataset) -> list[Line2D]:
    """The legend of `draw_probability`."""
    words = {":": "1 and 99 % snap", "--": "10 and 90 % snap", "-": "half of the devices snap"}
    keys = []
    if found.f0.size > 1:
        keys = [Line2D([], [], color="black", linestyle=d, label=words[d]) for d in words]
    else:
        keys = [Patch(color="0.8", label="bounds at 95 %")]
    keys.append(Line2D([], [], **NOMINAL, label="threshold of the nominal device"))
    if "latched" in found:
        keys += (
            [Line2D([], [], **LATCHED, label="stay in the second shape")]
            if found.f0.size == 1
            else [
                Line2D(
                    [], [], **look, label=f"above it, {100 * share:g} % stay in the second shape"
                )
                for share, look in STAYING.items()
            ]
        )
    return keys


def draw_sensitivity(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the Sobol indices of each value over f0, with their bounds; found: of one C."""
    ax.set_title(place_text(found))
    f0 = scale_of("f0", found.f0.values)
    if f0.values.size > 1:
        frequency_axis(ax, f0.values)
    else:
        set_scale(ax, "x", f0)
    total, first = (found.sensitivity.sel(order=order) for order in ("total", "first"))
    bounds = found.sensitivity_bound.sel(order="total")
    for value, (colour, marker) in zip(found.value.values, _looks(found.value.size), strict=True):
        low, high = bounds.sel(value=value).transpose("bound", "f0").values
        middle = total.sel(value=value).values
        error = np.maximum([middle - low, high - middle], 0)
        look = {"color": colour, "marker": marker, "markersize": 3}
        ax.errorbar(f0.places, middle, error, elinewidth=0.5, **look)
        hollow = {"color": colour, "marker": marker, "markersize": 2.5, **FIRST}
        ax.plot(f0.places, first.sel(value=value).values, **hollow)
    cross(ax, f0.places[total.isnull().all("value").values], 0.02, "0.4")
    ax.set_ylim(-0.05, 1.1)
    ax.set_ylabel("share of the variance of the threshold")
    return ax


def sensitivity_keys(found: xr.Dataset) -> list[Line2D]:
    """The legend of `draw_sensitivity`."""
    looks = zip(found.value.values, _looks(found.value.size), strict=True)
    keys = [
        Line2D([], [], color=colour, marker=marker, markersize=3, label=words_of(value))
        for value, (colour, marker) in looks
    ]
    alone = Line2D([], [], color="0.4", marker="o", markersize=2.5, **FIRST)
    alone.set_label("alone (first order)")
    unknown = Line2D([], [], color="0.4", **MISSING, label="not known: few devices snap")
    return [*keys, alone, *[unknown] * bool(found.sensitivity.isnull().any())]


def words_of(value: str) -> str:
    """What a draw moves, in words: `thickness and depth`."""
    own = {"N": "$N$ of the shock", "duration": "duration of the pulse"}
    return " and ".join(own.get(key) or WORDS[key][0] for key in value.split("+"))


def draw_requirement(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the thresholds of the devices under one required pulse, and what meets it.

    found: of one requirement and C; shaded is where it fails
    """
    N_first, N = found.N_first_required.values, found.N_required.item()
    known = N_first[np.isfinite(N_first)]
    must = bool(found.must_snap)
    ends = np.array([*known, N])
    room = 0.05 * np.ptp(ends) or 0.05 * N
    low, high = max(ends.min() - room, 0), ends.max() + room
    ax.axvspan(*((N, high) if must else (low, N)), **FAILS)
    ax.hist(known, bins="sqrt", range=(low, high), color="#0072b2", alpha=0.8)
    ax.axvline(N, color="black", linewidth=0.8)
    words = "trips" if must else "does not trip"
    ax.set_title(
        f"{style.literal(found.requirement.item())}, {words}\n{place_text(found)}\n"
        f"met by {percents(found.share_meeting)} ({percents(*found.share_meeting_bound)})"
    )
    ax.set(xlim=(low, high), xlabel="threshold $N$ (multiples of $g$)", ylabel="devices")
    return ax


def each_share(found: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, xr.DataArray]]:
    """Name, share and bounds of each requirement, of beams that it leaves unbroken, and of all."""
    for name in found.requirement.values.tolist():
        one = found.sel(requirement=name)
        yield name, one.share_meeting, one.share_meeting_bound
        if "share_breaking" in found:
            bounds = 1 - one.share_breaking_bound.isel(bound=slice(None, None, -1))
            yield f"{name}, unbroken", 1 - one.share_breaking, bounds
    yield f"all together{left_out(found['yield'])}", found["yield"], found.yield_bound


def draw_yield(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the shares of devices that meet each requirement, and all of them, with their bounds.

    found: over requirements and C
    """
    names, shares, bounds = zip(*each_share(found), strict=True)
    shares = np.stack(shares)
    bounds = np.stack([one.transpose("bound", "C") for one in bounds], axis=1)
    rows = np.arange(len(names))
    for i, (_, colour, marker) in enumerate(each_line(found, "C")):
        y = rows + 0.7 * ((i + 0.5) / found.C.size - 0.5)
        error = abs(bounds[:, :, i] - shares[:, i])
        ax.errorbar(shares[:, i], y, xerr=error, color=colour, marker=marker, linestyle="")
        for at, share, ends in zip(y, shares[:, i], bounds[:, :, i].T, strict=True):
            words = f"{percents(share)} ({percents(*ends)})"
            ax.annotate(words, (1.03, at), va="center", fontsize=6)
    ax.axhline(rows[-1] - 0.5, color="0.6", linewidth=0.5)
    ax.set(xlim=(0, 1.3), ylim=(rows[-1] + 0.5, -0.5), xlabel="share of devices that meet it")
    ax.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1])
    ax.set_yticks(rows, [textwrap.fill(style.literal(name), NAME) for name in names])
    ax.tick_params(axis="y", which="minor", left=False)
    return ax


def requirement_keys(found: xr.Dataset) -> list[Artist]:
    """The legend of `draw_requirement` and `draw_yield`."""
    lines = [
        Line2D([], [], color=colour, marker=marker, label=value_text("C", one.C.item()))
        for one, colour, marker in each_line(found, "C")
    ]
    return [
        *lines,
        Patch(**FAILS, label="the requirement fails"),
        Line2D([], [], color="black", linewidth=0.8, label="required $N$"),
    ]


def batch_text(found: xr.Dataset, attributes: Mapping[str, str]) -> str:
    """How many devices were drawn, and by which model."""
    missing = int((found.bistable == 0).sum())
    lost = f", {missing} of them without a second stable shape" if missing else ""
    return f"{found.bistable.size} devices{lost}; {style.case(attributes)}"


def _looks(number):
    return (LOOKS * (-(-number // len(LOOKS))))[:number]

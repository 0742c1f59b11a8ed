"""The lowest N that snaps: over the frequency of the pulse, and as a damage boundary."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import style
from .curves import (
    LIMIT,
    curve_keys,
    damping_keys,
    draw_curve,
    draw_limits,
    each_damping,
    freeze,
    some_dampings,
    velocity_change,
)

DURATION = {"color": "0.6", "linewidth": 0.5, "linestyle": ":", "zorder": 1}
SHADE = {"color": "0.9", "linewidth": 0, "zorder": 0}
NOTE = {"fontsize": 6, "textcoords": "offset points"}
SYMBOLS = r"$C$ in µN µs µm$^{-1}$; $\Delta v$: velocity change, limit of short pulses"
ROOM = 0.15
"""For words below the lowest threshold, as a share of the height."""
FAR = 1e9
"""Beyond the edges of any axes, as a factor."""


def draw_thresholds(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw N_first over f0 (Hz) for each C, what snaps below N_always, and both limits.

    Of many values of C some are drawn, evenly chosen.
    """
    found = some_dampings(found)
    style.frequency_axis(ax)
    style.amplitude_axis(ax)
    ax.set_xlim(found.f0.values[0] / 1.1, found.f0.values[-1] * 1.1)
    for one, colour, marker in each_damping(found):
        _draw_gap(ax, one, colour)
        draw_curve(ax, one.f0.values, one, colour, marker)
    draw_limits(ax, found)
    _make_room(ax)
    _label_limits(ax, found)
    keys = [*damping_keys(found), *curve_keys(found, "0.4", "o"), *_gap_keys(found)]
    style.legend_below(ax, keys, _title(found, "; "), ncols=4)
    return ax


def draw_damage_boundary(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw N_first over the velocity change (m/s) for each C, and what snaps of the first one.

    Along dotted lines the duration of the pulse is constant. Of many values of C some are drawn.
    """
    found = some_dampings(found)
    ax.set_xscale("log")
    style.amplitude_axis(ax)
    ax.set_xlabel("velocity change $N g/2 f_0$ (m/s)")
    ax.set_ylabel("peak acceleration $N$ (multiples of $g$)")
    ax.xaxis.set_major_formatter("{x:g}")
    for one, colour, marker in each_damping(found):
        draw_curve(ax, velocity_change(one).values, one, colour, marker, size=2)
    _draw_boundary_limits(ax, found)
    _make_room(ax)
    _draw_region(ax, found.isel(C=0))
    _draw_durations(ax, found)
    region = Patch(**SHADE, label=f"snaps, $C$ = {found.C.values[0]:.4g}")
    keys = [*damping_keys(found), *curve_keys(found, "0.4", "o"), region]
    place = {"loc": "lower left", "bbox_to_anchor": (-0.16, 1.03), "ncols": 2}
    ax.legend(handles=keys, title=_title(found, "\n"), alignment="left", **place)
    return ax


def _make_room(ax):
    """Move the lower end of the axes down to make room for words."""
    ax.set_ylim(bottom=_height(ax, -ROOM))


def _height(ax, share):
    """The N at a share of the height of the axes."""
    low, high = ax.get_ylim()
    return low * (high / low) ** share


def _draw_gap(ax, found, colour):
    """Shade what lies between N_first and N_always of one C, and stroke the islands in it."""
    if not found.islands.any():
        return
    shade = {"color": colour, "alpha": 0.3, "linewidth": 0}
    ax.fill_between(found.f0.values, found.N_first.values, found.N_always.values, **shade)
    ends = xr.broadcast(found.f0, found.island_from, found.island_to)
    f0, low, high = (values.values.ravel() for values in ends)
    ax.vlines(f0, low, high, color=colour, linewidth=2.2, alpha=0.5)


def _label_limits(ax, found):
    static, v = found.N_static.item(), found.velocity_change.values.max()
    words = f"static limit of long pulses, $N$ = {static:.4g}"
    ax.annotate(words, (ax.get_xlim()[0], static), xytext=(4, -4), va="top", **NOTE)
    N = np.sqrt(static * ax.get_ylim()[0])
    words = "impulsive limit of short pulses,\n" + r"$N = 2 f_0\,\Delta v/g$"
    ax.annotate(
        words, (_frequency(found, N, v), N), xytext=(-6, 0), ha="right", va="center", **NOTE
    )


def _frequency(found, N, v):
    """Of the pulse of N with the velocity change v (m/s), Hz."""
    return N * found.gravity / (2e-6 * v)


def _draw_region(ax, found):
    """Shade all that snaps for one C: above its curve, and between its limits beyond the ends."""
    known = found.isel(f0=np.flatnonzero(found.N_first.notnull())).sortby("f0", ascending=False)
    N, v = known.N_first.values, velocity_change(known).values
    if N.size:
        short, static = found.velocity_change.item(), found.N_static.item()
        ax.fill([short, short, *v, FAR, FAR], [FAR, N[0], *N, static, FAR], **SHADE)


def _draw_boundary_limits(ax, found):
    ax.axhline(found.N_static.item(), **LIMIT)
    for v in found.velocity_change.values:
        ax.axvline(v, **LIMIT)
    freeze(ax)
    words = f"static, $N$ = {found.N_static.item():.4g}"
    at = found.velocity_change.values.max(), found.N_static.item()
    ax.annotate(words, at, xytext=(4, -4), va="top", **NOTE)


def _draw_durations(ax, found):
    """Draw lines of constant pulse duration, one for each decade of the frequencies looked at."""
    first, last = np.log10(found.f0.values[[0, -1]])
    for f0 in 10.0 ** np.arange(np.ceil(first), np.floor(last) + 1):
        v = found.gravity / (2e-6 * f0)
        ax.plot([v / FAR, v * FAR], [1 / FAR, FAR], **DURATION)
        _label_duration(ax, f"{1e3 / f0:g} ms", v)


def _label_duration(ax, words, v):
    """Write along the line of the velocity change v per N, at its top or its foot."""
    is_whole = v * ax.get_ylim()[1] < ax.get_xlim()[1]
    N, side = (_height(ax, 0.97), "right") if is_whole else (_height(ax, 0.02), "left")
    place = {"ha": side, "va": "bottom", "rotation_mode": "anchor"}
    turn = {"rotation": np.degrees(np.arctan(1 / v)), "transform_rotates_text": True}
    ax.text(v * N, N, words, fontsize=6, color="0.4", **place, **turn)


def _title(found, between):
    """What every curve has in common."""
    return between.join(filter(None, [style.case(found.attrs), SYMBOLS]))


def _gap_keys(found):
    if not found.islands.any():
        return []
    gap = Patch(color="0.5", alpha=0.3, linewidth=0, label="above it, some $N$ do not snap")
    island = Line2D([], [], color="0.5", linewidth=2.2, label="island of $N$ that snap")
    return [gap, island]

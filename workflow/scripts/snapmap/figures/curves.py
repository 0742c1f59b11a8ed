"""Curves of thresholds over an axis, and of their limits, with labels for a legend."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.markers import CARETUPBASE
from matplotlib.patheffects import withStroke

from ..files.text import plain
from ..numerics.portable import evenly
from . import style
from .scales import Scale, scale_of, value_text

COLOURS = "black", style.VERMILION, style.SKY, style.BLUE, style.GREEN, style.PINK, style.ORANGE
LOOKS = tuple(zip(COLOURS, "os^DvPX", strict=True))
"""Colours and markers of lines, in order; the first ones differ in grey, too."""
CURVES, MARKS = 6, 45
"""Most lines in a figure, and most markers and error bars on a curve."""
LONG, SHORT = "limit of long pulses", "limit of short pulses"
DASHES, DOT = {LONG: (8, 1.5), SHORT: (3, 1.5)}, (1, 1.5)
"""Lengths of dashes and dots: limits of line n have n dots after each dash."""
BAND = {"color": "0.25", "alpha": 0.35, "linewidth": 0, "label": "error of the threshold"}
HALO = {"path_effects": [withStroke(linewidth=2, foreground="white")]}
ALWAYS = {"color": "black", "linewidth": 0.8, "solid_capstyle": "butt", **HALO}
ALWAYS["label"] = "above it every $N$ snaps"
"""Looks of the band of errors around N_first on a map, and of N_always where it differs."""
STAYS = {"linestyle": "", "marker": CARETUPBASE, "markersize": 4.5, "markeredgewidth": 0.6}
"""Look of an N above which beams stay: the head of an arrow, which a marker below does not hide."""
VISIBLE = 0.7
"""Least distance that a reader sees, pt."""
MISSING = {"linestyle": "", "marker": "x", "markersize": 3, "markeredgewidth": 0.8}
FIRST_ROW, NEXT_ROW = 0.975, 0.03
"""Height of the crosses for missing points of the first line, and distance to those of the next."""
LATE = {"linestyle": "--", "markerfacecolor": "white", "markeredgewidth": 0.6}
LATE["label"] = "threshold, snap after the pulse"


def some_lines(thresholds: xr.Dataset, x: str, lines: str) -> xr.Dataset:
    """Sort thresholds along two axes, and keep at most CURVES values of `lines`, evenly chosen."""
    thresholds = thresholds.sortby(
        [key for key in (lines, x) if thresholds[key].dtype.kind in "fiu"]
    )
    return thresholds.isel({lines: evenly(thresholds.sizes[lines], CURVES)})


def each_line(thresholds: xr.Dataset, lines: str) -> Iterator[tuple[xr.Dataset, str, str]]:
    """Give the thresholds at each value of an axis, with a colour and a marker."""
    for i in range(thresholds.sizes[lines]):
        yield thresholds.isel({lines: i}), *LOOKS[i % len(LOOKS)]


def line_keys(thresholds: xr.Dataset, lines: str) -> Iterator[Line2D]:
    """Make keys of a legend for all lines, with the limit of short pulses if there is one."""
    for curve, colour, marker in each_line(thresholds, lines):
        v = curve.velocity_change
        label = value_text(lines, curve[lines].item(), unit="" if lines == "C" else None)
        if v.ndim == 0 and np.isfinite(v):
            label += f", $\\Delta v$ = {plain(v.item(), 3)} m/s"
        if curve.N_first.isnull().all():  # what `no_threshold` says in words
            continue
        yield Line2D([], [], color=colour, marker=marker, label=label)


def no_threshold(thresholds: xr.Dataset, lines: str) -> str:
    """Say in words which lines have no threshold at all; "" if some are on all, or on none."""
    none = thresholds.N_first.isnull().all([key for key in thresholds.N_first.dims if key != lines])
    texts = [value_text(lines, value) for value in thresholds[lines].values[none.values].tolist()]
    return f"no threshold: {', '.join(texts)}" if 0 < len(texts) < none.size else ""


def draw_curve(ax: Axes, x: np.ndarray, curve: xr.Dataset, colour: str, marker: str = "") -> None:
    """Draw N_first over x with error bars; a curve is dashed and hollow where the snap is late."""
    every = -(-x.size // MARKS)
    bars = {"linestyle": "", "elinewidth": 0.6, "errorevery": every}
    ax.errorbar(x, curve.N_first.values, _known_error(curve).values, color=colour, **bars)
    look = {"color": colour, "marker": marker, "markersize": 3.5}
    _draw_line(ax, x, curve, look, every)


def draw_band(ax: Axes, scale: Scale, curve: xr.Dataset) -> None:
    """Draw N_first over an axis in a band as wide as its error, and N_always where it differs.

    N_always is a level line across its part of the axis, halfway to its neighbours.
    """
    x, N, error = scale.places, curve.N_first.values, _known_error(curve)
    _draw_line(ax, x, curve, {"color": "black", **HALO}, label="threshold")
    low, high = N - error.values, N + error.values
    if is_seen(ax, low, high):
        ax.fill_between(x, low, high, **BAND)
    mark_missing(ax, x, curve, "black")
    always = curve.N_always.where(curve.N_always > curve.N_first + error.fillna(0)).values
    if is_seen(ax, N, always):
        steps = np.repeat(always, 3)
        steps[2::3] = np.nan  # between columns
        left, right = scale.edges[:-1], scale.edges[1:]
        ax.plot(np.ravel([left, right, right], "F"), steps, **ALWAYS)


def is_seen(ax: Axes, low: np.ndarray, high: np.ndarray) -> bool:
    """Tell whether some values of N are farther apart in axes than a thin line is wide."""
    places = [ax.transData.transform(np.stack([0 * N + 1, N], 1))[:, 1] for N in (low, high)]
    return bool(((places[1] - places[0]) * 72 / ax.get_figure().dpi >= VISIBLE).any())


def _draw_line(ax, x, curve, look, every=1, label=None):
    # A snap is late unless it was seen before the end of the pulse.
    N, in_pulse = curve.N_first.values, curve.t_snap <= 1e6 / curve.f0
    late = (curve.N_first.notnull() & ~in_pulse).values
    beside = np.convolve(late, [1, 1, 1])[1:-1] > 0
    marked = late & (np.arange(N.size) % every == 0)
    ax.plot(x, np.where(late, np.nan, N), markevery=every, label=label, **look)
    ax.plot(x, np.where(beside, N, np.nan), markevery=marked, **look, **LATE)


def _known_error(curve):
    return curve.N_error.where(np.isfinite(curve.N_error))


def mark_missing(ax: Axes, x: np.ndarray, curve: xr.Dataset, colour: str, place: int = 0) -> None:
    """Mark at the upper edge where a line has no threshold; place: index of the line."""
    missing = x[curve.N_first.isnull().values]
    if missing.size == x.size:
        return
    cross(ax, missing, FIRST_ROW - NEXT_ROW * place, colour, "no threshold here")


def cross(ax: Axes, x: np.ndarray, height: float, colour: str, label: str) -> None:
    """Draw crosses at some x, if there are any, at a share of the height of the axes."""
    if x.size:  # a layout cannot handle an empty line
        at = {"transform": ax.get_xaxis_transform(), "color": colour, "clip_on": False}
        ax.plot(x, np.full(x.size, height), label=label, **at, **MISSING)


def draw_static(ax: Axes, curve: xr.Dataset, x: str, colour: str = "0.4", place: int = 0) -> None:
    """Draw the limit of long pulses of a line over an axis; place: index of the line."""
    look, static = limit_look(LONG, colour, place), curve.N_static
    if x in static.dims:
        ax.plot(scale_of(x, curve[x].values).places, static.values, label=LONG, **look)
    elif np.isfinite(static):
        ax.axhline(static.item(), label=f"{LONG}, $N$ = {plain(static.item())}", **look)


def draw_impulsive(ax: Axes, curve: xr.Dataset, colour: str, place: int = 0) -> None:
    """Draw the limit of short pulses of a line over f0 (Hz), within the limits of the axes."""
    f0 = np.geomspace(*ax.get_xlim(), 200)
    slope = (1e-6 * curve.velocity_change / (curve.gravity * curve.area)).item()
    if np.isfinite(slope):
        look = limit_look(SHORT, colour, place) | {"label": SHORT, "scalex": False, "scaley": False}
        ax.plot(f0, f0 * slope, **look)


def limit_look(limit: str, colour: str, place: int) -> dict:
    """Give the look of LONG or SHORT of a line; place: index of the line."""
    dashes = (0, DASHES[limit] + DOT * (place + 1))
    look = {"color": colour, "linestyle": dashes, "linewidth": 0.6, "zorder": 1.5}
    return look | (HALO if colour == "black" else {})  # on a map, and in its legend on any paper


def velocity_change(curve: xr.Dataset) -> xr.DataArray:
    """Give the velocity change of the pulse at N_first, its area times N g / f0, m/s."""
    return curve.N_first * curve.gravity * curve.area / (1e-6 * curve.f0)

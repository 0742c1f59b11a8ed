"""Thresholds over one axis as a curve, their limits, and their keys in a legend."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .scales import WORDS, scale_of, value_text

LOOKS = (("C0", "o"), ("C6", "s"), ("C2", "^"), ("C5", "D"), ("C3", "v"), ("C7", "P"), ("C1", "X"))
"""Colour and marker of each line in turn; the first ones differ in grey, too."""
CURVES, MARKS = 6, 45
"""Most lines in one figure, and most markers and error bars on a curve."""
LIMIT = {"color": "0.4", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1.5}
LATE = {"linestyle": "--", "markerfacecolor": "white", "markeredgewidth": 0.6}


def draw_curve(
    ax: Axes, x: np.ndarray, found: xr.Dataset, colour: str, marker: str = "", size: float = 3.5
) -> None:
    """Draw N_first over x with error bars; dashed and hollow where the snap is late."""
    N, late = found.N_first.values, is_late(found).values
    beside = np.convolve(late, [1, 1, 1])[1:-1] > 0
    look = {"color": colour, "marker": marker, "markersize": size}
    every = -(-N.size // MARKS)
    error = found.N_error.where(np.isfinite(found.N_error)).values
    ax.errorbar(x, N, error, linestyle="", color=colour, elinewidth=0.6, errorevery=every)
    marked = late & (np.arange(N.size) % every == 0)
    ax.plot(x, np.where(beside, N, np.nan), markevery=marked, **look, **LATE)
    ax.plot(x, np.where(late, np.nan, N), markevery=every, **look)


def draw_limits(ax: Axes, found: xr.Dataset, x: str = "f0") -> None:
    """Draw the limit of long pulses and, over f0 (Hz), that of short ones; the axes stay.

    found: of one line or of several
    """
    if x != "f0":
        line = found.N_static
        if x in line.dims:
            ax.plot(scale_of(x, found[x].values).places, line.transpose(x, ...), **LIMIT)
        else:
            _draw_levels(ax, line)
        return
    _draw_levels(ax, found.N_static)
    freeze(ax)
    f0 = np.geomspace(*ax.get_xlim(), 200)
    slopes = 1e-6 * found.velocity_change / (found.gravity * found.area)
    for slope in slopes.values[np.isfinite(slopes.values)]:
        ax.plot(f0, f0 * slope, **LIMIT)


def _draw_levels(ax, static):
    for N in np.unique(static.values[np.isfinite(static.values)]):
        ax.axhline(N, **LIMIT)


def is_late(found: xr.Dataset) -> xr.DataArray:
    """Whether the snap at N_first was not seen before the end of the pulse."""
    return found.N_first.notnull() & ~(found.t_snap <= 1e6 / found.f0)


def velocity_change(found: xr.Dataset) -> xr.DataArray:
    """Velocity change of the pulse at N_first, its area times N g / f0, m/s."""
    return found.N_first * found.gravity * found.area / (1e-6 * found.f0)


def curve_keys(found: xr.Dataset, colour: str, marker: str = "") -> list[Line2D]:
    """Keys of a legend for the ways in which `draw_curve` draws N_first that there are."""
    late = is_late(found)
    look = {"color": colour, "marker": marker}
    during = Line2D([], [], **look, label="lowest $N$ that snaps")
    after = Line2D([], [], **look, **LATE, label="the same, after the pulse")
    return [during] * bool((found.N_first.notnull() & ~late).any()) + [after] * bool(late.any())


def limit_key(label: str = "static, impulsive limits") -> Line2D:
    """Key of a legend for what `draw_limits` draws."""
    return Line2D([], [], **LIMIT, label=label)


def freeze(ax: Axes) -> None:
    """Keep the limits of the axes, whatever is drawn next."""
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())


def some_lines(found: xr.Dataset, x: str, lines: str) -> xr.Dataset:
    """The thresholds in order of two axes, for CURVES values of `lines` at most, evenly chosen."""
    found = found.sortby([key for key in (lines, x) if found[key].dtype.kind in "fiu"])
    size = found.sizes[lines]
    return found.isel({lines: np.linspace(0, size - 1, min(size, CURVES)).round().astype(int)})


def each_line(found: xr.Dataset, lines: str) -> Iterator[tuple[xr.Dataset, str, str]]:
    """The thresholds at every value of an axis, with a colour and a marker."""
    for i in range(found.sizes[lines]):
        yield found.isel({lines: i}), *LOOKS[i % len(LOOKS)]


def line_keys(found: xr.Dataset, lines: str) -> Iterator[Line2D]:
    """Keys of a legend for every line, with the velocity change in the limit of short pulses."""
    for one, colour, marker in each_line(found, lines):
        v = one.velocity_change
        label = value_text(lines, one[lines].item()).replace(WORDS["C"][1], "").strip()
        label += f", $\\Delta v$ = {v.item():.3g} m/s" if v.ndim == 0 else ""
        yield Line2D([], [], color=colour, marker=marker, label=label)

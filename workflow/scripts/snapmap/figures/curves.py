"""The threshold of one C as a curve, its limits, and their keys in a legend."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

LOOKS = (("C0", "o"), ("C6", "s"), ("C2", "^"), ("C5", "D"), ("C3", "v"), ("C7", "P"), ("C1", "X"))
"""Colour and marker of each C in turn; the first ones differ in grey, too."""
CURVES, MARKS = 6, 45
"""Most values of C in one figure, and most markers and error bars on a curve."""
LIMIT = {"color": "0.4", "linewidth": 0.6, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 1.5}
LATE = {"linestyle": "--", "markerfacecolor": "white", "markeredgewidth": 0.6}


def draw_curve(
    ax: Axes, x: np.ndarray, found: xr.Dataset, colour: str, marker: str = "", size: float = 3.5
) -> None:
    """Draw N_first of one C over x with error bars; dashed and hollow where the snap is late."""
    N, late = found.N_first.values, is_late(found).values
    beside = np.convolve(late, [1, 1, 1])[1:-1] > 0
    look = {"color": colour, "marker": marker, "markersize": size}
    every = -(-N.size // MARKS)
    error = found.N_error.where(np.isfinite(found.N_error)).values
    ax.errorbar(x, N, error, linestyle="", color=colour, elinewidth=0.6, errorevery=every)
    marked = late & (np.arange(N.size) % every == 0)
    ax.plot(x, np.where(beside, N, np.nan), markevery=marked, **look, **LATE)
    ax.plot(x, np.where(late, np.nan, N), markevery=every, **look)


def draw_limits(ax: Axes, found: xr.Dataset) -> None:
    """Draw the limits of long and of short pulses over f0 (Hz), within the axes as they are."""
    ax.axhline(found.N_static.item(), **LIMIT)
    freeze(ax)
    f0 = np.geomspace(*ax.get_xlim(), 200)
    for v in np.atleast_1d(found.velocity_change):
        ax.plot(f0, 2e-6 * f0 * v / found.gravity, **LIMIT)


def is_late(found: xr.Dataset) -> xr.DataArray:
    """Whether the snap at N_first was not seen before the end of the pulse."""
    return found.N_first.notnull() & ~(found.t_snap <= 1e6 / found.f0)


def velocity_change(found: xr.Dataset) -> xr.DataArray:
    """Velocity change N g / (2 f0) of the pulse at N_first, m/s."""
    return found.N_first * found.gravity / (2e-6 * found.f0)


def curve_keys(found: xr.Dataset, colour: str, marker: str = "") -> list[Line2D]:
    """Keys of a legend for the ways in which `draw_curve` draws N_first that there are."""
    late = is_late(found)
    look = {"color": colour, "marker": marker}
    during = Line2D([], [], **look, label="lowest $N$ that snaps")
    after = Line2D([], [], **look, **LATE, label="the same, after the pulse")
    return [during] * bool((found.N_first.notnull() & ~late).any()) + [after] * bool(late.any())


def limit_key() -> Line2D:
    """Key of a legend for what `draw_limits` draws."""
    return Line2D([], [], **LIMIT, label="static, impulsive limits")


def freeze(ax: Axes) -> None:
    """Keep the limits of the axes, whatever is drawn next."""
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())


def some_dampings(found: xr.Dataset) -> xr.Dataset:
    """The thresholds in order of C and f0, for CURVES values of C at most, evenly chosen."""
    found = found.sortby(["C", "f0"])
    chosen = np.linspace(0, found.C.size - 1, min(found.C.size, CURVES)).round().astype(int)
    return found.isel(C=chosen)


def each_damping(found: xr.Dataset) -> Iterator[tuple[xr.Dataset, str, str]]:
    """Every C of the thresholds, with its colour and marker."""
    for i in range(found.C.size):
        yield found.isel(C=i), *LOOKS[i % len(LOOKS)]


def damping_keys(found: xr.Dataset) -> Iterator[Line2D]:
    """Keys of a legend for every C, with the velocity change in the limit of short pulses."""
    for one, colour, marker in each_damping(found):
        v = one.velocity_change.item()
        label = f"$C$ = {one.C.item():.4g}, $\\Delta v$ = {v:.3g} m/s"
        yield Line2D([], [], color=colour, marker=marker, label=label)

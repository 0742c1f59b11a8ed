"""The beam pushed slowly from its first shape to the second: force and energy."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...figures import style
from ...files.text import plain

TAKEN = {"color": style.BLUE, "linewidth": 1.2, "label": "path of the beam"}
GUIDED = {"color": style.SKY, "linestyle": ":", "label": "path of a guided beam"}
UNBRANCHED = {"color": style.VERMILION, "linestyle": "--"}
UNBRANCHED["label"] = "second mode suppressed (not physical)"
BEYOND = 0.5
"""Part of the heights of real paths by which the axes go further, for the one that is not."""
MARGIN = 0.12
STABLE = {"color": "black", "marker": "o", "markersize": 4, "linestyle": "", "zorder": 3}
UNSTABLE = STABLE | {"markerfacecolor": "white"}
PEAK = {"color": "0.4", "linewidth": 0.5, "linestyle": ":", "zorder": 0}
NOTE = {"textcoords": "offset points", "fontsize": 6}


def draw(figure: Figure, statics: xr.Dataset) -> None:
    """Draw force and energy over the displacement, one above the other, with their legend."""
    force, energy = figure.subplots(2, sharex=True, height_ratios=[3, 2])
    draw_force_displacement(force, statics)
    draw_energy(energy, statics)
    for ax, values in ((force, statics.force), (energy, statics.energy)):
        style.note_missing(ax, values, "no path of the beam is known")
    force.label_outer()
    style.legend(figure, style.labelled([force]), ncols=2)


def draw_force_displacement(ax: Axes, statics: xr.Dataset) -> Axes:
    """Draw the force (uN) over the displacement of the midpoint (um), its peak and its trough."""
    _draw_branches(ax, statics, statics.force, np.zeros(3))
    ax.axhline(0, color="0.6", linewidth=0.5, zorder=0)
    largest = statics.largest_force, r"F_\mathrm{max}", 1, (-3, 2), {"ha": "right", "va": "bottom"}
    least = statics.least_force, r"F_\mathrm{min}", 0, (3, -3), {"ha": "left", "va": "top"}
    for force, symbol, end, offset, side in (largest, least):
        if np.isnan(force):
            continue
        ax.axhline(force, **PEAK)
        words = f"${symbol}$ = {plain(force.item())} µN".replace("-", "−")
        ax.annotate(words, (end, force), offset, ("axes fraction", "data"), **side, **NOTE)
    ax.set_ylabel("force on the midpoint (µN)")
    return ax


def draw_energy(ax: Axes, statics: xr.Dataset) -> Axes:
    """Draw the energy of the beam (pJ) over the displacement of the midpoint (um), and the barrier.

    statics: as for `draw_force_displacement`
    """
    taken = statics.isel(branch=0).sortby("displacement")
    second = np.interp(statics.rise - statics.second_equilibrium, taken.displacement, taken.energy)
    _draw_branches(ax, statics, statics.energy, [0, statics.barrier.item(), second])
    ax.set_ylabel("energy of the beam (pJ)")
    if statics.barrier > 0:
        at, words = statics.rise - statics.saddle, f"barrier\n{plain(statics.barrier.item())} pJ"
        ax.vlines(at, 0, statics.barrier, **PEAK)
        beside = {"ha": "right", "va": "center"}
        ax.annotate(words, (at, statics.barrier / 3), (-3, 0), **beside, **NOTE)
    return ax


def _draw_branches(ax, statics, values, heights):
    """Draw each path, and mark the first shape, the saddle and the second shape at heights.

    The axes go as far as real paths do, and a little further.
    """
    displacement, is_real = statics.displacement, values.branch != "unbranched"
    real = np.append(values.where(is_real).values.ravel(), heights)
    low, high = np.nanmin(real), np.nanmax(real)
    reach = BEYOND * (high - low)
    is_cut = (values < low - reach) | (values > high + reach)
    looks = {"unbranched": UNBRANCHED, "guided": GUIDED, displacement.branch.item(0): TAKEN}
    for branch, look in looks.items():
        if branch in displacement.branch:
            words = f"{look['label']}{', cut off' if is_cut.sel(branch=branch).any() else ''}"
            line = values.sel(branch=branch)
            ax.plot(displacement.sel(branch=branch), line, **look | {"label": words})
    ax.margins(y=MARGIN)
    if is_cut.any():
        ax.set_ylim(low - reach, high + reach)
    ax.set_xlabel("displacement of the midpoint, downward (µm)")
    places = 0, statics.rise - statics.saddle, statics.rise - statics.second_equilibrium
    stable = slice(0, None, 2) if statics.barrier > 0 else slice(1)
    ax.plot(places[stable], heights[stable], **STABLE, label="stable shape")
    if statics.barrier > 0:
        ax.plot(places[1], heights[1], **UNSTABLE, label="saddle")

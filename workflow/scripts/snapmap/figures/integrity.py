"""Integrity of maps: distances to another label, their erosion over N, uncertain boxes."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..basins.integrity import SAFE
from . import style
from .scales import frequency_axis, place_text, scale_of, set_scale, tick_log

WORDS = {"snaps": "snaps (orange) or not (blue)", "ends": "ends tripped (orange) or not (blue)"}
COLOURS = "Oranges", "Blues"
"""Of the distances of what is tripped, and of what is not; both reach equally far."""
ENTROPIES = {"basin_entropy": "basin", "boundary_entropy": "boundary", "disk_entropy": "disk"}
SHARE = {"color": "black", "label": "share"}
DISTANCE = {"color": "#0b4a8f", "linestyle": "--", "label": "distance"}
NOTE = {"xycoords": "axes fraction", "fontsize": 6, "va": "bottom"}


def draw_distances(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the distance of each cell to another label, over f0 and N, in the colour of its own."""
    ax.set_title(f"{WORDS[found.labels.item()]}\n{place_text(found.drop_vars('labels'))}")
    f0, N = scale_of("f0", found.f0.values), scale_of("N", found.N.values)
    frequency_axis(ax, f0.values)
    set_scale(ax, "y", N)
    distance = found.integrity.where(np.isfinite(found.integrity), 1.0).transpose("N", "f0")
    safe = (found.basins == SAFE).transpose("N", "f0")
    top = distance.max().item()
    for colours, own in zip(COLOURS, (~safe, safe), strict=True):
        # From below zero, so that a cell at the boundary is not white.
        look = {"cmap": colours, "vmin": -0.2 * top, "vmax": top, "edgecolors": "face"}
        drawn = ax.pcolormesh(
            f0.edges, N.edges, distance.where(own).values, rasterized=True, **look
        )
    bar = ax.get_figure().colorbar(drawn, ax=ax, label="distance to the other", pad=0.02)
    bar.ax.set_ylim(0, top)
    return ax


def draw_erosion(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw over N the share of the frequencies that are safe, and their largest distance."""
    set_scale(ax, "x", scale_of("N", found.N.values))
    ax.plot(found.N, found.safe_share, **SHARE)
    ax.plot(found.N, found.safe_distance.where(np.isfinite(found.safe_distance)), **DISTANCE)
    ax.set(ylim=(-0.03, 1.05), ylabel="of what is not tripped")
    ax.legend(loc="upper right", bbox_to_anchor=(0.98, 0.95))
    return ax


def draw_uncertainty(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the share of windows that are uncertain over their size; note exponent and entropies."""
    known = found.isel(window=np.flatnonzero(found.uncertain_share > 0))
    size, share = known.window.values - 1, known.uncertain_share.values
    words = ["one label alone"]
    if size.size > 1:
        slope, error = found.uncertainty_exponent.item(), found.uncertainty_exponent_error.item()
        line = np.exp(np.log(share).mean() + slope * (np.log(size) - np.log(size).mean()))
        ax.loglog(size, share, marker="o", linestyle="", color="black", markersize=2.5)
        ax.plot(size, line, color="0.5")
        tick_log(ax.xaxis, size[[0, -1]], 2.0)
        ax.set_title(f"exponent {slope:.2f} ± {error:.1g}")
        words = [f"{name} entropy {found[key].item():.3f}" for key, name in ENTROPIES.items()]
    ax.annotate("\n".join(words), (0.96, 0.04), ha="right", **NOTE)
    ax.set(xlabel="width of the window (cells)", ylabel="share with several labels")
    return ax


def draw_integrity(found: xr.Dataset, places: list[dict]) -> Figure:
    """Draw all three for each of some places on the further axes, a row each; returns the figure.

    places: index of each axis but f0 and N
    """
    figure = style.double_column(height=2.35 * len(places))
    axes = figure.subplots(len(places), 3, squeeze=False, width_ratios=[1.5, 1, 1])
    for row, at in zip(axes, places, strict=True):
        here = found.isel(at)
        for ax, draw in zip(row, (draw_distances, draw_erosion, draw_uncertainty), strict=True):
            draw(ax, here)
    return figure

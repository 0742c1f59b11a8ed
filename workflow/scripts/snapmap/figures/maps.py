"""The map of one C: the outcome of every cell of the (f0, N) plane."""

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch, Rectangle
from matplotlib.transforms import ScaledTranslation

from ..quantity import read
from .style import damping

COLOURS = {
    "unsnapped": "#eef4f8",
    "never": "#bdd3e3",
    "snapped": "#e69f00",
    "latched": "#d55e00",
    "returned": "#5d3a8c",
    "failed": "#000000",
}
"""Ever darker, so that a grey print keeps the classes apart."""

HATCHED = {"facecolor": "none", "edgecolor": "0.15", "hatch": "//////", "linewidth": 0}

WORDS = {
    "unsnapped": "no snap seen",
    "never": "never snaps",
    "snapped": "snaps",
    "latched": "snaps and stays",
    "returned": "snaps and returns",
    "failed": "failed",
}


def draw_map(ax: Axes, cells: xr.Dataset) -> Axes:
    """Draw the outcomes of one C over f0 (Hz) and N (multiples of g), and the threshold."""
    cells = cells.sortby(["f0", "N"])
    ax.set_xscale("log")
    _draw_cells(ax, cells)
    _draw_unreproduced(ax, cells)
    _draw_failed(ax, cells)
    _draw_threshold(ax, cells)
    _label_axes(ax, cells)
    ax.set_title(_caption(cells))
    _draw_legend(ax, cells)
    return ax


def arithmetic_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values: halfway between neighbours; (n + 1,)."""
    if values.size == 1:
        half = abs(values[0]) / 10 or 0.5
        return values + np.array([-half, half])
    middle = (values[:-1] + values[1:]) / 2
    return np.array([2 * values[0] - middle[0], *middle, 2 * values[-1] - middle[-1]])


def geometric_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values above 0: geometric means; (n + 1,)."""
    if values.size == 1:
        return values * np.array([1 / 1.1, 1.1])
    middle = np.sqrt(values[:-1] * values[1:])
    return np.array([values[0] ** 2 / middle[0], *middle, values[-1] ** 2 / middle[-1]])


def lowest_snap(cells: xr.Dataset) -> np.ndarray:
    """Edge below the lowest N that snaps, for each f0, in multiples of g; ascending N.

    NaN where the grid does not show it: nothing snaps, the first N does, or a failure lies below.
    """
    outcome, codes = cells.outcome.transpose("f0", "N").values, _codes(cells)
    quiet = np.isin(outcome, [codes["unsnapped"], codes["never"]])
    below = np.logical_and.accumulate(quiet, axis=1).sum(axis=1)
    last = outcome.shape[1] - 1
    first_other = outcome[np.arange(below.size), np.minimum(below, last)]
    shown = (below > 0) & (below <= last) & (first_other != codes["failed"])
    return np.where(shown, arithmetic_edges(cells.N.values)[below], np.nan)


def _draw_cells(ax, cells):
    codes = _codes(cells)
    edges = np.array([-0.5, *(code + 0.5 for code in codes.values())])
    ax.pcolormesh(
        geometric_edges(cells.f0.values),
        arithmetic_edges(cells.N.values),
        cells.outcome.transpose("N", "f0").values,
        cmap=ListedColormap([COLOURS[name] for name in codes]),
        norm=BoundaryNorm(edges, len(codes)),
        edgecolors="face",  # viewers show the paper between cells that merely touch
        linewidth=0.2,
        antialiased=True,
    )


def _draw_unreproduced(ax, cells):
    """Hatch the cells whose outcome another step did not reproduce."""
    j, i = np.nonzero(~_reproduced(cells))
    x, y = geometric_edges(cells.f0.values), arithmetic_edges(cells.N.values)
    corners = zip(x[i], y[j], np.diff(x)[i], np.diff(y)[j], strict=True)
    patches = [Rectangle((left, low), width, height) for left, low, width, height in corners]
    ax.add_collection(PatchCollection(patches, **HATCHED))


def _reproduced(cells):
    """Whether each cell, (N, f0), was reproduced; True where no second run was made."""
    if "reproduced" not in cells:
        return np.ones((cells.sizes["N"], cells.sizes["f0"]), bool)
    return cells.reproduced.transpose("N", "f0").values == 1


def _draw_failed(ax, cells):
    """Cross out each failed cell, as one alone is too small to see on a fine grid."""
    i, j = np.nonzero((cells.outcome.transpose("f0", "N") == _codes(cells)["failed"]).values)
    for colour, width in {"white": 2.0, COLOURS["failed"]: 0.8}.items():
        cross = {"marker": "x", "color": colour, "markeredgewidth": width}
        ax.plot(cells.f0.values[i], cells.N.values[j], linestyle="", **cross)


def _draw_threshold(ax, cells):
    threshold = lowest_snap(cells)
    if not np.isnan(threshold).all():
        edges = geometric_edges(cells.f0.values)
        label = "lowest $N$ that snaps"
        ax.stairs(threshold, edges, baseline=None, color="black", linewidth=1.0, label=label)


def _label_axes(ax, cells):
    ax.set_xlabel("pulse frequency $f_0$ (Hz)")
    ax.set_ylabel("pulse amplitude $N$ (multiples of $g$)")
    top = ax.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
    top.set_xlabel("pulse duration $1/f_0$ (ms)")
    _mark_alone(ax.xaxis, cells.f0.values)
    _mark_alone(ax.yaxis, cells.N.values)
    _mark_alone(top.xaxis, _reciprocal(cells.f0.values), digits=3)


def _mark_alone(axis, values, digits=6):
    """Give an axis of one value no other tick: how far its cells reach means nothing."""
    if values.size == 1:
        axis.set_ticks(values, [f"{values[0]:.{digits}g}"])
        axis.set_ticks([], minor=True)


def _reciprocal(values):
    """1/f0 in ms from f0 in Hz, and back; matplotlib asks for it at 0, too."""
    with np.errstate(divide="ignore"):
        return 1e3 / np.asarray(values)


def _caption(cells):
    caption = damping(cells.C.item())
    if "config" not in cells.attrs:
        return caption
    config = json.loads(cells.attrs["config"])
    horizon = read(config["sweep"]["horizon"], "duration")
    return f"{caption}\n{config['model']['name']} model, followed {horizon:g} µs beyond the pulse"


def _draw_legend(ax, cells):
    """List the classes that are there, and the threshold, below the axis' own labels."""
    below = ScaledTranslation(0, -30 / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=[*_class_patches(cells), *ax.get_legend_handles_labels()[0], *_hatched(cells)],
        title="outcome (number of cells)",
        ncols=2,
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=ax.transAxes + below,
    )


def _hatched(cells):
    """A labelled patch for the cells that were not reproduced, if there are any."""
    count = np.count_nonzero(~_reproduced(cells))
    return [Patch(**HATCHED, label=f"not reproduced ({count})")] if count else []


def _class_patches(cells):
    """A labelled patch for each class that is there."""
    outcome = cells.outcome.values
    counts = {name: np.count_nonzero(outcome == code) for name, code in _codes(cells).items()}
    return [
        Patch(facecolor=COLOURS[name], edgecolor="black", label=f"{WORDS[name]} ({count})")
        for name, count in counts.items()
        if count
    ]


def _codes(cells):
    """The code of each outcome by its name, in ascending order."""
    attributes = cells.outcome.attrs
    names = attributes["flag_meanings"].split()
    return dict(zip(names, np.atleast_1d(attributes["flag_values"]).tolist(), strict=True))

"""The map of one C: the outcome of every cell of the (f0, N) plane."""

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from .style import typeset

COLOURS = {
    "unsnapped": "#eef4f8",
    "never": "#bdd3e3",
    "snapped": "#e69f00",
    "latched": "#d55e00",
    "returned": "#5d3a8c",
    "failed": "#000000",
}
"""Ever darker, so that a grey print keeps the classes apart."""

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
    mesh = _draw_cells(ax, cells)
    lines = _draw_threshold(ax, cells)
    _label_axes(ax)
    ax.set_title(_caption(cells))
    _draw_legend(ax, [*_count_classes(cells, mesh), *lines])
    return ax


def arithmetic_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values: halfway between neighbours; (n + 1,)."""
    if values.size == 1:
        half = abs(values[0]) / 10 or 0.5
        return values + [-half, half]
    middle = (values[:-1] + values[1:]) / 2
    return np.array([2 * values[0] - middle[0], *middle, 2 * values[-1] - middle[-1]])


def geometric_edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about n ascending values above 0: geometric means; (n + 1,)."""
    if values.size == 1:
        return values * [1 / 1.1, 1.1]
    middle = np.sqrt(values[:-1] * values[1:])
    return np.array([values[0] ** 2 / middle[0], *middle, values[-1] ** 2 / middle[-1]])


def lowest_snap(cells: xr.Dataset) -> np.ndarray:
    """Edge below the lowest N that snaps, for each f0, in multiples of g; ascending N.

    NaN where the grid does not show it: nothing snaps, the first N does, or a failure lies below.
    """
    outcome, code = cells.outcome.transpose("f0", "N").values, _codes(cells)
    quiet = np.isin(outcome, [code["unsnapped"], code["never"]])
    below = np.logical_and.accumulate(quiet, axis=1).sum(axis=1)
    following = outcome[np.arange(below.size), np.minimum(below, outcome.shape[1] - 1)]
    seen = (below > 0) & ~np.isin(following, [code["unsnapped"], code["never"], code["failed"]])
    return np.where(seen, arithmetic_edges(cells.N.values)[below], np.nan)


def _draw_cells(ax, cells) -> QuadMesh:
    codes = _codes(cells)
    edges = np.array([-0.5, *(code + 0.5 for code in codes.values())])
    return ax.pcolormesh(
        geometric_edges(cells.f0.values),
        arithmetic_edges(cells.N.values),
        cells.outcome.transpose("N", "f0").values,
        cmap=ListedColormap([COLOURS[name] for name in codes]),
        norm=BoundaryNorm(edges, len(codes)),
        edgecolors="face",
        linewidth=0.1,
    )


def _draw_threshold(ax, cells):
    """Draw the threshold as steps, in a list; an empty one where the grid shows none."""
    threshold = lowest_snap(cells)
    if np.isnan(threshold).all():
        return []
    return [
        ax.stairs(
            threshold,
            geometric_edges(cells.f0.values),
            baseline=None,
            color="black",
            linewidth=1.0,
            label="lowest $N$ that snaps",
        )
    ]


def _label_axes(ax):
    ax.set_xlabel("pulse frequency $f_0$ (Hz)")
    ax.set_ylabel("pulse amplitude $N$ (multiples of $g$)")
    top = ax.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
    top.set_xlabel("pulse duration $1/f_0$ (ms)")


def _reciprocal(values):
    """1/f0 in ms from f0 in Hz, and back; matplotlib asks for it at 0, too."""
    with np.errstate(divide="ignore"):
        return 1e3 / np.asarray(values)


def _caption(cells):
    settings = json.loads(cells.attrs.get("config", "{}"))
    caption = f"$C$ = {cells.C.item():g} {typeset(cells.C.attrs.get('units', ''))}"
    if "model" not in settings:
        return caption
    horizon = _horizon(settings)
    return f"{caption}\n{settings['model']['name']} model, followed {horizon} beyond the pulse"


def _horizon(settings):
    """Text with a unit: `sweep` keeps a number of us, the pipeline its config's own words."""
    if "horizon" in settings:
        return typeset(f"{settings['horizon']:g} us")
    return typeset(settings["sweep"]["horizon"])


def _count_classes(cells, mesh):
    """A patch for the legend for each class present."""
    patches = []
    for name, code in _codes(cells).items():
        count = int((cells.outcome == code).sum())
        if count:
            words = f"{WORDS[name]} ({count} cell{'s' if count > 1 else ''})"
            patches.append(Patch(facecolor=COLOURS[name], edgecolor="black", label=words))
    return patches


def _draw_legend(ax, handles):
    below = ScaledTranslation(0, -30 / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=handles,
        ncols=2,
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=ax.transAxes + below,
    )


def _codes(cells):
    """The code of each outcome by its name, in ascending order."""
    attributes = cells.outcome.attrs
    names = attributes["flag_meanings"].split()
    return dict(zip(names, np.atleast_1d(attributes["flag_values"]).tolist(), strict=True))

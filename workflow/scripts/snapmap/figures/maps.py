"""Maps of the (f0, N) plane: the outcome of every cell, and where snapping begins."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from . import style
from .curves import curve_keys, draw_curve, draw_limits, freeze, limit_key

COLOURS = {
    "unsnapped": "#eef4f8",
    "never": "#bdd3e3",
    "snapped": "#e69f00",
    "latched": "#d55e00",
    "returned": "#5d3a8c",
    "failed": "#000000",
}
"""Ever darker, so that a grey print keeps the classes apart."""

OPEN = {"hatch": "." * 5, "hatchcolor": "0.35"}
UNREPRODUCED = {"hatch": "/" * 14, "hatchcolor": "0.1"}
UNREPRODUCED_DARK = UNREPRODUCED | {"hatchcolor": "0.8"}
"""Hatches of what is open, and of what another step did not reproduce, on light and dark."""
STILL_OPEN, DARK = ("unsnapped", "snapped"), ("returned", "failed")

WORDS = {
    "unsnapped": "no snap, end open",
    "never": "never snaps",
    "snapped": "snaps, end open",
    "latched": "snaps and stays",
    "returned": "snaps and returns",
    "failed": "failed",
}
TITLE = "outcome (number of cells)"
COLUMNS, PANELS = 3, 12
"""Maps side by side, and most in one figure."""
RESOLVED, VECTORS = 700, 100_000
"""Most cells drawn along an axis, finer than print; and most drawn as vectors."""


def draw_map(ax: Axes, cells: xr.Dataset, found: xr.Dataset | None = None) -> Axes:
    """Draw the outcomes of one C over f0 (Hz) and N (multiples of g).

    found: thresholds of the same C, drawn with their limits
    """
    _draw_panel(ax, cells, found)
    ax.set_title("\n".join([style.damping(cells.C.item()), style.case(cells.attrs)]).strip())
    style.legend_below(ax, [*_cell_keys(cells), *_threshold_keys(found)], TITLE, ncols=2)
    return ax


def draw_maps(figure: Figure, cube: xr.Dataset, found: xr.Dataset | None = None) -> np.ndarray:
    """Draw the map of every C on an empty figure, and one legend; returns the axes.

    found: thresholds of the same C, drawn with their limits
    Of more than PANELS values of C, as many are drawn, evenly chosen.
    """
    chosen = np.unique(np.linspace(0, cube.C.size - 1, PANELS).round().astype(int))
    cube, found = (one if one is None else one.isel(C=chosen) for one in (cube, found))
    columns = min(cube.C.size, COLUMNS)
    shape = -(-cube.C.size // columns), columns
    axes = figure.subplots(*shape, sharey=True, squeeze=False)
    for ax in axes.flat[cube.C.size :]:
        ax.set_axis_off()
    for i in range(cube.C.size):
        _draw_panel(axes.flat[i], cube.isel(C=i), None if found is None else found.isel(C=i))
        axes.flat[i].set_title(style.damping(cube.C.values[i]))
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    for ax in (ax for row in axes[1:] for ax in row if ax.child_axes):
        ax.child_axes[0].set_visible(False)
    keys = [*_cell_keys(cube), *_threshold_keys(found)]
    title = "; ".join(filter(None, [TITLE, style.case(cube.attrs)]))
    figure.legend(handles=keys, title=title, ncols=4, loc="outside lower center")
    return axes


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


def _draw_panel(ax, cells, found):
    cells = _thin(cells.sortby(["f0", "N"]))
    top = style.frequency_axis(ax)
    ax.set_ylabel("pulse amplitude $N$ (multiples of $g$)")
    _draw_cells(ax, cells)
    _draw_hatches(ax, cells)
    _draw_failed(ax, cells)
    _mark_alone(ax.xaxis, cells.f0.values)
    _mark_alone(ax.yaxis, cells.N.values)
    _mark_alone(top.xaxis, 1e3 / cells.f0.values, digits=3)
    if found is not None:
        _draw_threshold(ax, found.sortby("f0"))


def _thin(cells):
    """Keep every nth f0 and every mth N, at most RESOLVED of each."""
    strides = {key: -(-cells.sizes[key] // RESOLVED) for key in ("f0", "N")}
    return cells.isel({key: slice(None, None, stride) for key, stride in strides.items()})


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
        rasterized=cells.outcome.size > VECTORS,
    )


def _draw_hatches(ax, cells):
    """Hatch what is open, and what another step did not reproduce, each as one region."""
    x, y = geometric_edges(cells.f0.values), arithmetic_edges(cells.N.values)
    other, dark = _is_unreproduced(cells), _is_one_of(cells, DARK)
    dots = _is_one_of(cells, STILL_OPEN), OPEN
    for chosen, look in (dots, (other & ~dark, UNREPRODUCED), (other & dark, UNREPRODUCED_DARK)):
        i, low, high = _runs(chosen.transpose("f0", "N").values)
        corners = [(x[i], y[low]), (x[i + 1], y[low]), (x[i + 1], y[high]), (x[i], y[high])]
        if i.size:
            region = Path.make_compound_path_from_polys(np.moveaxis(corners, 2, 0))
            ax.add_patch(PathPatch(region, facecolor="none", linewidth=0, **look))


def _runs(chosen):
    """Row, start and end of each run of chosen cells along the rows."""
    changes = np.diff(np.pad(chosen.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    (row, start), (_, end) = np.nonzero(changes == 1), np.nonzero(changes == -1)
    return row, start, end


def _is_one_of(cells, names):
    return cells.outcome.isin([_codes(cells)[name] for name in names])


def _is_unreproduced(cells):
    """Nowhere where no second run was made."""
    return cells.get("reproduced", xr.ones_like(cells.outcome)) != 1


def _draw_failed(ax, cells):
    """Cross out each failed cell, as one alone is too small to see on a fine grid."""
    i, j = np.nonzero((cells.outcome.transpose("f0", "N") == _codes(cells)["failed"]).values)
    for colour, width in {"white": 2.0, COLOURS["failed"]: 0.8}.items():
        cross = {"marker": "x", "color": colour, "markeredgewidth": width}
        ax.plot(cells.f0.values[i], cells.N.values[j], linestyle="", **cross)


def _draw_threshold(ax, found):
    freeze(ax)
    draw_curve(ax, found.f0.values, found, "black")
    draw_limits(ax, found)


def _mark_alone(axis, values, digits=6):
    """Give an axis of one value no other tick: how far its cells reach means nothing."""
    if values.size == 1:
        axis.set_ticks(values, [f"{values[0]:.{digits}g}"])
        axis.set_ticks([], minor=True)


def _cell_keys(cells):
    """A key for each class that is there, and for what was not reproduced, with the numbers."""
    for name, code in _codes(cells).items():
        hatch = OPEN if name in STILL_OPEN else {}
        if count := np.count_nonzero(cells.outcome == code):
            look = {"facecolor": COLOURS[name], "edgecolor": "black", **hatch}
            yield Patch(**look, label=f"{WORDS[name]} ({count})")
    if count := np.count_nonzero(_is_unreproduced(cells)):
        look = {"facecolor": "none", "edgecolor": "black", **UNREPRODUCED}
        yield Patch(**look, label=f"not reproduced ({count})")


def _threshold_keys(found):
    return [] if found is None else [*curve_keys(found, "black"), limit_key()]


def _codes(cells):
    """The code of each outcome by its name, in ascending order."""
    attributes = cells.outcome.attrs
    names = attributes["flag_meanings"].split()
    return dict(zip(names, np.atleast_1d(attributes["flag_values"]).tolist(), strict=True))

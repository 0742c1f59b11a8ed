"""Maps over two axes of a study: the outcome of every cell, and where snapping begins."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ..axes import axis_behind
from . import style
from .curves import curve_keys, draw_curve, draw_limits, freeze, limit_key
from .scales import place_text, scale_of, set_scale

COLOURS = {
    "unsnapped": "#eef4f8",
    "never": "#bdd3e3",
    "snapped": "#e69f00",
    "latched": "#d55e00",
    "returned": "#5d3a8c",
    "failed": "#000000",
    "absent": "#ffffff",
}
"""Ever darker, so that a grey print keeps the classes apart; white where there is no device."""

OPEN = {"hatch": "." * 5, "hatchcolor": "0.35"}
ABSENT = {"hatch": "x" * 3, "hatchcolor": "0.6"}
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
    "absent": "no second stable shape",
}
TITLE = "outcome (number of cells)"
COLUMNS = 3
"""Maps side by side."""
MARK = {"markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 0.8}
RESOLVED, VECTORS = 700, 100_000
"""Most cells drawn along an axis, finer than print; and most drawn as vectors."""


def draw_map(
    ax: Axes,
    cells: xr.Dataset,
    found: xr.Dataset | None = None,
    x: str = "f0",
    y: str = "N",
    marks: Sequence[tuple[str, float, float]] = (),
) -> Axes:
    """Draw the outcomes of cells over their two axes.

    found: thresholds over x, drawn with their limits, if y is N
    marks: name, f0 (Hz) and N of shocks to point out on a map of N over f0, by numbers
    """
    _draw_panel(ax, cells, x, y, found)
    named = marks if (axis_behind(x), y) == ("f0", "N") else ()
    _point_out(ax, x, named)
    names = [f"{number}: {name}" for number, (name, *_) in enumerate(named, start=1)]
    lines = [place_text(cells), style.case(cells.attrs, style.COLUMN), *names]
    ax.set_title("\n".join(filter(None, lines)))
    lines = _threshold_keys(found if y == "N" else None)
    style.legend_below(ax, [*_cell_keys(cells), *lines], TITLE, ncols=2)
    return ax


def plot_outcome(
    cube: xr.Dataset,
    ax: Axes | None = None,
    x: str = "f0",
    y: str = "N",
    found: xr.Dataset | None = None,
) -> Axes:
    """Draw a map in a notebook, with its legend: on `ax`, or on a figure of its own.

    cube: as from `sweep` or `open_cube`, of one value on every axis but x and y
    found: thresholds over x, drawn if y is N

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cube = snapmap.sweep(device, [900, 1100], [500, 1500], [25], model="cosines", until="snap")
    >>> ax = snapmap.plot_outcome(cube)
    >>> ax.get_title().splitlines()[0][:8]
    '$C$ = 25'
    """
    many = [key for key in cube.outcome.dims if key not in (x, y) and cube.sizes[key] > 1]
    if many:
        raise ValueError(f"cube: has several {many[0]}; choose one, as cube.isel({many[0]}=0)")
    cells = cube.squeeze([key for key in cube.outcome.dims if key not in (x, y)])
    cells = cells.assign(outcome=cells.outcome_code) if "outcome_code" in cells else cells
    if ax is None:
        # For notebooks alone: no rule pays for its import.
        import matplotlib.pyplot as plt

        ax = plt.figure(figsize=(5, 5), layout="constrained").subplots()
    return draw_map(ax, cells, found, x, y)


def draw_maps(
    figure: Figure, panels: list[tuple[xr.Dataset, xr.Dataset | None]], x: str, y: str
) -> np.ndarray:
    """Draw several maps over the same axes on an empty figure, and one legend; returns the axes.

    panels: each cells and thresholds as for `draw_map`
    """
    columns = min(len(panels), COLUMNS)
    shape = -(-len(panels) // columns), columns
    axes = figure.subplots(*shape, sharey=True, squeeze=False)
    for ax in axes.flat[len(panels) :]:
        ax.set_axis_off()
    apart = _differing([cells for cells, _ in panels])
    for ax, (cells, found) in zip(axes.flat, panels, strict=False):
        _draw_panel(ax, cells, x, y, found)
        ax.set_title(place_text(cells.drop_vars(apart)))
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    for ax in (ax for row in axes[1:] for ax in row if ax.child_axes):
        ax.child_axes[0].set_visible(False)
    everywhere = [cells for cells, _ in panels]
    lines = _threshold_keys(*(found if y == "N" else None for _, found in panels))
    keys = [*_cell_keys(*everywhere), *lines]
    title = "; ".join(filter(None, [TITLE, style.case(everywhere[0].attrs)]))
    figure.legend(handles=keys, title=title, ncols=4, loc="outside lower center")
    return axes


def _differing(panels):
    """Names of scalar coordinates that are the same in all of several panels, but C."""
    first, *others = panels
    alone = [key for key in first.coords if first[key].ndim == 0 and key != "C"]
    return [key for key in alone if others and all(one[key] == first[key] for one in others)]


def _draw_panel(ax, cells, x, y, found):
    cells = _thin(cells.sortby([key for key in (x, y) if cells[key].dtype.kind in "fiu"]))
    scales = scale_of(x, cells[x].values), scale_of(y, cells[y].values)
    if x == "f0":
        top = style.frequency_axis(ax)
        if cells.f0.size == 1:
            top.xaxis.set_ticks(1e3 / cells.f0.values, [f"{1e3 / cells.f0.item():.3g}"])
            top.xaxis.set_ticks([], minor=True)
    for which, scale in zip("xy", scales, strict=True):
        set_scale(ax, which, scale)
    _draw_cells(ax, cells, *scales)
    _draw_hatches(ax, cells, *scales)
    _draw_failed(ax, cells, *scales)
    if found is not None and y == "N":
        freeze(ax)
        line = found.sortby(x) if found[x].dtype.kind in "fiu" else found
        draw_curve(ax, scale_of(x, line[x].values).places, line, "black")
        draw_limits(ax, line, x)


def _point_out(ax, x, marks):
    freeze(ax)
    low, high = ax.get_ylim()
    for number, (_, f0, N) in enumerate(marks, start=1):
        place = f0 if x == "f0" else 1e3 / f0
        if low <= N <= high:
            ax.plot(place, N, "o", markersize=7, **MARK)
            ax.annotate(str(number), (place, N), ha="center", va="center", fontsize=5)


def _thin(cells):
    """Keep every nth value of an axis, at most RESOLVED."""
    strides = {key: -(-size // RESOLVED) for key, size in cells.outcome.sizes.items()}
    return cells.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def _draw_cells(ax, cells, x, y):
    codes = _codes(cells)
    edges = np.array([-0.5, *(code + 0.5 for code in codes.values())])
    ax.pcolormesh(
        x.edges,
        y.edges,
        cells.outcome.transpose(y.key, x.key).values,
        cmap=ListedColormap([COLOURS[name] for name in codes]),
        norm=BoundaryNorm(edges, len(codes)),
        edgecolors="face",  # viewers show the paper between cells that merely touch
        linewidth=0.2,
        antialiased=True,
        rasterized=cells.outcome.size > VECTORS,
    )


def _draw_hatches(ax, cells, x, y):
    """Hatch what is open, and what another step did not reproduce, each as one region."""
    other, dark = _is_unreproduced(cells), _is_one_of(cells, DARK)
    dots, crosses = _is_one_of(cells, STILL_OPEN), _is_one_of(cells, ("absent",))
    light, dark = (other & ~dark, UNREPRODUCED), (other & dark, UNREPRODUCED_DARK)
    for chosen, look in ((dots, OPEN), (crosses, ABSENT), light, dark):
        i, low, high = _runs(chosen.transpose(x.key, y.key).values)
        left, right, foot, top = x.edges[i], x.edges[i + 1], y.edges[low], y.edges[high]
        corners = [(left, foot), (right, foot), (right, top), (left, top)]
        if i.size:
            region = Path.make_compound_path_from_polys(np.moveaxis(corners, 2, 0))
            ax.add_patch(PathPatch(region, facecolor="none", linewidth=0, **look))


def _runs(chosen):
    """Row, start and end of each run of chosen cells along the rows."""
    changes = np.diff(np.pad(chosen.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    (row, start), (_, end) = np.nonzero(changes == 1), np.nonzero(changes == -1)
    return row, start, end


def _is_one_of(cells, names):
    codes = _codes(cells)
    return cells.outcome.isin([codes[name] for name in names if name in codes])


def _is_unreproduced(cells):
    """Nowhere where no second run was made."""
    return cells.get("reproduced", xr.ones_like(cells.outcome)) != 1


def _draw_failed(ax, cells, x, y):
    """Cross out each failed cell, as one alone is too small to see on a fine grid."""
    i, j = np.nonzero((cells.outcome.transpose(x.key, y.key) == _codes(cells)["failed"]).values)
    for colour, width in {"white": 2.0, COLOURS["failed"]: 0.8}.items():
        cross = {"marker": "x", "color": colour, "markeredgewidth": width}
        ax.plot(x.places[i], y.places[j], linestyle="", **cross)


def _cell_keys(*panels):
    """A key for each class that is there, and for what was not reproduced, with the numbers."""
    for name, code in _codes(panels[0]).items():
        hatch = OPEN if name in STILL_OPEN else ABSENT if name == "absent" else {}
        if count := sum(np.count_nonzero(cells.outcome == code) for cells in panels):
            look = {"facecolor": COLOURS[name], "edgecolor": "black", **hatch}
            yield Patch(**look, label=f"{WORDS[name]} ({count})")
    if count := sum(np.count_nonzero(_is_unreproduced(cells)) for cells in panels):
        look = {"facecolor": "none", "edgecolor": "black", **UNREPRODUCED}
        yield Patch(**look, label=f"not reproduced ({count})")


def _threshold_keys(*found):
    """Keys for the thresholds of panels, of which all have some or none."""
    if found[0] is None:
        return []
    keys = {key.get_label(): key for one in found for key in curve_keys(one, "black")}
    return [*keys.values(), limit_key()]


def _codes(cells):
    """The code of each outcome by its name, in ascending order."""
    attributes = cells.outcome.attrs
    names = attributes["flag_meanings"].split()
    return dict(zip(names, np.atleast_1d(attributes["flag_values"]).tolist(), strict=True))

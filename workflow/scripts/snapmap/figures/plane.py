"""The plane of a map: two axes, cells in the colours of their states, hatches and points."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from .scales import Scale, frequency_axis, scale_of, set_scale
from .states import State

ABSENT = {"hatch": "x" * 3, "hatchcolor": "0.6"}
ELSEWHERE = {"hatch": "/" * 14, "hatchcolor": "0.1"}
ELSEWHERE_DARK = ELSEWHERE | {"hatchcolor": "0.9"}
"""Hatches of cells without a device, and of those that another step had end elsewhere."""
LUMA, DARK = (0.299, 0.587, 0.114), 0.4
"""Shares of red, green and blue in how light a colour is, and below what a hatch is light."""
RESOLVED, VECTORS = 700, 100_000
"""Most cells drawn along an axis, finer than print; and most drawn as vectors."""
PART = 1_000_000
"""Cells looked at together, as far as memory goes."""
BAR = 0, -0.31, 1, 0.05
"""Left, bottom, width and height of a colour bar below a box, in shares of the box."""
BELOW_BAR = 70
"""Where a legend stands below a box with a colour bar, pt."""


def thin(cells: xr.Dataset, x: str, y: str) -> xr.Dataset:
    """The cells in the order of their axes, at most RESOLVED along each: every nth one."""
    cells = cells.sortby([key for key in (x, y) if cells[key].dtype.kind in "fiu"])
    strides = {key: -(-cells.sizes[key] // RESOLVED) for key in (x, y)}
    return cells.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def parts(cells: xr.Dataset) -> Iterator[xr.Dataset]:
    """All cells of a map, some rows at a time, as a map may be larger than memory."""
    across, along = cells.outcome.dims
    rows = max(1, PART // cells.sizes[along])
    for first in range(0, cells.sizes[across], rows):
        yield cells.isel({across: slice(first, first + rows)})


def open_plane(ax: Axes, cells: xr.Dataset, x: str, y: str) -> tuple[Scale, Scale]:
    """Scale and name both axes for cells in ascending order; returns the scales."""
    scales = scale_of(x, cells[x].values), scale_of(y, cells[y].values)
    if x == "f0":
        frequency_axis(ax, cells.f0.values)
    else:
        set_scale(ax, "x", scales[0])
    set_scale(ax, "y", scales[1])
    return scales


def fill_states(ax: Axes, found: xr.DataArray, states: Sequence[State], x: Scale, y: Scale) -> None:
    """Fill each cell with the colour of its state; those that failed are crossed out.

    found: index in `states` of each cell over x and y
    """
    if found.size > VECTORS:
        colours = ListedColormap([state.colour for state in states])
        look = {"cmap": colours, "norm": BoundaryNorm(np.arange(len(states) + 1) - 0.5, colours.N)}
        fill_field(ax, found, x, y, **look)
    for i, state in enumerate(states):
        chosen = found == i
        if not chosen.any():
            continue
        if found.size <= VECTORS:
            # A stroke of its own colour: viewers show the paper between cells that merely touch.
            stroke = {"edgecolor": state.colour, "linewidth": 0.2, "joinstyle": "miter"}
            _fill(ax, chosen, x, y, facecolor=state.colour, **stroke)
        if state.name == "absent":
            _fill(ax, chosen, x, y, **_hatched(ABSENT))
        if state.name == "failed":
            _cross_out(ax, chosen, x, y, state.colour)


def fill_field(ax: Axes, field: xr.DataArray, x: Scale, y: Scale, **look) -> QuadMesh:
    """Fill each cell with the colour of its value; nothing where it is NaN."""
    values = np.ma.masked_invalid(field.transpose(y.key, x.key).values)
    edges = {"edgecolors": "face", "linewidth": 0.2, "antialiased": True}
    return ax.pcolormesh(x.edges, y.edges, values, rasterized=field.size > VECTORS, **edges, **look)


def hatch_cells(ax: Axes, chosen: xr.DataArray, dark: xr.DataArray, x: Scale, y: Scale) -> None:
    """Hatch the chosen cells, with light strokes where the cells are dark."""
    for some, look in ((chosen & ~dark, ELSEWHERE), (chosen & dark, ELSEWHERE_DARK)):
        _fill(ax, some, x, y, **_hatched(look))


def is_dark(found: xr.DataArray, states: Sequence[State]) -> xr.DataArray:
    """Whether the colours of cells are dark; found: as for `fill_states`."""
    light = [np.dot(to_rgb(state.colour), LUMA) for state in states]
    return found.isin([i for i, value in enumerate(light) if value < DARK])


def state_keys(found: Sequence[xr.DataArray], states: Sequence[State]) -> Iterator[Patch]:
    """A key of a legend for each state that some panels have, with the number of cells."""
    for i, state in enumerate(states):
        hatch = ABSENT if state.name == "absent" else {}
        if count := sum(np.count_nonzero(panel == i) for panel in found):
            look = {"facecolor": state.colour, "edgecolor": "black", **hatch}
            yield Patch(**look, label=f"{state.words} ({count})")


def elsewhere_keys(hatched: Sequence[xr.DataArray]) -> Iterator[Patch]:
    """A key of a legend for hatched cells, with their number."""
    if count := sum(np.count_nonzero(panel) for panel in hatched):
        look = {"facecolor": "none", "edgecolor": "black", **ELSEWHERE}
        yield Patch(**look, label=f"another step ended elsewhere ({count})")


def colour_bar(ax: Axes, field: QuadMesh, label: str) -> Colorbar:
    """Add a colour bar below a box, which keeps its size; returns it."""
    place = ax.inset_axes(BAR)
    return ax.get_figure().colorbar(field, cax=place, orientation="horizontal", label=label)


def _hatched(look):
    return {"facecolor": "none", "linewidth": 0, **look}


def _fill(ax, chosen, x, y, **look):
    """Fill the chosen cells as one region, drawn at one go."""
    i, low, high = _runs(chosen.transpose(x.key, y.key).values)
    left, right, foot, top = x.edges[i], x.edges[i + 1], y.edges[low], y.edges[high]
    corners = [(left, foot), (right, foot), (right, top), (left, top)]
    if i.size:
        region = Path.make_compound_path_from_polys(np.moveaxis(corners, 2, 0))
        ax.add_patch(PathPatch(region, **look))


def _runs(chosen):
    """Row, start and end of each run of chosen cells along the rows."""
    changes = np.diff(np.pad(chosen.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    (row, start), (_, end) = np.nonzero(changes == 1), np.nonzero(changes == -1)
    return row, start, end


def _cross_out(ax, chosen, x, y, colour):
    """Cross out each chosen cell, as one alone is too small to see on a fine grid."""
    i, j = np.nonzero(chosen.transpose(x.key, y.key).values)
    for stroke, width in {"white": 2.0, colour: 0.8}.items():
        cross = {"marker": "x", "color": stroke, "markeredgewidth": width}
        ax.plot(x.places[i], y.places[j], linestyle="", **cross)

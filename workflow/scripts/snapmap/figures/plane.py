"""The plane of a map: axes, cells in the colours of their states, hatches, shocks and points."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ..io.tables import Point
from . import style
from .scales import Scale, frequency_axis, scale_of, set_scale, value_text
from .states import State

ABSENT = {"hatch": "x" * 3, "edgecolor": "0.6"}
ELSEWHERE = {"hatch": "/" * 7, "edgecolor": "0.1"}
ELSEWHERE_DARK = ELSEWHERE | {"edgecolor": "0.9"}
BREAKS = {"hatch": "." * 5, "edgecolor": "#7a2d00"}
"""Hatches: no device; another step had it end elsewhere, on light and on dark; the beam breaks."""
LUMA, DARK = (0.299, 0.587, 0.114), 0.4
"""Shares of red, green and blue in how light a colour is, and below what a hatch is light."""
RESOLVED, VECTORS = 700, 20_000
"""Most cells drawn along an axis, finer than print; and most drawn as vectors."""
PART = 1_000_000
"""Cells looked at together, as far as memory goes."""

RING = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "linewidth": 0.8}
ARROW = {"arrowstyle": "-|>,head_length=0.3,head_width=0.15", "facecolor": "black"}
ARROW |= {"linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
NUMBER = {"fontsize": 5, "ha": "center", "va": "center", "bbox": RING, "arrowprops": ARROW}
NUMBER |= {"textcoords": "offset points"}
INWARD = 12
"""How far from an edge the number of a shock beyond it stands, pt."""
POINT = {"marker": "D", "markersize": 4, "markeredgecolor": "black", "linestyle": ""}
TRIPPED = {True: "black", False: "white", None: "0.6"}
POINT_WORDS = {True: "own point, tripped", False: "own point, not tripped", None: "own point"}
PAPER = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.6}
NAME = {"xytext": (4, 3), "textcoords": "offset points", "fontsize": 5.5, "bbox": PAPER}
NAME |= {"annotation_clip": True}
NAMED = 12
"""Most points whose names are written beside them."""


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

    found: index in `states` of each cell over x and y; below 0 nothing is filled
    """
    colours = ListedColormap([state.colour for state in states])
    norm = BoundaryNorm(np.arange(len(states) + 1) - 0.5, colours.N)
    fill_field(ax, found.where(found >= 0), x, y, cmap=colours, norm=norm)
    for code, state in enumerate(states):
        if state.name == "absent":
            hatch(ax, found == code, x, y, ABSENT)
        if state.name == "failed":  # one alone is too small to see on a fine grid
            i, j = np.nonzero((found == code).transpose(x.key, y.key).values)
            for stroke, width in {"white": 2.0, state.colour: 0.8}.items() if i.size else ():
                cross = {"marker": "x", "color": stroke, "markeredgewidth": width}
                ax.plot(x.places[i], y.places[j], linestyle="", **cross)


def fill_field(ax: Axes, field: xr.DataArray, x: Scale, y: Scale, **look) -> QuadMesh:
    """Fill each cell with the colour of its value; nothing where it is NaN."""
    values = np.ma.masked_invalid(field.transpose(y.key, x.key).values)
    # A stroke of its own colour: viewers show the paper between cells that merely touch.
    edges = {"edgecolors": "face", "linewidth": 0.2, "antialiased": True}
    return ax.pcolormesh(x.edges, y.edges, values, rasterized=field.size > VECTORS, **edges, **look)


def hatch(ax: Axes, chosen: xr.DataArray, x: Scale, y: Scale, look: dict) -> None:
    """Hatch the chosen cells, as one region that is drawn at one go."""
    i, j = np.nonzero(chosen.transpose(x.key, y.key).values)
    left, right, foot, top = x.edges[i], x.edges[i + 1], y.edges[j], y.edges[j + 1]
    corners = [(left, foot), (right, foot), (right, top), (left, top)]
    if i.size:
        region = Path.make_compound_path_from_polys(np.moveaxis(corners, 2, 0))
        bare = {"facecolor": "none", "linewidth": 0, "rasterized": chosen.size > VECTORS}
        ax.add_patch(PathPatch(region, **bare, **look))


def is_dark(found: xr.DataArray, states: Sequence[State]) -> xr.DataArray:
    """Whether the colours of cells are dark; found: as for `fill_states`."""
    light = [np.dot(to_rgb(state.colour), LUMA) for state in states]
    return found.isin([i for i, value in enumerate(light) if value < DARK])


def state_keys(found: Sequence[xr.DataArray], states: Sequence[State]) -> Iterator[Patch]:
    """A key of a legend for each state that some panels have, with the number of cells."""
    for code, state in enumerate(states):
        look = {"hatch": ABSENT["hatch"]} if state.name == "absent" else {}
        yield from hatch_keys([panel == code for panel in found], look, state.words, state.colour)


def hatch_keys(
    chosen: Sequence[xr.DataArray], look: dict, words: str, colour: str = "none"
) -> Iterator[Patch]:
    """A key of a legend for the chosen cells, if there are any, with their number."""
    if count := sum(int(panel.sum()) for panel in chosen):
        look = look | {"facecolor": colour, "edgecolor": "black"}
        yield Patch(**look, label=f"{words} ({count} cell{'s' * (count > 1)})")


def colour_bar(ax: Axes, field: QuadMesh, label: str) -> Colorbar:
    """Add a colour bar below axes that are alone on their figure, or else beside them."""
    place = "bottom" if style.is_alone(ax) else "right"
    return ax.get_figure().colorbar(field, ax=ax, location=place, aspect=30, label=label)


def freeze(ax: Axes) -> None:
    """Keep the limits of the axes, whatever is drawn next."""
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())


def number_shocks(ax: Axes, x: str, shocks: Sequence[tuple[str, float, float, bool]]) -> list[str]:
    """Point out shocks by numbers in the order given, by arrows at the edge what lies beyond it.

    shocks: name, f0 (Hz), N, and whether it has the map's pulse; what has not is but named
    Returns lines that name them.
    """
    freeze(ax)
    lines, others = [], []
    for number, (name, f0, N, is_of_map) in enumerate(shocks, start=1):
        name = f"{number}:\u00a0{style.literal(name)}"
        if not is_of_map:
            others.append(name)
            continue
        place = np.array([_place(x, f0), N])
        low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
        inside = np.clip(place, low, high)
        ax.annotate(str(number), inside, INWARD * np.sign(inside - place), **NUMBER)
        beyond = f" at {value_text('N', N)}, {value_text('f0', f0)}"
        lines.append(name + beyond * bool((place != inside).any()))
    return lines + ["of another shape or direction: " + ", ".join(others)] * bool(others)


def draw_points(ax: Axes, x: str, points: Sequence[Point]) -> None:
    """Draw a user's own points, filled where the device tripped, hollow where it did not.

    Of a few the names are written beside them.
    """
    freeze(ax)
    for point in points:
        place = _place(x, point.f0), point.N
        ax.plot(*place, markerfacecolor=TRIPPED[point.snapped], **POINT)
        if point.name and len(points) <= NAMED:
            ax.annotate(style.literal(point.name), place, **NAME)


def point_keys(points: Sequence[Point], words: dict = POINT_WORDS) -> list[Line2D]:
    """Keys of a legend for the kinds of points that there are."""
    kinds = [kind for kind in words if any(point.snapped is kind for point in points)]
    return [
        Line2D([], [], markerfacecolor=TRIPPED[kind], **POINT, label=words[kind]) for kind in kinds
    ]


def _place(x, f0):
    return f0 if x == "f0" else 1e3 / f0

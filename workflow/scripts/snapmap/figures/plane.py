"""The plane of a map: axes, cells in the colours of their states, hatches, shocks and points."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ..config.points import Point
from . import captions, style
from .scales import Scale, cells_of, set_scale, study_axis, value_text
from .states import State

HATCHES = {
    "absent": {"hatch": "x" * 3, "edgecolor": "0.6"},
    "elsewhere": {"hatch": "/" * 7, "edgecolor": "0.9"},
}
"""Hatches of states, by name."""
BREAKS = {"hatch": "." * 5, "edgecolor": "#7a2d00", "label": "the beam breaks"}
"""Hatch of cells whose beam breaks."""
RESOLVED, VECTORS = 700, 20_000
"""Most cells that are drawn along an axis, finer than print, and most that vectors hatch."""
PART = 1_000_000
"""Most cells that are classified together, for memory."""

RING = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "linewidth": 0.8}
ARROW = {"arrowstyle": "-|>,head_length=0.3,head_width=0.15", "facecolor": "black"}
ARROW |= {"linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
NUMBER = {"fontsize": 6, "ha": "center", "va": "center", "bbox": RING, "arrowprops": ARROW}
NUMBER |= {"textcoords": "offset points"}
INWARD = 12
"""Distance from an edge to the number of a shock beyond it, pt."""
POINT = {"marker": "D", "markersize": 4, "markeredgecolor": "black", "linestyle": ""}
TRIPPED = {True: "black", False: "white", None: "0.6"}
POINT_WORDS = {True: "own point, tripped", False: "own point, not tripped", None: "own point"}
PAPER = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.6}
NAME = {"xytext": (4, 3), "textcoords": "offset points", "fontsize": 6, "bbox": PAPER}
NAME |= {"annotation_clip": True}
NAMED = 12
"""Most points that have their names beside them."""


def thin(cells: xr.Dataset, x: str, y: str) -> xr.Dataset:
    """Sort cells along their axes, and keep every nth of more than RESOLVED along an axis."""
    cells = cells.sortby([key for key in (x, y) if cells[key].dtype.kind in "fiu"])
    strides = {key: -(-cells.sizes[key] // RESOLVED) for key in (x, y)}
    return cells.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def parts(cells: xr.Dataset) -> Iterator[xr.Dataset]:
    """Give all cells of a map, a few rows at a time, as a map may be larger than memory."""
    across, along = cells.outcome.dims
    rows = max(1, PART // cells.sizes[along])
    for first in range(0, cells.sizes[across], rows):
        yield cells.isel({across: slice(first, first + rows)})


def open_plane(ax: Axes, cells: xr.Dataset, x: str, y: str) -> tuple[Scale, Scale]:
    """Scale and name both axes for ascending cells; returns the scales of x and y."""
    scales = tuple(cells_of(key, cells[key].values, cells[key].attrs) for key in (x, y))
    study_axis(ax, scales[0], cells.attrs)
    set_scale(ax, "y", scales[1], cells.attrs)
    return scales


def fill_states(ax: Axes, codes: xr.DataArray, states: Sequence[State], x: Scale, y: Scale) -> None:
    """Fill each cell with the colour and the hatch of its state, and cross out failed ones.

    codes: index in `states` of each cell, over x and y; cells below 0 are not filled
    """
    colours = ListedColormap([state.colour for state in states])
    norm = BoundaryNorm(np.arange(len(states) + 1) - 0.5, colours.N)
    fill_field(ax, codes.where(codes >= 0), x, y, cmap=colours, norm=norm)
    for code, state in enumerate(states):
        if state.name in HATCHES:
            hatch(ax, codes == code, x, y, HATCHES[state.name])
        if state.name == "failed":  # on a fine grid a single cell is too small to see
            i, j = np.nonzero((codes == code).transpose(x.key, y.key).values)
            for stroke, width in {"white": 2.0, state.colour: 0.8}.items() if i.size else ():
                cross = {"marker": "x", "color": stroke, "markeredgewidth": width}
                ax.plot(x.places[i], y.places[j], linestyle="", **cross)


def fill_field(ax: Axes, field: xr.DataArray, x: Scale, y: Scale, **colours) -> QuadMesh:
    """Fill each cell with the colour of its value, but for NaN; colours: cmap and norm."""
    values = np.ma.masked_invalid(field.transpose(y.key, x.key).values)
    # With vectors, a viewer would show the paper between cells.
    return ax.pcolormesh(x.edges, y.edges, values, rasterized=True, **colours)


def hatch(ax: Axes, chosen: xr.DataArray, x: Scale, y: Scale, pattern: dict) -> None:
    """Hatch the chosen cells as a single region."""
    i, j = np.nonzero(chosen.transpose(x.key, y.key).values)
    left, right, foot, top = x.edges[i], x.edges[i + 1], y.edges[j], y.edges[j + 1]
    corners = [(left, foot), (right, foot), (right, top), (left, top)]
    if i.size:
        region = Path.make_compound_path_from_polys(np.moveaxis(corners, 2, 0))
        bare = {"facecolor": "none", "linewidth": 0, "rasterized": chosen.size > VECTORS}
        ax.add_patch(PathPatch(region, **bare, **pattern))


def state_keys(panels: Iterable[xr.DataArray], states: Sequence[State]) -> Iterator[Patch]:
    """Make a key of a legend for each state that some panel has, with the number of its cells."""
    values = (codes.values[codes.values >= 0] for codes in panels)
    counts = sum(np.bincount(codes, minlength=len(states)) for codes in values).tolist()
    for state, count in zip(states, counts, strict=True):
        pattern = {"edgecolor": "0.5"} | HATCHES.get(state.name, {})
        words = f"{state.words} ({count} cell{'s' if count > 1 else ''})"
        if count:
            yield Patch(facecolor=state.colour, label=words, **pattern)


def colour_bar(ax: Axes, field: QuadMesh, label: str) -> Colorbar:
    """Add a colour bar, below the only axes of our figure that is not wide, or else beside axes."""
    width, height = ax.get_figure().bbox.size
    is_below = style.is_ours(ax) and ax.get_figure().axes == [ax] and height >= width
    place = "bottom" if is_below else "right"
    bar = ax.get_figure().colorbar(field, ax=ax, location=place, aspect=30, label=label)
    style.fit_labels(bar.ax)
    return bar


def freeze(ax: Axes) -> None:
    """Keep the limits of the axes, whatever is drawn next."""
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())


def number_shocks(
    ax: Axes,
    x: str,
    shocks: Sequence[tuple[str, float, float, bool]],
    points: Sequence[Point] = (),
) -> dict[int, str]:
    """Number shocks in their order; an arrow at the edge points to a shock beyond it.

    shocks: name, f0 (Hz), N, and whether the shock has the map's pulse; others are left out
    points: a user's own, beside which a number stands aside, with an arrow to its place
    Returns the names by number.
    """
    freeze(ax)
    names = {}
    for number, (name, f0, N, is_of_map) in enumerate(shocks, start=1):
        if not is_of_map:
            continue
        names[number] = captions.literal(name)
        place = np.array([_place(x, f0), N])
        low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
        inside = np.clip(place, low, high)
        aside = INWARD * np.sign(inside - place)
        own = np.reshape([(_place(x, point.f0), point.N) for point in points], (-1, 2))
        apart = ax.transData.transform(own) - ax.transData.transform(inside)
        if (abs(apart) * 72 / ax.figure.dpi < INWARD).all(axis=1).any() and not aside.any():
            aside = np.array([INWARD, -INWARD])
        ax.annotate(str(number), inside, aside, **NUMBER)
        if (place != inside).any():
            names[number] += f" at {value_text('N', N)}, {value_text('f0', f0)}"
    return names


def draw_points(ax: Axes, x: str, points: Sequence[Point]) -> None:
    """Draw a user's own points, filled if the device tripped, hollow if not; few have names."""
    freeze(ax)
    for point in points:
        place, face = (_place(x, point.f0), point.N), TRIPPED[point.snapped]
        ax.plot(*place, label=POINT_WORDS[point.snapped], markerfacecolor=face, **POINT)
        if point.name and len(points) <= NAMED:
            ax.annotate(captions.literal(point.name), place, **NAME)


def _place(x, f0):
    """Give the place of f0 (Hz) on the axis x, which shows f0 or the duration (ms)."""
    return f0 if x == "f0" else 1e3 / f0

"""The plane of a map: axes, cells in the colours of their states, hatches, shocks and points."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ..config.points import Point
from . import style
from .scales import Scale, scale_of, set_scale, study_axis, value_text
from .states import State

ABSENT = {"hatch": "x" * 3, "edgecolor": "0.6"}
ELSEWHERE = {"hatch": "/" * 7, "edgecolor": "0.1", "label": "ended elsewhere with another step"}
ELSEWHERE_DARK = ELSEWHERE | {"edgecolor": "0.9"}
BREAKS = {"hatch": "." * 5, "edgecolor": "#7a2d00", "label": "the beam breaks"}
"""Hatches of cells without a device, of those that end elsewhere with another step, on light and on
dark colours, and of those whose beam breaks."""
LUMA, DARK = (0.299, 0.587, 0.114), 0.4
"""Shares of red, green and blue in how light a colour is, and below what a hatch is light."""
RESOLVED, VECTORS = 700, 20_000
"""Most cells drawn along an axis, finer than print; and most hatched as vectors."""
PART = 1_000_000
"""Cells that are classified together, as memory is bounded."""

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
    """Sort cells along their axes, and of more than RESOLVED along one take every nth."""
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
    """Scale and name both axes for cells in ascending order; returns the scales."""
    scales = scale_of(x, cells[x].values), scale_of(y, cells[y].values)
    study_axis(ax, scales[0], cells.attrs)
    set_scale(ax, "y", scales[1], cells.attrs)
    return scales


def fill_states(ax: Axes, codes: xr.DataArray, states: Sequence[State], x: Scale, y: Scale) -> None:
    """Fill each cell with the colour of its state; those that failed are crossed out.

    codes: index in `states` of each cell over x and y; below 0 nothing is filled
    """
    colours = ListedColormap([state.colour for state in states])
    norm = BoundaryNorm(np.arange(len(states) + 1) - 0.5, colours.N)
    fill_field(ax, codes.where(codes >= 0), x, y, cmap=colours, norm=norm)
    for code, state in enumerate(states):
        if state.name == "absent":
            hatch(ax, codes == code, x, y, ABSENT)
        if state.name == "failed":  # one alone is too small to see on a fine grid
            i, j = np.nonzero((codes == code).transpose(x.key, y.key).values)
            for stroke, width in {"white": 2.0, state.colour: 0.8}.items() if i.size else ():
                cross = {"marker": "x", "color": stroke, "markeredgewidth": width}
                ax.plot(x.places[i], y.places[j], linestyle="", **cross)


def fill_field(ax: Axes, field: xr.DataArray, x: Scale, y: Scale, **colours) -> QuadMesh:
    """Fill each cell with the colour of its value; nothing where it is NaN.

    colours: cmap and norm, as `pcolormesh` takes them
    """
    values = np.ma.masked_invalid(field.transpose(y.key, x.key).values)
    # No vectors: a viewer shows the paper between those that merely touch.
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


def is_dark(codes: xr.DataArray, states: Sequence[State]) -> xr.DataArray:
    """Whether the colours of cells are dark; codes: as for `fill_states`."""
    light = [np.dot(to_rgb(state.colour), LUMA) for state in states]
    return codes.isin([i for i, value in enumerate(light) if value < DARK])


def state_keys(panels: Iterable[xr.DataArray], states: Sequence[State]) -> Iterator[Patch]:
    """Make a key of a legend for each state that any panel has, with the number of cells."""
    values = (codes.values[codes.values >= 0] for codes in panels)
    counts = sum(np.bincount(codes, minlength=len(states)) for codes in values).tolist()
    for state, count in zip(states, counts, strict=True):
        pattern = {"hatch": ABSENT["hatch"]} if state.name == "absent" else {}
        words = f"{state.words} ({count} cell{'s' if count > 1 else ''})"
        if count:
            yield Patch(facecolor=state.colour, edgecolor="black", label=words, **pattern)


def colour_bar(ax: Axes, field: QuadMesh, label: str) -> Colorbar:
    """Add a colour bar below axes that are alone on their figure, or else beside them."""
    place = "bottom" if style.is_alone(ax) else "right"
    return ax.get_figure().colorbar(field, ax=ax, location=place, aspect=30, label=label)


def freeze(ax: Axes) -> None:
    """Keep the limits of the axes, whatever is drawn next."""
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())


def number_shocks(
    ax: Axes, x: str, shocks: Sequence[tuple[str, float, float, bool]]
) -> dict[int, str]:
    """Point out shocks by numbers in the order given, by arrows at the edge what lies beyond it.

    shocks: name, f0 (Hz), N, and whether it has the map's pulse; what has not is left out
    Returns the name of each number.
    """
    freeze(ax)
    names = {}
    for number, (name, f0, N, is_of_map) in enumerate(shocks, start=1):
        if not is_of_map:
            continue
        names[number] = style.literal(name)
        place = np.array([_place(x, f0), N])
        low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
        inside = np.clip(place, low, high)
        ax.annotate(str(number), inside, INWARD * np.sign(inside - place), **NUMBER)
        if (place != inside).any():
            names[number] += f" at {value_text('N', N)}, {value_text('f0', f0)}"
    return names


def draw_points(ax: Axes, x: str, points: Sequence[Point]) -> None:
    """Draw a user's own points, filled where the device tripped, hollow where it did not.

    Of a few the names are written beside them.
    """
    freeze(ax)
    for point in points:
        place, face = (_place(x, point.f0), point.N), TRIPPED[point.snapped]
        ax.plot(*place, label=POINT_WORDS[point.snapped], markerfacecolor=face, **POINT)
        if point.name and len(points) <= NAMED:
            ax.annotate(style.literal(point.name), place, **NAME)


def _place(x, f0):
    """Where a shock of f0 (Hz) stands on the axis x, which is f0 or the duration (ms)."""
    return f0 if x == "f0" else 1e3 / f0

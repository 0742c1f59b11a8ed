"""Maps over two axes of a study: which cells snap, when, and where the beam ends."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..axes import axis_behind
from ..checks import show
from ..io.tables import Point
from . import layout, plane, style
from .curves import LIMITS, band_keys, draw_band, draw_impulsive, draw_static, freeze, limit_key
from .points import draw_points, number_shocks, point_keys
from .scales import Scale, place_text, scale_of, tick_log
from .states import (
    SNAPS,
    STATES,
    TIME_COLOURS,
    WAITING,
    WIDE,
    State,
    end_elsewhere,
    end_states,
    snap_states,
)

BREAKS = {"colors": "#d55e00", "linewidths": 1.0}
"""The line beyond which the beam breaks."""


class Kind(NamedTuple):
    """What the colours of a map mean.

    states: what there are; classify: gives the index in them of each cell
    words, columns: of the legend below maps side by side
    is_of_ends: whether cells that another step had end elsewhere are hatched
    """

    states: tuple[State, ...]
    classify: Callable[[xr.Dataset], xr.DataArray]
    words: str
    columns: int
    is_of_ends: bool


END = Kind(
    STATES,
    end_states,
    "the beam at the end of its run (number of cells)",
    3,
    True,
)
SNAP = Kind(SNAPS, snap_states, "the beam within its run (number of cells)", 4, False)


class Panel(NamedTuple):
    """What a map shows: cells over its two axes, and thresholds over x if there are any."""

    cells: xr.Dataset
    found: xr.Dataset | None = None

    @property
    def kind(self) -> Kind:
        """Where the beam ends, if it was followed that far; else where it snaps."""
        return END if "well" in self.cells and self.found is None else SNAP


def draw_end_map(
    ax: Axes,
    cells: xr.Dataset,
    x: str = "f0",
    y: str = "N",
    required_shocks: Sequence[tuple[str, float, float, bool]] = (),
    own_points: Sequence[Point] = (),
) -> Axes:
    """Draw over two axes on which side of the saddle the beam of each cell ends, and how sure.

    required_shocks, own_points: as for `draw_snap_map`
    """
    return _draw_map(ax, END, Panel(cells), x, y, required_shocks, own_points)


def draw_snap_map(
    ax: Axes,
    cells: xr.Dataset,
    found: xr.Dataset | None = None,
    x: str = "f0",
    y: str = "N",
    required_shocks: Sequence[tuple[str, float, float, bool]] = (),
    own_points: Sequence[Point] = (),
) -> Axes:
    """Draw over two axes which cells snap.

    found: thresholds over x, drawn with their errors and limits if y is N
    required_shocks: to point out by numbers: name, f0 (Hz), N, and whether the map is of its pulse
    own_points: a user's own
    """
    return _draw_map(ax, SNAP, Panel(cells, found), x, y, required_shocks, own_points)


def draw_time_map(
    ax: Axes,
    cells: xr.Dataset,
    x: str = "f0",
    y: str = "N",
    ends: tuple[float, float] | None = None,
) -> Axes:
    """Draw over two axes when each cell snaps.

    ends: of the colours, us; the first and the last snap of these cells if not given
    """
    cells = plane.thin(cells, x, y)
    across = plane.open_plane(ax, cells, x, y)
    states = (WAITING, WAITING, *SNAPS[2:])
    found = snap_states(cells)
    plane.fill_states(ax, found, states, *across)
    keys = list(plane.state_keys([found.where(found != 1, -1)], states))
    if (found == 1).any():
        _draw_times(ax, cells.t_snap, ends or snap_times([cells]), *across)
    ax.set_title(_title(cells))
    style.legend_below(ax, keys, "", ncols=2, below=plane.BELOW_BAR)
    return ax


def snap_times(panels: Iterable[xr.Dataset]) -> tuple[float, float]:
    """The first and the last snap in all maps of cells, us; NaN if none snaps."""
    times = (part.t_snap for cells in panels for part in plane.parts(cells))
    ends = [(some.min().item(), some.max().item()) for some in times]
    return np.fmin.reduce(ends)[0].item(), np.fmax.reduce(ends)[1].item()


def plot_outcome(
    cube: xr.Dataset,
    ax: Axes | None = None,
    x: str = "f0",
    y: str = "N",
    found: xr.Dataset | None = None,
    ends: bool = False,
) -> Axes:
    """Draw in a notebook which cells snap, with a legend: on `ax`, or on a figure of its own.

    cube: as from `sweep` or `open_cube`, of one value on every axis but x and y
    found: thresholds over x, drawn if y is N
    ends: draw instead on which side of the saddle each beam ends

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cube = snapmap.sweep(device, [900, 1100], [500, 1500], [25], model="cosines", until="snap")
    >>> ax = snapmap.plot_outcome(cube)
    >>> ax.get_title().splitlines()[0][:8]
    '$C$ = 25'
    """
    for name, key in (("x", x), ("y", y)):
        if axis_behind(key) not in cube.outcome.dims:
            raise ValueError(f"{name}: {show(key)} is no axis of the cube")
    many = [key for key in cube.outcome.dims if key not in (x, y) and cube.sizes[key] > 1]
    if many:
        raise ValueError(f"cube: has several {many[0]}; choose one, as cube.isel({many[0]}=0)")
    cells = cube.squeeze([key for key in cube.outcome.dims if key not in (x, y)])
    cells = cells.assign(outcome=cells.outcome_code) if "outcome_code" in cells else cells
    if ends and "well" not in cells:
        raise ValueError("cube: its runs end at the snap; where beams end is not known")
    kind = END if ends else SNAP
    return _draw_map(ax or style.notebook_axes(), kind, Panel(cells, found), x, y, (), ())


def draw_maps(
    figure: Figure, panels: Sequence[Panel], x: str, y: str, own_points: Sequence[Point] = ()
) -> np.ndarray:
    """Draw several maps of one kind over the same axes on an empty figure, and one legend.

    The figure is made as high as they are. Returns the axes, None where there is none.
    """
    apart = _differing([cells for cells, _ in panels])
    titles = [place_text(cells.drop_vars(apart)) for cells, _ in panels]
    axes = layout.boxes(figure, len(panels), 1 + max(title.count("\n") for title in titles))
    kind, own_points = panels[0].kind, _of_plane(x, y, own_points)
    for ax, panel, title in zip(axes.flat, panels, titles, strict=False):
        _fill_map(ax, kind, panel, x, y)
        draw_points(ax, x, own_points)
        ax.set_title(title)
    _keep_outer_labels(axes)
    words = "\n".join(filter(None, [kind.words, style.case(panels[0].cells.attrs)]))
    keys = [*_keys(kind, panels, y), *point_keys(own_points)]
    style.legend_below(axes[-1, 0], keys, words, ncols=kind.columns, of_all=True)
    layout.trim(figure)
    return axes


def _draw_map(ax, kind, panel, x, y, required_shocks, own_points):
    required_shocks, own_points = _of_plane(x, y, required_shocks), _of_plane(x, y, own_points)
    _fill_map(ax, kind, panel, x, y)
    names = number_shocks(ax, x, required_shocks)
    draw_points(ax, x, own_points)
    ax.set_title("\n".join([_title(panel.cells), *names]))
    keys = [*_keys(kind, [panel], y), *point_keys(own_points)]
    style.legend_below(ax, keys, kind.words, ncols=2)
    return ax


def _of_plane(x, y, shocks):
    """Shocks have a place on a map of N over f0 alone."""
    return shocks if (axis_behind(x), y) == ("f0", "N") else ()


def _title(cells):
    return "\n".join(filter(None, [place_text(cells), style.case(cells.attrs, style.COLUMN)]))


def _fill_map(ax, kind, panel, x, y):
    cells = plane.thin(panel.cells, x, y)
    across = plane.open_plane(ax, cells, x, y)
    found = kind.classify(cells)
    plane.fill_states(ax, found, kind.states, *across)
    if kind.is_of_ends:
        dark = plane.is_dark(found, kind.states)
        plane.hatch_cells(ax, end_elsewhere(cells), dark, *across)
    if panel.found is not None and y == "N":
        _draw_threshold(ax, panel.found, x)
    if _breaks(cells):
        freeze(ax)
        share = cells.stress_share.transpose(across[1].key, across[0].key)
        ax.contour(across[0].places, across[1].places, share, [1.0], **BREAKS)


def _breaks(cells):
    """Whether the strength is reached in some cells of a plane, and not in all."""
    return "stress_share" in cells and cells.stress_share.min() < 1 < cells.stress_share.max()


def _draw_threshold(ax, found, x):
    freeze(ax)
    line = found.sortby(x) if found[x].dtype.kind in "fiu" else found
    draw_band(ax, scale_of(x, line[x].values).places, line)
    draw_static(ax, line, x, "black")
    if x == "f0":
        draw_impulsive(ax, line, "black")


def _draw_times(ax, times, ends, x: Scale, y: Scale):
    unit, per_unit = ("ms", 1e3) if ends[1] >= 1e3 else ("µs", 1.0)
    low, high = ends[0] / per_unit, ends[1] / per_unit
    norm = LogNorm(low, high) if high > WIDE * low else Normalize(low, high)
    field = plane.fill_field(ax, times / per_unit, x, y, cmap=TIME_COLOURS, norm=norm)
    bar = plane.colour_bar(ax, field, f"first snap after the start of the pulse ({unit})")
    if high > WIDE * low:
        tick_log(bar.ax.xaxis, (low, high), ax.bbox.width / ax.get_figure().dpi)


def _keys(kind, panels, y):
    """Of states, hatches and thresholds; all panels have thresholds or none."""

    def of_all(look):  # what is read of a part goes with it
        return [look(part) for cells, _ in panels for part in plane.parts(cells)]

    keys = list(plane.state_keys(of_all(kind.classify), kind.states))
    if kind.is_of_ends:
        keys += plane.elsewhere_keys(of_all(end_elsewhere))
    if any(_breaks(cells) for cells, _ in panels):
        look = {"color": BREAKS["colors"], "linewidth": BREAKS["linewidths"]}
        keys.append(Line2D([], [], **look, label="largest stress = strength"))
    if panels[0].found is None or y != "N":
        return keys
    lines = {key.get_label(): key for _, found in panels for key in band_keys(found)}
    return [*keys, *lines.values(), limit_key(LIMITS, "black")]


def _differing(panels):
    """Names of scalar coordinates that are the same in all of several panels, but C."""
    first, *others = panels
    alone = [key for key in first.coords if first[key].ndim == 0 and key != "C"]
    return [key for key in alone if others and all(one[key] == first[key] for one in others)]


def _keep_outer_labels(axes):
    """Label x below the lowest box of each column, durations at the top, and y once at the left."""
    first, last = axes[0, 0], axes[-1, 0]
    label = first.get_ylabel()
    for (row, column), ax in np.ndenumerate(axes):
        if ax is None:
            continue
        ax.set_ylabel("")
        ax.tick_params(axis="y", labelleft=column == 0)
        if row + 1 < len(axes) and axes[row + 1, column] is not None:
            ax.set_xlabel("")
            ax.tick_params(axis="x", labelbottom=False)
        for top in list(ax.child_axes) if row else ():
            top.remove()
    box = last.get_position()
    last.set_ylabel(label, y=(first.get_position().y1 - box.y0) / box.height / 2)

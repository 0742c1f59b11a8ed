"""Maps over two axes of a study: which cells snap, when, and where the beam ends."""

import textwrap
from collections.abc import Iterable, Sequence
from typing import Annotated

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from ..device.argument import Argument, Flag, of_type
from ..files.tables import Point
from ..files.text import show
from ..study.axes import axis_behind
from ..sweeps.cube import outcome_names, require_cube
from . import plane, states, style
from .curves import LONG, draw_band, draw_impulsive, draw_static
from .scales import place_text, scale_of, tick

RATIO = 0.72
"""Height over width of the axes of a map."""


def draw_map(
    ax: Axes,
    cells: xr.Dataset,
    thresholds: xr.Dataset | None = None,
    x: str = "f0",
    y: str = "N",
    required_shocks: Sequence[tuple[str, float, float, bool]] = (),
    own_points: Sequence[Point] = (),
    ends: bool = False,
) -> Axes:
    """Draw over two axes which cells snap.

    thresholds: over x, drawn with their errors and limits if y is N
    required_shocks: to point out by numbers: name, f0 (Hz), N, and whether the map is of its pulse
    own_points: a user's own
    ends: draw instead on which side of the saddle the beam of each cell ends, and how sure
    """
    _fill_map(ax, cells, thresholds, x, y, own_points, ends)
    shocks = plane.number_shocks(ax, x, required_shocks if _has_shocks(x, y) else ())
    ax.set_title(place_text(cells))
    words = [style.case(cells.attrs, style.COLUMN), textwrap.fill(shocks, style.COLUMN)]
    style.legend(ax, _keys([cells], [ax], ends), "\n".join(filter(None, words)), 2)
    return ax


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
    shown = states.WAITING, states.WAITING, *states.SNAPS[2:]
    codes = states.snap_states(cells)
    codes = codes.where(codes != 1, -1)  # in the colour of its time
    plane.fill_states(ax, codes, shown, *across)
    ax.set_title(place_text(cells))
    style.legend(ax, plane.state_keys([codes], shown), style.case(cells.attrs, style.COLUMN), 2)
    if (codes == -1).any():
        low, high = ends or snap_times([cells])
        unit, per_unit = ("ms", 1e3) if high >= 1e3 else ("µs", 1.0)
        is_wide = high > states.WIDE * low
        norm = (LogNorm if is_wide else Normalize)(low / per_unit, high / per_unit)
        look = {"cmap": states.TIME_COLOURS, "norm": norm}
        field = plane.fill_field(ax, cells.t_snap / per_unit, *across, **look)
        bar = plane.colour_bar(ax, field, f"first snap after the start of the pulse ({unit})")
        if is_wide:
            tick(bar.long_axis, low / per_unit, high / per_unit)
    return ax


def snap_times(panels: Iterable[xr.Dataset]) -> tuple[float, float]:
    """The first and the last snap in all maps of cells, us; NaN if none snaps, or there is none."""
    times = (part.t_snap for cells in panels for part in plane.parts(cells))
    ends = [(np.nan, np.nan), *((time.min().item(), time.max().item()) for time in times)]
    return np.fmin.reduce(ends)[0].item(), np.fmax.reduce(ends)[1].item()


def _dataset(need, variable):
    is_one = lambda value: isinstance(value, xr.Dataset) and variable in value  # noqa: E731
    return Annotated[xr.Dataset, Argument(need, is_one)]


Cube = _dataset("a cube, as sweep and open_cube return it", "outcome")
Thresholds = _dataset("a Dataset of thresholds, as threshold returns it", "N_first")
AxisName = Annotated[str, of_type("the name of an axis of the cube", str)]
MatplotlibAxes = Annotated[
    Axes, Argument("Axes of matplotlib", lambda value: hasattr(value, "get_xlim"))
]


def plot_outcome(
    cube: Cube,
    ax: MatplotlibAxes | None = None,
    x: AxisName = "f0",
    y: AxisName = "N",
    found: Thresholds | None = None,
    ends: Flag = False,
) -> Axes:
    """Draw which cells snap, with a legend, on `ax` or on a new figure.

    cube: as from `sweep` or `open_cube`, of one value on every axis but x and y
    found: thresholds over x, drawn if y is N
    ends: draw instead on which side of the saddle each beam ends

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cube = snapmap.sweep(device, [900, 1100], [500, 1500], [25], model="cosines", until="snap")
    >>> ax = snapmap.plot_outcome(cube)
    >>> ax.get_title().splitlines()[0][:8]
    '$C$ = 25'
    """
    cube = cube.assign(outcome=require_cube(cube))
    for name, key in (("x", x), ("y", y)):
        if axis_behind(key) not in cube.outcome.dims:
            raise ValueError(f"{name}: {show(key)} is no axis of the cube")
    if axis_behind(x) == axis_behind(y):
        raise ValueError(f"x: {show(x)} is y, too; write another axis of the cube")
    many = [key for key in cube.outcome.dims if key not in (x, y) and cube.sizes[key] > 1]
    if many:
        raise ValueError(f"cube: has several {many[0]}; choose one, as cube.isel({many[0]}=0)")
    cells = cube.squeeze([key for key in cube.outcome.dims if key not in (x, y)])
    outcome_names(cells.outcome.values)
    if ends and "well" not in cells:
        raise ValueError("cube: its runs end at the snap; where beams end is not known")
    return draw_map(ax or style.notebook_axes(), cells, found, x, y, ends=ends)


def draw_maps(
    figure: Figure,
    panels: Sequence[tuple[xr.Dataset, xr.Dataset | None]],
    x: str,
    y: str,
    own_points: Sequence[Point] = (),
    ends: bool = False,
) -> np.ndarray:
    """Draw several maps over the same axes on an empty figure, as high as they are, and one legend.

    panels: cells, and thresholds or none, as of `draw_map`, as are the others
    Returns the axes, rows and columns, None where there is none.
    """
    columns = 2 if len(panels) in (1, 2, 4) else 3 if len(panels) in (3, 5, 6, 9) else 4
    figure.set_figheight(3 * (1 - (-len(panels) // columns)))
    axes = figure.subplots(-(-len(panels) // columns), columns, squeeze=False)
    first, *others = cells = [cells for cells, _ in panels]
    alone = [key for key in first.coords if first[key].ndim == 0]
    shared = [key for key in alone if others and all(panel[key] == first[key] for panel in others)]
    for place, ax in enumerate(axes.flat):
        if place >= len(panels):
            ax.remove()
            axes.flat[place] = None
            continue
        _fill_map(ax, *panels[place], x, y, own_points, ends)
        ax.set_title(place_text(panels[place][0].drop_vars(shared), 110 // columns))
        figure.supylabel(ax.get_ylabel(), size="medium")
        ax.set_ylabel("")
        ax.tick_params(axis="y", labelleft=place % columns == 0)
        if place + columns < len(panels):
            ax.set_xlabel("")
            ax.tick_params(axis="x", labelbottom=False)
        if place >= columns:
            for top in list(ax.child_axes):
                top.remove()
    words = place_text(first.drop_vars({*first.coords} - {*shared}), style.PAGE)
    words = "\n".join(filter(None, [words, style.case(first.attrs)]))
    keys = _keys(cells, axes.flat[: len(panels)], ends)
    limits = [key for key in keys if key.get_label().startswith(LONG)]
    if limits[1:]:  # each panel has another, which one key stands for
        limits[0].set_label(LONG)
        keys = [key for key in keys if key not in limits[1:]]
    style.legend(figure, keys, words)
    style.fit(figure, RATIO)
    return axes


def _has_shocks(x, y):
    """Whether a map is one of N over f0, where alone shocks have a place."""
    return (axis_behind(x), y) == ("f0", "N")


def _fill_map(ax, cells, thresholds, x, y, own_points, ends):
    cells = plane.thin(cells, x, y)
    across = plane.open_plane(ax, cells, x, y)
    shown, classify = _states(ends)
    codes = classify(cells)
    plane.fill_states(ax, codes, shown, *across)
    if ends:
        dark, elsewhere = plane.is_dark(codes, shown), states.end_elsewhere(cells)
        plane.hatch(ax, elsewhere & ~dark, *across, plane.ELSEWHERE)
        plane.hatch(ax, elsewhere & dark, *across, plane.ELSEWHERE_DARK)
    if "stress_share" in cells:
        plane.hatch(ax, cells.stress_share >= 1, *across, plane.BREAKS)
    plane.freeze(ax)
    if thresholds is not None and y == "N":
        thresholds = thresholds.sortby(x) if thresholds[x].dtype.kind in "fiu" else thresholds
        draw_band(ax, scale_of(x, thresholds[x].values).places, thresholds)
        draw_static(ax, thresholds, x, "black")
        if x == "f0":
            draw_impulsive(ax, thresholds, "black")
    plane.draw_points(ax, x, own_points if _has_shocks(x, y) else ())


def _states(ends):
    """The states of a cell that may be drawn, and the function that classifies cells."""
    return (states.STATES, states.end_states) if ends else (states.SNAPS, states.snap_states)


def _keys(panels, axes, ends):
    """Of the states of all cells, and of what is labelled on the axes."""
    shown, classify = _states(ends)
    # What is read of a part goes with it.
    codes = (classify(part) for cells in panels for part in plane.parts(cells))
    return [*plane.state_keys(codes, shown), *style.labelled(axes)]

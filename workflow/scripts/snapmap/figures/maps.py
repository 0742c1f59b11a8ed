"""Maps over two axes of a study: which cells snap, when, and where the beam ends."""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.legend import Legend

from ..config.points import Point
from ..files.text import show
from ..study.axes import axis_behind
from ..sweeps.cube import require_codes, require_cube
from ..values.kinds import Fitting
from ..values.quantities import Truth
from . import captions, plane, states, style
from .curves import LONG, draw_band, draw_impulsive, draw_static
from .scales import LABELS, place_text, scale_of, tick

ROW, BESIDE = 1.5, 0.9
"""Height of a row of maps over its width in four, and that of captions, in."""
MOST_COLUMNS = 4
"""Most maps side by side, and most below each other where axes have rows and columns."""


def draw_map(
    ax: Axes,
    cells: xr.Dataset,
    thresholds: xr.Dataset | None = None,
    x: str = "f0",
    y: str = "N",
    required_shocks: Sequence[tuple[str, float, float, bool]] = (),
    own_points: Sequence[Point] = (),
    shows: str = "snaps",
) -> Axes:
    """Draw a map of cells over two axes, with its legend.

    thresholds: thresholds over x, drawn with their errors and limits if y is N
    required_shocks: shocks that get a number: name, f0 (Hz), N, and whether the map has their pulse
    own_points: a user's own points
    shows: `snaps`: which cells snap; `times`: when they snap; `ends`: on which side of the saddle
        the beam ends, and how sure that is
    """
    look = _time_look([cells]) if shows == "times" else {}
    panel, shown = (cells, thresholds, required_shocks), states.SHOWN[shows]
    field, names = _fill_map(ax, panel, x, y, own_points, shown, look)
    ax.set_title(place_text(cells, style.signs(ax, "axes.titlesize")))
    width = style.signs(ax.get_figure())
    words = [captions.case(cells.attrs, width), _numbered(names, width)]
    _add_time_bar(ax.get_figure(), ax, field, look)
    style.legend(ax, _keys([cells], [ax], shown), "\n".join(filter(None, words)), 2)
    return ax


def _time_look(panels):
    """Choose the colours of snap times in all panels: a norm, its unit, and the unit's size, us."""
    low, high = snap_times(panels)
    unit, size = ("ms", 1e3) if high >= 1e3 else ("µs", 1.0)
    norm = (LogNorm if high > states.WIDE * low else Normalize)(low / size, high / size)
    return {"norm": norm, "unit": unit, "size": size}


def _add_time_bar(figure, axes, field, look):
    """Put a bar with the colours of times below axes; field: None if no cell snaps."""
    if field is None:
        return
    label = f"first snap after the start of the pulse ({look['unit']})"
    if style.is_ours(figure):
        place = {"location": "bottom", "pad": 0.02, "aspect": 30 * min(np.size(axes), 2)}
        bar = figure.colorbar(field, ax=axes, label=label, **place)
    else:
        bar = plane.colour_bar(axes, field, label)
    if isinstance(look["norm"], LogNorm):
        tick(bar.long_axis, look["norm"].vmin, look["norm"].vmax)


def snap_times(panels: Iterable[xr.Dataset]) -> tuple[float, float]:
    """Give the times of the first and last snap in all maps of cells, us; NaN without snaps."""
    times = (part.t_snap for cells in panels for part in plane.parts(cells))
    ends = [(np.nan, np.nan), *((time.min().item(), time.max().item()) for time in times)]
    return np.fmin.reduce(ends)[0].item(), np.fmax.reduce(ends)[1].item()


def _having(need, *variables):
    """Make the kind of a dataset that has some variables."""
    return Fitting(need, lambda value: isinstance(value, xr.Dataset) and {*variables} <= {*value})


CELLS = "a cube, as sweep and open_cube return it"
Cube = Annotated[xr.Dataset, _having(CELLS, "outcome", "t_snap")]
_THRESHOLDS = "a Dataset of thresholds, as threshold returns it"
Thresholds = Annotated[xr.Dataset, _having(_THRESHOLDS, "N_first")]
_AXES = Fitting("Axes of matplotlib", lambda value: hasattr(value, "get_xlim"))
MatplotlibAxes = Annotated[Axes, _AXES]


def _fits_legend(value):
    names = inspect.signature(Legend.__init__).parameters.keys() - {"self", "parent", "handles"}
    return isinstance(value, bool) or (isinstance(value, Mapping) and names.issuperset(value))


_OF_LEGEND = "true, false or a mapping of arguments of matplotlib's legend but handles"
LegendArguments = Annotated[bool | Mapping, Fitting(_OF_LEGEND, _fits_legend)]
_COLOURS = Fitting("a mapping of words to colours", lambda value: isinstance(value, Mapping))
Colours = Annotated[Mapping[str, str], _COLOURS]


def plot_outcome(
    cube: Cube,
    ax: MatplotlibAxes | None = None,
    x: str = "f0",
    y: str = "N",
    *,
    thresholds: Thresholds | None = None,
    ends: Truth = False,
    legend: LegendArguments = True,
    colours: Colours | None = None,
) -> Axes:
    """Draw which cells of a cube snap, with a legend.

    Parameters
    ----------
    cube
        Dataset of `sweep` or `open_cube`, with a single value on all axes but x and y.
    ax
        Where to draw; by default on a new figure.
    x, y
        Names of axes of the cube.
    thresholds
        Dataset of `threshold`, drawn as a line if y is N.
    ends
        Whether to draw where each beam ends instead.
    legend
        False for none, or arguments of matplotlib's legend. In your own axes it is inside them.
    colours
        Colours by the words of the legend, as {"snaps": "gold"}.

    Returns
    -------
    Axes
        Those of the figure.

    Raises
    ------
    ValueError
        One line, for a cube without these axes, or with several values of another one.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", until="snap")
    >>> ax = snapmap.plot_outcome(snapmap.sweep(study, [900, 1100], [500, 1500], 25))
    >>> ax.get_title().splitlines()[0][:8]
    '$C$ = 25'
    """
    cube = cube.assign(outcome=require_cube(cube))
    if axis_behind(x) == axis_behind(y):
        raise ValueError(f"x: {show(x)} is already y; write another axis of the cube")
    for name, key in (("x", x), ("y", y)):
        if not isinstance(key, str) or key not in cube.outcome.dims or key not in LABELS:
            raise ValueError(f"{name}: {show(key)} is not an axis of the cube")
        if not cube.sizes[key]:
            raise ValueError(f"cube: has no {key}; choose one or more")
    cells = _alone(cube, "cube", cube.outcome.dims, (x, y))
    require_codes(cells.outcome.values)
    if thresholds is not None and y == "N":
        thresholds = _alone(thresholds, "thresholds", thresholds.N_first.dims, (x,))
        _require_alike(thresholds, cells, x)
    if ends and "well" not in cells:
        raise ValueError(
            "cube: has no ends, as its runs end at the snap; sweep with until='settled'"
        )
    shows = "ends" if ends else "snaps"
    shown = states.coloured(shows, colours or {})
    axes = ax or style.notebook_axes()
    _fill_map(axes, (cells, thresholds, ()), x, y, (), shown)
    axes.set_title(place_text(cells, style.signs(axes, "axes.titlesize")))
    style.fit_labels(axes)
    if legend is not False:
        style.legend(axes, _keys([cells], [axes], shown), **({} if legend is True else legend))
    return axes


def _alone(data, name, dims, axes):
    """Leave out dimensions that have a single value; ValueError, one line, for several values."""
    others = [key for key in dims if key not in axes]
    if many := [key for key in others if data.sizes[key] != 1]:
        raise ValueError(f"{name}: has several {many[0]}; choose one, as {name}.isel({many[0]}=0)")
    return data.squeeze(others)


def _require_alike(thresholds, cells, x):
    """Raise ValueError, one line, if thresholds are not over x, or not those of the cells."""
    if x not in thresholds.N_first.dims:
        raise ValueError(f"thresholds: have no axis {x}; take those over {x}")
    alone = [key for key in thresholds.coords if thresholds[key].ndim == 0]
    for key in (key for key in alone if key in cells.coords and cells[key].ndim == 0):
        here, there = thresholds[key].item(), cells[key].item()
        if here != there:
            raise ValueError(f"thresholds: {key} is {show(here)}, but {show(there)} in the cube")


def draw_maps(
    figure: Figure,
    panels: Sequence[tuple[xr.Dataset, xr.Dataset | None, Sequence[tuple]]],
    x: str,
    y: str,
    own_points: Sequence[Point] = (),
    shows: str = "snaps",
) -> np.ndarray:
    """Draw several maps over the same axes, with a common legend, on an empty figure.

    panels: cells, thresholds or None, and required shocks of each map, as for `draw_map`
    Sets the height of the figure. Returns the axes, (rows, columns), None where there is no map.
    """
    panels, columns = _in_columns(panels)
    rows = -(-len(panels) // columns)
    figure.set_figheight(BESIDE + rows * ROW * MOST_COLUMNS / columns)
    axes = figure.subplots(rows, columns, squeeze=False)
    first, *others = cells = [cells for cells, *_ in panels]
    look, shown = _time_look(cells) if shows == "times" else {}, states.SHOWN[shows]
    fields, names = [], {}
    alone = [key for key in first.coords if first[key].ndim == 0]
    shared = [key for key in alone if others and all(panel[key] == first[key] for panel in others)]
    for place, ax in enumerate(axes.flat):
        if place >= len(panels):
            ax.remove()
            axes.flat[place] = None
            continue
        field, named = _fill_map(ax, panels[place], x, y, own_points, shown, look)
        fields, names = [*fields, field], names | named
        ax.set_title(place_text(panels[place][0].drop_vars(shared), 110 // columns))
        if rows > 1 and place == 0:  # a name may be longer than a map is high
            figure.supylabel(ax.get_ylabel(), size=ax.yaxis.label.get_size())
        if rows > 1 or place % columns:
            ax.set_ylabel("")
        ax.tick_params(axis="y", labelleft=place % columns == 0)
        if place + columns < len(panels):
            ax.set_xlabel("")
            ax.tick_params(axis="x", labelbottom=False)
        if place >= columns:
            for top in list(ax.child_axes):
                top.remove()
    words = place_text(first.drop_vars({*first.coords} - {*shared}), captions.PAGE)
    words = [words, captions.case(first.attrs), _numbered(names, captions.PAGE)]
    drawn = axes.flat[: len(panels)]
    keys = _keys(cells, drawn, shown)
    limits = [key for key in keys if key.get_label().startswith(LONG)]
    if limits[1:]:  # a single key stands for the limits of all panels
        limits[0].set_label(LONG)
        keys = [key for key in keys if key not in limits[1:]]
    style.legend(figure, keys, "\n".join(filter(None, words)))
    _add_time_bar(figure, drawn, next(filter(None, fields), None), look)
    return axes


def _in_columns(panels):
    """Order maps in rows and columns, so that a column has one value of an axis.

    Returns the maps and the number of columns.
    """
    cells = [cells for cells, *_ in panels]
    alone = [key for key in cells[0].coords if cells[0][key].ndim == 0]
    values = {key: [part[key].item() for part in cells] for key in alone}
    sizes = {key: len({*those}) for key, those in values.items() if len({*those}) > 1}
    rows = {key: len(panels) / size for key, size in sizes.items() if size <= MOST_COLUMNS}
    fitting = [key for key in rows if 1 < rows[key] <= MOST_COLUMNS]
    if not fitting or np.prod([*sizes.values()]) != len(panels):
        few = {1: 2, 2: 2, 4: 2, 3: 3, 5: 3, 6: 3, 9: 3}
        return panels, few.get(len(panels), MOST_COLUMNS)
    across = max(reversed(fitting), key=sizes.get)
    order = list(dict.fromkeys(values[across]))
    turn = sorted(range(len(panels)), key=lambda i: order.index(values[across][i]))
    return [panels[i] for i in np.reshape(turn, (len(order), -1)).T.flat], len(order)


def _fill_map(ax, panel, x, y, own_points, shown, look=None):
    """Draw a map; returns its field of times, or None, and the names of its shocks by number.

    panel: cells, thresholds or None, and required shocks; shown: as of `states.SHOWN`
    """
    cells, thresholds, shocks = plane.thin(panel[0], x, y), *panel[1:]
    across = plane.open_plane(ax, cells, x, y)
    known, classify = shown
    codes = classify(cells)
    plane.fill_states(ax, codes, known, *across)
    field = None
    if look and (codes < 0).any():
        times = {"cmap": states.TIME_COLOURS, "norm": look["norm"]}
        field = plane.fill_field(ax, cells.t_snap / look["size"], *across, **times)
    if "stress_share" in cells:
        plane.hatch(ax, cells.stress_share >= 1, *across, plane.BREAKS)
    plane.freeze(ax)
    if thresholds is not None and y == "N":
        if across[0].is_counted:
            thresholds = thresholds.reindex({x: across[0].values})
            thresholds = thresholds.assign_coords({x: across[0].places})
        thresholds = thresholds.sortby(x)
        draw_band(ax, scale_of(x, thresholds[x].values), thresholds)
        draw_static(ax, thresholds, x, "black")
        if x == "f0":
            draw_impulsive(ax, thresholds, "black")
    if (axis_behind(x), y) != ("f0", "N"):  # shocks have a place only there
        return field, {}
    plane.draw_points(ax, x, own_points)
    return field, plane.number_shocks(ax, x, shocks, own_points)


def _numbered(names, width):
    """Write the numbers of shocks with their names, in lines of so many signs."""
    return captions.fill((f"{number}: {names[number]}" for number in sorted(names)), width, "; ")


def _keys(panels, axes, shown):
    """Make the keys of a legend: of the states of all cells, and of labels on the axes."""
    known, classify = shown
    # Parts are read in turn, as a map may be larger than memory.
    codes = (classify(part) for cells in panels for part in plane.parts(cells))
    return [*plane.state_keys(codes, known), *style.labelled(axes)]

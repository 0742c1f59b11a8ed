"""The choice of figures of a study: their two axes, and the places on all other axes."""

from collections.abc import Collection, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..device.device import VALUES, Device
from ..files.text import describe, exact, stem_of
from ..numerics.portable import evenly
from ..study.axes import DURATION, KIND_OF, NAMES, PULSE_AXES, Grid, axis_behind, frequency_of
from ..values.arguments import Reading
from ..values.units import OF_DAMPER

MOST_DAMPINGS = 6
"""Most values of C that have a figure with lines for names, unless more are requested."""
MOST_MAPS = 12
"""Most maps that are drawn without a request."""
MAPS = "maps"
"""Name of the figure whose panels are the maps of cells without a request."""


class View(NamedTuple):
    """A figure over axes of a study.

    name: name of its file; views of the same name are panels of one figure
    x, y: names of axes; a figure of thresholds over x has a line for each value of y
    at: place on each other axis; a map without N among x, y and `at` shows thresholds
    required_shocks: on a map of cells: name, f0 (Hz), N, and whether the pulse is that of the map
    """

    name: str
    x: str
    y: str
    at: dict[str, int]
    required_shocks: tuple[tuple[str, float, float, bool], ...] = ()

    @property
    def is_of_cells(self) -> bool:
        """Whether the view shows cells, not thresholds."""
        return "N" in (self.x, self.y, *self.at)


def read_places(
    x: str,
    y: str,
    at: Mapping[str, object] | None,
    axes: Mapping[str, np.ndarray],
    unit_of_C: str = OF_DAMPER,
) -> dict[str, int]:
    """Find the places on axes, by name, nearest to the values that a view has under `at`.

    x, y: axes of the view; ValueError, one line, for axes or values that cannot be drawn
    """
    drawn = {axis_behind(name): name for name in (x, y)}
    for axis, name in drawn.items():
        if axis not in axes:
            raise ValueError(f"{name} is not an axis of this sweep; write {' or '.join(axes)}")
    if len(drawn) == 1:
        raise ValueError(f"{x} and {y} are the same axis; write two axes")
    places = {}
    for key, value in (at or {}).items():
        name, axis = f".at.{key}", axis_behind(key)
        if axis not in axes or axis in drawn or axis in places:
            raise ValueError(f"{name}: is not a free axis of this sweep")
        if axis in NAMES:
            if value not in axes[axis]:
                raise ValueError(f"{name}: no {axis} is called {describe(value)}")
            places[axis] = axes[axis].tolist().index(value)
            continue
        try:
            number = KIND_OF[key].convert(value, Reading(True, unit_of_C))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        places[axis] = _nearest(axes[axis], frequency_of(number) if key == DURATION else number)
    return places


def _nearest(values, value):
    with np.errstate(invalid="ignore"):  # where both are hard
        return int(np.argmin(np.where(values == value, 0, np.nan_to_num(abs(values - value)))))


def choose_maps(
    grid: Grid, nominal: Device, requests: Sequence[tuple] | None
) -> tuple[tuple[View, ...], str]:
    """Choose the requested maps, or one for each point of all axes but those of the default plane.

    requests: x, y and places of each map; on axes without a place it is drawn where the nominal
        device is, or in the middle
    Returns the maps, and one line on those that are left out, or an empty one.
    """
    if requests is not None:
        return _once(_view(grid, nominal, "map", *request) for request in requests), ""
    x, y = _default_plane(grid)
    others = [key for key in grid.axes if key not in (x, y) and not (key == "N" != y)]
    places = list(product(*(range(grid.axes[key].size) for key in others)))
    kept = evenly(len(places), MOST_MAPS)
    chosen = [dict(zip(others, places[place], strict=True)) for place in kept]
    line = ""
    if len(chosen) < len(places):
        line = (
            f"maps: {len(chosen)} of {len(places)} are drawn, evenly chosen over "
            f"{', '.join(others)}; name those you want under maps"
        )
    views = (View(_name(grid, "map", at), x, y, at) for at in chosen)
    return tuple(view._replace(name=MAPS) if view.is_of_cells else view for view in views), line


def batch_places(grid: Grid, figure: str, of: Collection[str] = NAMES) -> dict[str, dict[str, int]]:
    """Give a place for each combination of names, by the name of the figure there.

    figure: what it shows, as its name begins; of: axes of names that are combined
    """
    names = [key for key in _names(grid) if key in of]
    places = {}
    for place in product(*(range(grid.axes[key].size) for key in names)):
        at = dict(zip(names, place, strict=True))
        places[stem_of(figure, *(value_name(key, grid.axes[key], i) for key, i in at.items()))] = at
    return places


def choose_curves(
    grid: Grid, nominal: Device, requests: Sequence[tuple] | None
) -> tuple[View, ...]:
    """Choose the requested figures of thresholds, or one over each axis of several values.

    requests: x, axis of the lines, and places of each figure
    """
    if requests is not None:
        return _once(_view(grid, nominal, "thresholds", *request) for request in requests)
    several = _several(grid)
    over = list(dict.fromkeys(["f0", *(key for key in several if key not in (*NAMES, "C"))]))
    if len(over) > 1 and grid.axes["f0"].size == 1:
        over.remove("f0")
    drawn = [(x, _lines(grid, several, x)) for x in over]
    # Names on a further axis get lines of their own.
    drawn += [(over[0], key) for key in _names(grid) if key not in {y for _, y in drawn}]
    dampings = [{"C": place} for place in evenly(grid.axes["C"].size, MOST_DAMPINGS)]
    views = [
        _view(grid, nominal, "thresholds", x, y, at)
        for x, y in drawn
        for at in (dampings if y in NAMES else [{}])
    ]
    # The first keeps the plain name, whatever it is drawn over.
    return (views[0]._replace(name="thresholds"), *views[1:])


def choose_boundary(grid: Grid, nominal: Device) -> tuple[View, ...]:
    """Choose the figure of the damage boundary: none of a single duration, or pushed by a force."""
    if np.any(grid.device.force) or grid.axes["f0"].size == 1:
        return ()
    view = _view(grid, nominal, "thresholds", "f0", _lines(grid, [], "f0"), {})
    return (view._replace(name="damage_boundary"),)


def _lines(grid, several, x):
    """Choose the axis of which a figure of thresholds over x has a line for each value."""
    return next(key for key in (*_names(grid), "C", *several) if key in grid.axes and key != x)


def _names(grid):
    """List the axes of several names."""
    return [key for key in NAMES if key in grid.axes and grid.axes[key].size > 1]


def _default_plane(grid):
    """Choose x and y of maps without a request: N over f0, or over axes of several values."""
    several = [key for key in _several(grid) if key not in PULSE_AXES]
    first = "f0" if "f0" in several or not several else several[0]
    rest = [key for key in several if key != first]
    alone = grid.axes["N"].size == 1 and rest
    return first, rest[0] if alone else "N"


def _several(grid):
    """List the axes of several values, without N."""
    return [key for key, values in grid.axes.items() if values.size > 1 and key != "N"]


def _once(views):
    """Keep each view once: two requests may mean the same values."""
    return tuple({view.name: view for view in views}.values())


def _view(grid, nominal, stem, x, y, places):
    at = {
        key: places.get(key, _usual(values, key, nominal))
        for key, values in grid.axes.items()
        if key not in (axis_behind(x), axis_behind(y)) and (key != "N" or key in places)
    }
    return View(_name(grid, f"{stem}_{x}_{y}", at), x, y, at)


def _usual(values, key, nominal):
    """Find the place of the nominal device on an axis, or else its middle."""
    if key in NAMES:
        return 0
    if key not in VALUES:
        return values.size // 2
    owner = nominal.beam if hasattr(nominal.beam, key) else nominal
    return _nearest(values, getattr(owner, key))


def _name(grid, stem, at):
    """Name a figure, as map_thickness1.9_C25, by its places on C and on axes of several values."""
    parts = [
        value_name(key, grid.axes[key], place)
        for key, place in at.items()
        if grid.axes[key].size > 1 or key == "C"
    ]
    return stem_of(stem, *parts)


def value_name(key: str, values: np.ndarray, place: int) -> str:
    """Write a value of an axis for a file's name, as short as differs from all other values."""
    if key in NAMES:
        return str(values[place])
    words = [f"{value:.6g}" for value in values]
    is_short = np.isfinite(values[place]) and words.count(words[place]) == 1
    return key + (words[place] if is_short else exact(values[place]))

"""What is drawn of a study: which two axes, and where on all others."""

from collections.abc import Collection, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..axes import DEVICE, NAMES, PULSE_AXES, Grid, axis_behind
from ..device import VALUES, Device
from ..numerics.portable import evenly

MOST_DAMPINGS = 6
"""Figures of one kind, each at its own C, unless more are requested."""
MOST_MAPS, PANELS = 24, 12
"""Maps that are drawn unless more are requested by name, and most of them in one figure."""

# ASSUME: without a list of histories, the grid's cell nearest the handout's own case is drawn.
HANDOUT_CASE = {"N": 1000.0, "f0": 1500.0, "C": 0.025}


class View(NamedTuple):
    """A figure over axes of a study.

    name: of its file
    x, y: names of axes; of thresholds y has a line for each of its values
    at: place on each other axis; of a map without N as x or y and not in `at` thresholds are meant
    required_shocks: of a map of cells: name, f0 (Hz), N, and whether its pulse is that of the map
    """

    name: str
    x: str
    y: str
    at: dict[str, int]
    required_shocks: tuple[tuple[str, float, float, bool], ...] = ()

    @property
    def is_of_cells(self) -> bool:
        """Whether cells are meant, not thresholds."""
        return "N" in (self.x, self.y, *self.at)

    def called(self, stem: str) -> "View":
        """The same view of a map under a name that begins with another word than `map`."""
        return self._replace(name=f"{stem}{self.name.removeprefix('map')}")


def choose_maps(
    grid: Grid, nominal: Device, asked: Sequence[Mapping] | None
) -> tuple[tuple[View, ...], str]:
    """Choose maps: those requested, or N over f0 (or over what has several values) for all others.

    asked: x, y and at of each; what `at` leaves out is taken where the nominal device stands, or
        in the middle
    Returns them and one line on what is left out, or nothing.
    """
    if asked is not None:
        views = (_asked_view(grid, nominal, "map", v["x"], v["y"], v["at"]) for v in asked)
        return _once(views), ""
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
    return tuple(View(_name(grid, "map", at), x, y, at) for at in chosen), line


def batch_places(grid: Grid, of: Collection[str] = NAMES) -> dict[str, dict[str, int]]:
    """Places where devices as made are drawn, by the ending of the figures' names.

    of: those of the axes of names that matter
    """
    names = [key for key in _names(grid) if key in of]
    places = product(*(range(grid.axes[key].size) for key in names))
    found = [dict(zip(names, place, strict=True)) for place in places]
    return {
        "".join(f"_{value_name(key, grid.axes[key], i)}" for key, i in at.items()): at
        for at in found
    }


def side_by_side(maps: Sequence[View]) -> list[View]:
    """Maps of cells over the same axes, those of the first; at most PANELS, evenly chosen."""
    of_cells = [view for view in maps if view.is_of_cells]
    alike = [view for view in of_cells if (view.x, view.y) == (of_cells[0].x, of_cells[0].y)]
    return [alike[place] for place in evenly(len(alike), PANELS)]


def choose_curves(grid: Grid, nominal: Device, asked: Sequence[Mapping] | None) -> tuple[View, ...]:
    """Choose figures of thresholds: those requested, or one over each axis of several values."""
    if asked is not None:
        stem = "thresholds"
        return _once(_asked_view(grid, nominal, stem, v["x"], v["lines"], v["at"]) for v in asked)
    several = _several(grid, without="N")
    over = list(dict.fromkeys(["f0", *(key for key in several if key not in (*NAMES, "C"))]))
    if len(over) > 1 and grid.axes["f0"].size == 1:
        over.remove("f0")
    views = []
    for x in over:
        lines = _lines(grid, several, x)
        views.append(_asked_view(grid, nominal, "thresholds", x, lines, {}))
    # Names on a further axis get lines of their own.
    drawn = {view.y for view in views}
    names = [key for key in _names(grid) if key not in drawn]
    views += [_asked_view(grid, nominal, "thresholds", over[0], key, {}) for key in names]
    views = [each for view in views for each in _for_each_C(grid, nominal, view)]
    # The first keeps the plain name, whatever it is drawn over.
    return (views[0]._replace(name="thresholds"), *views[1:])


def _for_each_C(grid, nominal, view):
    """A view whose lines are names, for each C, at most MOST_DAMPINGS; any other as it is."""
    if view.y not in NAMES or "C" not in view.at:
        return [view]
    chosen = evenly(grid.axes["C"].size, MOST_DAMPINGS)
    at = ({**view.at, "C": place} for place in chosen)
    return [_asked_view(grid, nominal, "thresholds", view.x, view.y, one) for one in at]


def choose_boundary(grid: Grid, nominal: Device) -> View:
    """Choose the lines of the damage boundary, thresholds over f0."""
    lines = _lines(grid, [], "f0")
    return _asked_view(grid, nominal, "thresholds", "f0", lines, {})._replace(
        name="damage_boundary"
    )


def nearest_cell(grid: Grid, nominal: Device, case: Mapping[str, float]) -> dict[str, int]:
    """The place on each axis of the cell nearest a case of N, f0 (as a ratio) and C.

    On the device's axes it is where the nominal device stands, or where the first one does that
    can be.
    """
    at = {key: _usual(values, key, nominal) for key, values in grid.axes.items()}
    of_device = [key for key in at if key == DEVICE or key in VALUES]
    if grid.device_of[tuple(at[key] for key in of_device)] < 0:
        at |= zip(of_device, np.argwhere(grid.device_of >= 0)[0].tolist(), strict=True)
    for key, value in case.items():
        values = grid.axes[key]
        apart = np.log(values / value) if key == "f0" else values - value
        at[key] = int(np.argmin(abs(apart)))
    return at


def _lines(grid, several, x):
    """Of which axis a figure of thresholds has a line for each value."""
    return next(key for key in (*_names(grid), "C", *several) if key in grid.axes and key != x)


def _names(grid):
    """Axes of several names."""
    return [key for key in NAMES if key in grid.axes and grid.axes[key].size > 1]


def _default_plane(grid):
    several = _several(grid, without="N")
    several = [key for key in several if key not in PULSE_AXES]
    first = "f0" if "f0" in several or not several else several[0]
    rest = [key for key in several if key != first]
    alone = grid.axes["N"].size == 1 and rest
    return first, rest[0] if alone else "N"


def _several(grid, without):
    return [key for key, values in grid.axes.items() if values.size > 1 and key != without]


def _once(views):
    """Each view once: two that are asked for may mean the same values."""
    return tuple({view.name: view for view in views}.values())


def _asked_view(grid, nominal, stem, x, y, given):
    at = {
        key: given.get(key, _usual(values, key, nominal))
        for key, values in grid.axes.items()
        if key not in (axis_behind(x), axis_behind(y)) and (key != "N" or key in given)
    }
    return View(_name(grid, f"{stem}_{x}_{y}", at), x, y, at)


def _usual(values, key, nominal):
    """Where the nominal device stands on an axis, or its middle."""
    if key in NAMES:
        return 0
    if key not in VALUES:
        return values.size // 2
    value = getattr(nominal.beam, key, None)
    value = getattr(nominal, key) if value is None else value
    with np.errstate(invalid="ignore"):
        return int(np.argmin(np.where(values == value, 0, np.nan_to_num(abs(values - value)))))


def _name(grid, stem, at):
    """map_thickness1.9_C25; an axis of one value is not named, but C is."""
    parts = [
        value_name(key, grid.axes[key], place)
        for key, place in at.items()
        if grid.axes[key].size > 1 or key == "C"
    ]
    return "_".join([stem, *parts])


def value_name(key: str, values: np.ndarray, place: int) -> str:
    """Name a value of an axis in a file's name: as short as tells it from the others."""
    if key in NAMES:
        return str(values[place]).replace(" ", "_")
    words = [f"{value:.6g}" for value in values]
    word = words[place] if words.count(words[place]) == 1 else f"{values[place]:.15g}"
    return f"{key}{word.replace('inf', 'hard')}"

"""The figures of the core that a run draws: maps of cells and of thresholds, and curves."""

from typing import NamedTuple

from ..applications import attached
from ..config.study import Config
from ..config.views import MAPS
from ..study.axes import DIRECTION, SHAPE

WORDS = {"snaps": "snap", "times": "time", "ends": "map"}
"""Word with which the name of a figure's file begins, by what its maps of cells show."""


class Views(NamedTuple):
    """The figures of cells and thresholds, in plain values.

    maps: figures of cells: `name`, what each `shows` (a key of WORDS), and its views as `panels`
    fields: maps of thresholds; curves: thresholds over an axis; own_points: as a `Config` has them
    """

    maps: list[dict]
    fields: list[dict]
    curves: list[dict]
    own_points: list

    @property
    def stems(self) -> dict[str, list[str]]:
        """Names of figures by their caption in the report."""
        snaps = [figure for figure in self.maps if figure["shows"] == "snaps"]
        others = [figure for figure in self.maps if figure not in snaps]
        parts = {"snap_maps": snaps + self.fields, "maps": others, "thresholds": self.curves}
        return {part: [figure["name"] for figure in figures] for part, figures in parts.items()}


def choose_views(study: Config) -> Views:
    """Choose the figures of the cells and thresholds of a study."""
    of_cells = [_with_shocks(view, study) for view in study.maps if view.is_of_cells]
    shown = [key for key in WORDS if key != "ends" or study.until == "settled"]
    maps = []
    for name in dict.fromkeys(view.name for view in of_cells):
        panels = [view._asdict() for view in of_cells if view.name == name]
        of_panels = ({"name": _called(name, WORDS[shows]), "shows": shows} for shows in shown)
        maps += [figure | {"panels": panels} for figure in of_panels]
    fields = [view._asdict() for view in study.maps if not view.is_of_cells]
    curves = [view._asdict() for view in study.curves]
    return Views(maps, fields, curves, list(study.own_points))


def _called(name, word):
    """Name a figure by the name of its views, with another word in place of `map`."""
    if word == "map":
        return name
    return f"{word}_{name}" if name == MAPS else f"{word}{name.removeprefix('map')}"


def _with_shocks(view, study):
    """Add the required shocks to a map, each with whether it has the pulse of the map's cells."""
    shape = list(study.shocks.shapes.values())[view.at.get(SHAPE, 0)]
    direction = study.shocks.directions[view.at.get(DIRECTION, 0)]
    of_map = shape.section, direction, study.start
    marks = [mark for part in attached().values() for mark in part.marks(study)]
    required = [(name, f0, N, of_map in pushed) for name, f0, N, pushed in marks]
    return view._replace(required_shocks=tuple(required))

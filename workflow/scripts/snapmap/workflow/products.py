"""The figures of the core that a run draws: maps of cells and of thresholds, and curves."""

from typing import NamedTuple

from ..applications import attached
from ..config.study import Config
from ..config.views import MAPS, View
from ..study.axes import DIRECTION, SHAPE

WORDS = {"snaps": "snap", "times": "time", "ends": "map"}
"""Word with which the name of a figure's file begins, by what its maps of cells show."""


class Maps(NamedTuple):
    """A figure with maps of cells: its name, what it shows (a key of WORDS), and its views."""

    name: str
    shows: str
    panels: list[dict]


class Views(NamedTuple):
    """The figures of cells and thresholds.

    maps: figures of cells; fields: maps of thresholds; curves: thresholds over an axis
    """

    maps: list[Maps]
    fields: list[View]
    curves: tuple[View, ...]

    @property
    def stems(self) -> dict[str, list[str]]:
        """Names of figures by their caption in the report."""
        snaps = [figure for figure in self.maps if figure.shows == "snaps"]
        return {
            "snap_maps": _names([*snaps, *self.fields]),
            "maps": _names(figure for figure in self.maps if figure not in snaps),
            "thresholds": _names(self.curves),
        }


def choose_views(study: Config) -> Views:
    """Choose the figures of the cells and thresholds of a study."""
    of_cells = [_with_shocks(view, study) for view in study.maps if view.is_of_cells]
    shown = [key for key in WORDS if key != "ends" or study.run.until == "settled"]
    figures = [(name, shows) for name in dict.fromkeys(_names(of_cells)) for shows in shown]
    return Views(
        maps=[
            Maps(
                name=_called(name, WORDS[shows]),
                shows=shows,
                panels=[view._asdict() for view in of_cells if view.name == name],
            )
            for name, shows in figures
        ],
        fields=[view for view in study.maps if not view.is_of_cells],
        curves=study.curves,
    )


def _called(name, word):
    """Name a figure by the name of its views, with another word in place of `map`."""
    if word == "map":
        return name
    return f"{word}_{name}" if name == MAPS else f"{word}{name.removeprefix('map')}"


def _with_shocks(view, study):
    """Add the required shocks to a map, each with whether it has the pulse of the map's cells."""
    shape = list(study.shocks.shapes.values())[view.at.get(SHAPE, 0)]
    direction = study.shocks.directions[view.at.get(DIRECTION, 0)]
    of_map = shape.section, direction, study.run.start
    marks = [mark for part in attached().values() for mark in part.marks(study)]
    required = [(name, f0, N, of_map in pushed) for name, f0, N, pushed in marks]
    return view._replace(required_shocks=tuple(required))


def _names(views):
    return [view.name for view in views]

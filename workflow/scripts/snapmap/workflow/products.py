"""Figures of the core that a run draws: maps of cells and of thresholds, and curves."""

from typing import NamedTuple

from ..applications import gather
from ..config.study import Config
from ..config.views import View, side_by_side
from ..study.axes import DIRECTION, SHAPE


class Views(NamedTuple):
    """What is drawn of cells and thresholds.

    ends, times, snaps: maps of cells: where beams end, when and whether they snap
    fields: maps of thresholds; together: maps of cells that are drawn side by side
    curves: thresholds over an axis
    """

    ends: list[View]
    times: list[View]
    snaps: list[View]
    fields: list[View]
    together: list[View]
    curves: tuple[View, ...]

    @property
    def stems(self) -> dict[str, list[str]]:
        """Names of figures, by the caption that they have in the report."""
        stems = {
            "snap_maps": _names(self.snaps) + _names(self.fields),
            "maps": _names(self.times) + _names(self.ends),
            "thresholds": _names(self.curves),
        }
        if self.snaps:
            stems["snap_maps"].append("snap_maps")
        if self.ends:
            stems["maps"].append("maps")
        return stems


def choose_views(study: Config) -> Views:
    """Choose what is drawn of the cells and thresholds of a study."""
    of_cells = [_with_shocks(view, study) for view in study.maps if view.is_of_cells]
    return Views(
        ends=of_cells if study.settings.until == "settled" else [],
        times=[view.called("time") for view in of_cells],
        snaps=[view.called("snap") for view in of_cells],
        fields=[view for view in study.maps if not view.is_of_cells],
        together=side_by_side(of_cells),
        curves=study.curves,
    )


def _with_shocks(view, study):
    """A map with the required shocks, and whether each has the pulse of the map's cells."""
    shape = list(study.shocks.shapes.values())[view.at.get(SHAPE, 0)]
    direction = study.shocks.directions[view.at.get(DIRECTION, 0)]
    of_map = shape.given, direction, study.settings.start
    marks = [mark for marks in gather("marks", study).values() for mark in marks]
    required = [(name, f0, N, of_map in pushed) for name, f0, N, pushed in marks]
    return view._replace(required_shocks=tuple(required))


def _names(views):
    return [view.name for view in views]

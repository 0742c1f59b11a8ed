"""What a study makes: the figures and files of a run, by name."""

from typing import NamedTuple

from ..config.study import Config
from ..config.views import (
    History,
    View,
    batch_places,
    choose_window,
    side_by_side,
)
from ..device.device import Device
from ..solver.settings import FIRST
from ..study.axes import DEVICE, DIRECTION, SHAPE


class Products(NamedTuple):
    """Files of a run, by their names without folder and ending.

    ends, times, snaps: maps of cells: where beams end, when and whether they snap
    fields: maps of thresholds; together: maps of cells that are drawn side by side
    batches, yields: places on the axes of names of figures of devices as made, by the ending of
        their names; a yield does not depend on the study's own pulse
    window: axes over which requirements are drawn, if two have several values
    histories: cells followed in full; statics: devices by the ending of their files' names
    traces: files of all cells' motion: of a study that asks for them, or has a strength
    map_stems, snap_stems, curve_stems, batch_stems: figures, by the rule that draws them
    stems: all figures
    """

    ends: list[View]
    times: list[View]
    snaps: list[View]
    fields: list[View]
    together: list[View]
    batches: dict[str, dict[str, int]]
    yields: dict[str, dict[str, int]]
    window: tuple[str, ...]
    histories: dict[str, History]
    statics: dict[str, Device]
    traces: list[str]
    map_stems: list[str]
    snap_stems: list[str]
    curve_stems: list[str]
    batch_stems: list[str]
    stems: list[str]


def products(study: Config) -> Products:
    """List what is made of a study."""
    of_cells = [_with_shocks(view, study) for view in study.maps if view.is_of_cells]
    ends = of_cells if study.settings.until == "settled" else []
    times, snaps = ([view.called(word) for view in of_cells] for word in ("time", "snap"))
    fields = [view for view in study.maps if not view.is_of_cells]
    batches = batch_places(study.grid)
    yields = batch_places(study.grid, of=[DEVICE]) if study.requirements else {}
    window = choose_window(study.grid) if study.requirements else ()
    several = isinstance(study.device, dict)
    statics = {f"_{name}" if several else "": one for name, one in study.devices().items()}
    histories = {cell.name: cell for cell in study.histories}
    maps = [*_names(times), *_names(ends), *["maps"] * bool(ends)]
    snap_maps = [*_names(snaps), *["snap_maps"] * bool(snaps), *_names(fields)]
    curves = [*_names(study.curves), *_names(study.boundary)]
    made = [f"{stem}{ending}" for stem in ("probability", "sensitivity") for ending in batches]
    made += [f"yield{ending}" for ending in yields]
    return Products(
        *(ends, times, snaps, fields, side_by_side(of_cells)),
        *(batches, yields, window, histories, statics),
        ["results/traces.nc"] * (study.traces or study.has_strength),
        *(maps, snap_maps, curves, made),
        [
            *(*snap_maps, *maps, *curves),
            *(f"history_{name}" for name in histories),
            *(f"statics{which}" for which in statics),
            *["requirements"] * bool(study.all_required),
            *["window"] * bool(window),
            *(made if study.tolerances else []),
            *["calibration"] * bool(study.calibration),
        ],
    )


def _with_shocks(view, study):
    """A map with the required shocks, and whether each has the pulse of the map's cells."""
    shape = list(study.shocks.shapes.values())[view.at.get(SHAPE, 0)]
    direction = study.shocks.directions[view.at.get(DIRECTION, 0)]
    required = []
    for one in study.requirements:
        own, start = one["shocks"], one.get("start", FIRST)
        pushed = [(shocks.pulse.given, shocks.direction, start) for shocks in own.each()]
        is_of_map = (shape.given, direction, study.settings.start) in pushed
        required.append((one["name"], one["f0"], one["N"], is_of_map))
    return view._replace(required_shocks=tuple(required))


def _names(views):
    return [view.name for view in views]

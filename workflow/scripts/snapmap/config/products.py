"""What a study makes: the figures and files of a run, by name."""

from typing import NamedTuple

from ..device import Device
from .histories import History
from .study import Config
from .views import View, batch_places, side_by_side


class Products(NamedTuple):
    """Files of a run, by their names without folder and ending.

    ends, times, snaps: maps of cells: where beams end, when and whether they snap
    fields: maps of thresholds; together: maps of cells that are drawn side by side
    batches: places on the axes of names of figures of devices as made, by the ending of their names
    histories: cells followed in full; statics: devices by the ending of their files' names
    map_stems, snap_stems, curve_stems, batch_stems: figures, by the rule that draws them
    stems: all figures
    """

    ends: list[View]
    times: list[View]
    snaps: list[View]
    fields: list[View]
    together: list[View]
    batches: dict[str, dict[str, int]]
    histories: dict[str, History]
    statics: dict[str, Device]
    map_stems: list[str]
    snap_stems: list[str]
    curve_stems: list[str]
    batch_stems: list[str]
    stems: list[str]


def products(study: Config) -> Products:
    """List what is made of a study."""
    of_cells = [view for view in study.maps if view.is_of_cells]
    ends = of_cells if study.settings.until == "settled" else []
    times, snaps = ([view.called(word) for view in of_cells] for word in ("time", "snap"))
    fields = [view for view in study.maps if not view.is_of_cells]
    batches = batch_places(study.grid)
    of_batch = ["probability", "sensitivity", *["yield"] * bool(study.requirements)]
    several = isinstance(study.device, dict)
    statics = {f"_{name}" if several else "": one for name, one in study.devices().items()}
    histories = {cell.name: cell for cell in study.histories}
    maps = [*_names(ends), *["maps"] * bool(ends), *_names(times)]
    snap_maps = [*_names(snaps), *["snap_maps"] * bool(snaps), *_names(fields)]
    curves = [*_names(study.curves), study.boundary.name]
    made = [f"{stem}{ending}" for stem in of_batch for ending in batches]
    return Products(
        *(ends, times, snaps, fields, side_by_side(of_cells)),
        *(batches, histories, statics),
        *(maps, snap_maps, curves, made),
        [
            *(*maps, *snap_maps, *curves),
            *(f"history_{name}" for name in histories),
            *(f"statics{which}" for which in statics),
            *["requirements"] * bool(study.requirements),
            *(made if study.tolerances else []),
        ],
    )


def _names(views):
    return [view.name for view in views]

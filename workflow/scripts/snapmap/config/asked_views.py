"""The maps and thresholds that a config asks to be drawn."""

from collections.abc import Mapping

import numpy as np

from ..axes import DURATION, NAMES, Grid, axis_behind
from ..quantities import QUANTITIES
from .axes import frequency_of
from .faults import Faults, convert_part
from .schema import name_of
from .units import read, show


def read_views(
    document: Mapping, section: str, faults: Faults, grid: Grid | None
) -> list[dict] | None:
    """Read the views of a section, with `at` as places on the axes; None if it is not there.

    The nearest value of an axis stands for another.
    """
    asked = document.get(section)
    if asked is None or grid is None:
        return None
    places = ((section, place) for place in range(len(asked)))
    return [convert_part(document, place, faults, _view, place, grid.axes) for place in places]


def _view(asked, path, axes):
    at = {}
    used = {key: asked[key] for key in ("x", "y", "lines") if key in asked}
    for key, axis in used.items():
        if axis_behind(axis) not in axes:
            raise ValueError(f"{name_of((*path, key))}: {axis} is no axis of this sweep")
    drawn = {axis_behind(axis) for axis in used.values()}
    if len(drawn) < len(used):
        raise ValueError(f"{name_of(path)}: {' and '.join(used)} are the same axis; write two")
    for asked_axis, value in asked.get("at", {}).items():
        name, axis = name_of((*path, "at", asked_axis)), axis_behind(asked_axis)
        if axis not in axes or axis in drawn or axis in at:
            raise ValueError(f"{name}: is no axis of this sweep, or one that is drawn")
        if axis in NAMES:
            if value not in axes[axis]:
                raise ValueError(f"{name}: no {axis} is called {show(value)}")
            at[axis] = axes[axis].tolist().index(value)
            continue
        try:
            number = read(value, QUANTITIES[asked_axis].kind)
            number = frequency_of(number) if asked_axis == DURATION else number
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        with np.errstate(invalid="ignore"):
            apart = np.where(axes[axis] == number, 0, np.nan_to_num(abs(axes[axis] - number)))
        at[axis] = int(np.argmin(apart))
    return used | {"at": at}

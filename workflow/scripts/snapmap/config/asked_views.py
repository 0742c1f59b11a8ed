"""The maps and thresholds that a config asks to be drawn."""

from collections.abc import Mapping

import numpy as np

from ..axes import DURATION, NAMES, axis_behind
from ..quantities import QUANTITIES
from .models import frequency_of
from .units import read, show


def read_view(asked: Mapping, axes: Mapping[str, np.ndarray]) -> dict:
    """A view with `at` as places on the axes; ValueError, one line, for one that cannot be.

    The nearest value of an axis stands for another.
    """
    at = {}
    used = {key: asked[key] for key in ("x", "y", "lines") if key in asked}
    for key, axis in used.items():
        if axis_behind(axis) not in axes:
            raise ValueError(f".{key}: {axis} is no axis of this sweep")
    drawn = {axis_behind(axis) for axis in used.values()}
    if len(drawn) < len(used):
        raise ValueError(f"{' and '.join(used)} are the same axis; write two")
    for asked_axis, value in asked.get("at", {}).items():
        name, axis = f".at.{asked_axis}", axis_behind(asked_axis)
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

"""A user's own points."""

from collections.abc import Mapping

import numpy as np

from ..io.tables import read_points


def own_points_outside(path: str, axes: Mapping[str, np.ndarray]) -> list[str]:
    """A line for each of a user's own points that lies on no map."""
    lines = []
    for number, point in enumerate(read_points(path), start=1):
        for key, value in (("f0", point.f0), ("N", point.N)):
            low, high = axes[key].min(), axes[key].max()
            if not low <= value <= high:
                place = f"{key} = {value:g}, maps from {low:g} to {high:g}"
                who = f"{path}: {point.name or f'point {number}'}"
                lines.append(f"{who} lies on no map: {place}")
    return lines

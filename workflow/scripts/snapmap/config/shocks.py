"""What must or must not trip a device, and a user's own points."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..io.tables import read_points


class Requirement(NamedTuple):
    """A shock that must or must not trip the device.

    pulse: values for `make_shocks`; N: multiples of g; f0: Hz; snaps: whether it must
    survives: the least probability with which its beam must not break; 0 if it may
    """

    name: str
    pulse: dict
    N: float
    f0: float
    snaps: bool
    survives: float


class Vibration(NamedTuple):
    """Random vibration that must or must not trip the device.

    psd: pairs of Hz and g^2/Hz; duration: s; snaps: whether it must, but for `probability`
    """

    name: str
    psd: list[list[float]]
    duration: float
    snaps: bool
    probability: float


class SpectrumTest(NamedTuple):
    """A shock response spectrum whose records must or must not trip the device.

    srs: pairs of Hz and multiples of g; snaps: whether all must, or none
    """

    name: str
    srs: list[list[float]]
    direction: str
    snaps: bool


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

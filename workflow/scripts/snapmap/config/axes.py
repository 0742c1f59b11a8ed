"""What the values of axes, devices and shocks are, and axes as a config writes them."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..numerics.portable import geometric, linear
from ..quantities import KINDS, QUANTITIES
from .units import read


def frequency_of(duration: float) -> float:
    """Hz, of a pulse of so many us, to 14 digits: 0.5 ms is 2000 Hz."""
    return float(f"{1e6 / duration:.14g}")


def read_axis(section: Mapping | Sequence, key: str) -> np.ndarray:
    """Read the values of one axis, ascending, in internal units; a duration becomes f0, in Hz.

    section: values, or a range; raises ValueError, one line, naming what cannot be
    """
    kind = QUANTITIES[key].kind
    if isinstance(section, Mapping):
        values = _range(section, f"sweep.{key}", kind)
    else:
        values = np.array([read(value, kind) for value in section])
    values = np.sort(values)
    before, after = values[:-1], values[1:]
    repeated = after[(after == before) | (after * (1 - 1e-14 * np.sign(after)) <= before)]
    if repeated.size:
        value = f"{repeated[0]:.15g} {KINDS[kind].unit}".strip()
        raise ValueError(f"sweep.{key}: {value} comes twice; write every value once")
    if key == "duration":
        return np.array([frequency_of(value) for value in values[::-1].tolist()])
    return values


def _range(section, key, kind):
    start, stop, points = read(section["from"], kind), read(section["to"], kind), section["points"]
    if not np.isfinite([start, stop]).all():
        raise ValueError(f"{key}: hard is no end of a range; write a list")
    if (points == 1) != (start == stop):
        need = "equal ends" if points == 1 else "from and to that differ"
        raise ValueError(f"{key}.points: {points} needs {need}; write other ends or points")
    if section.get("spacing") != "log":
        return linear(start, stop, points)
    if min(start, stop) <= 0:
        raise ValueError(f"{key}.spacing: log needs from and to above 0; write linear, or a list")
    return geometric(start, stop, points)

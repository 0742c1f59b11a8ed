"""The axes of a study: their names, their order, and the devices at their points.

An axis is a list of values of N, f0, C or a value of the device; the axis `device` lists whole
devices by name. The order is the same everywhere: axes of the device as the study names them, the
pulse's shape and direction, C, f0, and N, along which thresholds are sought.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..device.device import KINDS, OF_MASS, Device, batch, is_bistable
from ..pulse.pulse import Pulse
from ..pulse.shocks import HANDOUT_SHOCK, Shocks
from ..solver.cells import Rows, to_rows
from ..values.kinds import Quantity, kind_of
from ..values.quantities import Amplitude, Damper, Frequency, PulseTime
from ..values.units import OF_DAMPER, spelling

SHOCK_AXES = ("C", "f0", "N")
DEVICE = "device"
"""Name of the axis of named devices."""
SHAPE, DIRECTION = "shape", "direction"
"""Names of the axes of the pulse's shape, and of the direction in which the frame is pushed."""
PULSE_AXES = (SHAPE, DIRECTION)
NAMES = (DEVICE, *PULSE_AXES)
"""Axes whose points are names, which keep their order."""
DURATION = "duration"
"""Name of the axis that figures may show instead of f0: 1e3/f0, ms."""

TEMPERATURE = "temperature"
"""Axis of the device that no design chooses."""
Units = Mapping[str, tuple[str, float]]
"""Units of a config's axes, by name: their spelling, and their size in internal units."""

MOST_DEVICES = 100_000
"""Most points on the axes of the device; more are taken for a slip."""

_OF_SHOCK = {"C": Damper, "f0": Frequency, "N": Amplitude, DURATION: PulseTime}
KIND_OF: dict[str, Quantity] = KINDS | {key: kind_of(hint) for key, hint in _OF_SHOCK.items()}
"""Kind of the values on each axis of numbers, by name."""


with open(Path(__file__).with_suffix(".csv"), encoding="utf-8") as _file:
    COORDINATES = {row["name"]: row["long_name"] for row in csv.DictReader(_file)}
"""Long name of each quantity that can be an axis, by name."""


def unit_on(name: str, unit_of_C: str = OF_DAMPER) -> str:
    """Give the unit of an axis, as a config spells it; a user's own law may state that of C."""
    return unit_of_C if name == "C" else KIND_OF[name].unit


def attributes_of(name: str, unit_of_C: str = OF_DAMPER) -> dict[str, str]:
    """Give the CF attributes of a quantity; none of one that cannot be an axis."""
    units = {"units": spelling(unit_on(name, unit_of_C)).files} if name in KIND_OF else {}
    return {"long_name": COORDINATES[name]} | units if name in COORDINATES else {}


def duration_of(f0: float) -> float:
    """Give the duration, ms, of a pulse by f0, Hz, to 12 digits, as an f0 of 0.9 ms has 14."""
    return float(f"{1e3 / f0:.12g}")


def frequency_of(duration: float) -> float:
    """Give the frequency, Hz, of a pulse by its duration, us, to 14 digits: 0.5 ms is 2000 Hz."""
    return float(f"{1e6 / duration:.14g}")


def frequencies(f0: Any, duration: Any) -> Any:
    """Give f0, Hz, or that of durations, us; None where both are."""
    if duration is None:
        return f0
    if np.ndim(duration):
        return np.array([frequency_of(each) for each in duration])
    return frequency_of(duration)


class Grid(NamedTuple):
    """All points of a study's axes.

    axes: values by name, in order; internal units, f0 in Hz, names on axes of NAMES
    device: batch of the devices that can exist
    device_of: index in the batch, in the shape of the device's axes; -1 where no device can exist
    pulses: pulses at the points of the pulse's axes, in order
    """

    axes: dict[str, np.ndarray]
    device: Device
    device_of: np.ndarray
    pulses: tuple[Pulse, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points on each axis."""
        return tuple(values.size for values in self.axes.values())


def make_grid(
    device: Device | Mapping[str, Device],
    axes: Mapping[str, Sequence],
    skip: bool = False,
    shocks: Shocks = HANDOUT_SHOCK,
) -> Grid:
    """Make the grid of axes; raises ValueError, one line, with the first point that cannot exist.

    device: nominal device, or several by name, which are the first axis
    axes: values by name, those of the device first
    skip: whether points without a second stable shape are left out instead
    """
    points = {key: np.atleast_1d(np.asarray(values, float)) for key, values in axes.items()}
    by_name = device if isinstance(device, Mapping) else {}
    nominal = list(by_name.values()) if by_name else [device]
    _require_axes(points, nominal)
    names = {DEVICE: np.array(list(by_name))} if by_name else {}
    device_axes = names | {key: points[key] for key in points if key not in SHOCK_AXES}
    shape = tuple(values.size for values in device_axes.values())
    if math.prod(shape) > MOST_DEVICES:
        size = f"axes of the device: {math.prod(shape):.3g} points"
        raise ValueError(f"{size}, more than {MOST_DEVICES}; write fewer")
    places = np.indices(shape).reshape(len(shape), math.prod(shape))
    point = {key: axis[i] for (key, axis), i in zip(device_axes.items(), places, strict=True)}
    devices = _batch(*nominal)
    if device_axes:
        devices = devices.pick(places[0] if by_name else np.zeros(places.shape[1], int))
    varied = {key: column for key, column in point.items() if key != DEVICE}
    exists = is_bistable(devices, varied, len(devices)) if skip else np.ones(len(devices), bool)
    if exists.any():
        point = {key: column[exists] for key, column in point.items()}
        device = _vary(devices if exists.all() else devices.pick(exists), point)
    else:  # models need a device with two shapes, though no cell has it
        most = devices.pick([0]).beam.most_stress
        device = devices.pick([0]).vary({"residual_stress": most - abs(most)})
    return Grid(
        axes=device_axes | shocks.axes | {key: points[key] for key in SHOCK_AXES if key in points},
        device=device,
        device_of=np.where(exists, np.cumsum(exists) - 1, -1).reshape(shape),
        pulses=shocks.pulses,
    )


@lru_cache(maxsize=16)
def _batch(*devices):
    """Make the batch of nominal devices once, as its shapes at rest take long to find."""
    return batch(devices)


def _require_axes(points, nominal):
    """Raise ValueError, one line, for values of axes or nominal devices that no grid can have."""
    for device in nominal:
        idle = [key for key in points if key in OF_MASS and np.all(device.is_alone)]
        if idle:
            raise ValueError(f"{idle[0]}: needs a mass; leave it out")
    if len({device.gravity for device in nominal}) > 1:
        raise ValueError("devices: gravity differs; write one value, as N counts multiples of it")


def rows_of(grid: Grid) -> Rows:
    """Give all points of the axes but N as rows, whose device is -1 where none exists."""
    C, f0 = grid.axes["C"], grid.axes["f0"]
    device, pulse = grid.device_of, np.arange(len(grid.pulses))
    device, pulse = np.expand_dims(device, (-3, -2, -1)), np.expand_dims(pulse, (-2, -1))
    return to_rows(device, f0, C[:, np.newaxis], pulse, grid.pulses)


def _vary(devices, point):
    """Set the values of points, (devices,); a ValueError names the first that cannot exist."""
    values = {key: column for key, column in point.items() if key != DEVICE}
    try:
        return devices.vary(values)
    except ValueError:
        for i in range(len(devices) if point else 0):
            try:
                devices.pick([i]).vary({key: column[[i]] for key, column in values.items()})
            except ValueError as error:
                where = point_text({key: column[i] for key, column in point.items()})
                raise ValueError(f"{where}: {error}") from None
        raise


def point_text(point: Mapping[str, float | str], unit_of_C: str = OF_DAMPER) -> str:
    """Write the place of a point on its axes, with units, for messages."""
    return ", ".join(
        f"{key} = {value}"
        if key in NAMES
        else f"{key} = {value:.6g} {unit_on(key, unit_of_C)}".rstrip()
        for key, value in point.items()
    )


def axis_behind(name: str) -> str:
    """Give the axis of a study behind the axis of a figure."""
    return "f0" if name == DURATION else name


def shared_points(axes: Mapping[str, np.ndarray], others: Mapping) -> tuple[tuple, tuple]:
    """Find the values that two sets of axes share; returns indices into both, for each axis."""
    pairs = [
        np.intersect1d(axes[key], others[key], assume_unique=True, return_indices=True)[1:]
        for key in axes
    ]
    return tuple(zip(*pairs, strict=True))

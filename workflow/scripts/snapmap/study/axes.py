"""The axes of a study: their names, their order, and the devices that stand on them.

An axis is a list of points; a point of N, f0, C or a value of the device sets that one, a point of
`device` sets all. Whatever has cells has its axes in this order: those of the device as the study
names them, then the pulse's shape and direction, C, f0 and N, along which thresholds are sought.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..device.device import OF_MASS, Device, batch, is_bistable
from ..device.quantities import QUANTITIES
from ..pulse.pulse import Pulse
from ..pulse.shocks import HANDOUT_SHOCK, Shocks
from ..solver.cells import Rows, to_rows

SHOCK_AXES = ("C", "f0", "N")
DEVICE = "device"
"""The axis of devices that have names."""
SHAPE, DIRECTION = "shape", "direction"
"""The axes of the pulse's shape, by name, and of the direction in which the frame is pushed."""
PULSE_AXES = (SHAPE, DIRECTION)
NAMES = (DEVICE, *PULSE_AXES)
"""Axes whose points have names, and no order but the one they were given in."""
DURATION = "duration"
"""f0 by another name, where figures are drawn over it; 1e3/f0, ms."""

TEMPERATURE = "temperature"
"""An axis of the device that no design chooses."""
Units = Mapping[str, tuple[str, float]]
"""Units in which a config writes axes: their spelling, and how many internal ones each is."""

MOST_DEVICES = 100_000
"""More points on the device's axes are taken for a slip."""

COORDINATES = {
    key: quantity.attributes for key, quantity in QUANTITIES.items() if quantity.long_name
}
"""CF attributes of each quantity that can be an axis, by name."""


class Grid(NamedTuple):
    """All points of a study's axes.

    axes: values by name, in order; internal units, f0 in Hz, names for those in NAMES
    device: a batch of the devices that can be
    device_of: index in it for each point of the device's axes, -1 where none can be; an array of
        their shape, () if there are none
    pulses: one for each point of the pulse's axes, in order
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
    """Set out the points of axes; raises ValueError, one line, naming a point that cannot be.

    device: the nominal one, or several by name, which then are an axis in front
    axes: values by name, those of the device first
    skip: whether a point that has no second stable shape is left out instead
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
    # Each point of the device's axes by its values there, and the device that it varies.
    columns = zip(device_axes.items(), places, strict=True)
    point = {key: values[place] for (key, values), place in columns}
    devices = batch(nominal).pick(places[0] if by_name else np.zeros(places.shape[1], int))
    varied = {key: column for key, column in point.items() if key != DEVICE}
    exists = is_bistable(devices, varied, len(devices)) if skip else np.ones(len(devices), bool)
    if exists.any():
        point = {key: column[exists] for key, column in point.items()}
        device = _vary(devices.pick(exists), point)
    else:  # the first one, unvaried, says which models there are
        device = devices.pick([0])
    return Grid(
        axes=device_axes | shocks.axes | {key: points[key] for key in SHOCK_AXES if key in points},
        device=device,
        device_of=np.where(exists, np.cumsum(exists) - 1, -1).reshape(shape),
        pulses=shocks.pulses,
    )


def _require_axes(points, nominal):
    """Raise ValueError for values of axes, or nominal devices, that no grid can have."""
    if (points.get("N", np.zeros(1)) < 0).any():
        raise ValueError(f"N: {points['N'].min():g} is below 0; direction -z pushes the other way")
    for device in nominal:
        idle = [key for key in points if key in OF_MASS and np.all(device.is_alone)]
        if idle:
            raise ValueError(f"{idle[0]}: needs a mass; leave it out")
    if len({device.gravity for device in nominal}) > 1:
        raise ValueError("devices: gravity differs; write one value, as N counts multiples of it")


def rows_of(grid: Grid) -> Rows:
    """Give all points but those along N, as rows; their device is -1 where there is none."""
    C, f0 = grid.axes["C"], grid.axes["f0"]
    device, pulse = grid.device_of, np.arange(len(grid.pulses))
    device, pulse = np.expand_dims(device, (-3, -2, -1)), np.expand_dims(pulse, (-2, -1))
    return to_rows(device, f0, C[:, np.newaxis], pulse, grid.pulses)


def _vary(devices, point):
    """Set the values of points of axes, (devices,); a ValueError names the first that cannot be."""
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


def point_text(point: Mapping[str, float | str]) -> str:
    """Write where a point is on its axes, with units, for messages."""
    return ", ".join(
        f"{key} = {value}"
        if key in NAMES
        else f"{key} = {value:.6g} {'g' if key == 'N' else QUANTITIES[key].unit}"
        for key, value in point.items()
    )


def axis_behind(name: str) -> str:
    """Give the axis of a study that a figure's axis shows."""
    return "f0" if name == DURATION else name


def shared_points(axes: Mapping[str, np.ndarray], others: Mapping) -> tuple[tuple, tuple]:
    """Find the values that two sets of axes share: indices into either, an array for each axis."""
    pairs = [
        np.intersect1d(axes[key], others[key], assume_unique=True, return_indices=True)[1:]
        for key in axes
    ]
    return tuple(zip(*pairs, strict=True))

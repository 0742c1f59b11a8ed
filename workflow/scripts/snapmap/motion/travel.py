"""A mass that travels further than a device has room for."""

import warnings

import numpy as np

from ..device import Device, Value

# ASSUME: a device leaves its mass a few times the rise of its beam, which a snap takes it twice.
FARTHEST = 5.0
"""Over the rise: of a mass that no stop holds, a way from rest that a run remarks upon."""


def warn_of_travel(device: Device, lowest: Value, highest: Value) -> None:
    """Warn, in one line, if a mass without a stop on that side goes beyond FARTHEST times the rise.

    device: one, or as many as there are runs; lowest, highest: of the mass from rest, um
    """
    toward = np.where(np.isinf(device.stop_toward), -np.asarray(lowest), 0.0)
    away = np.where(np.isinf(device.stop_away), highest, 0.0)
    way = np.fmax(toward, away)
    beyond = np.atleast_1d(way / device.beam.height > FARTHEST)
    if beyond.any():
        runs = f" in {beyond.sum()} of {beyond.size} runs" if beyond.size > 1 else ""
        warnings.warn(
            f"the mass travels up to {np.nanmax(way):.4g} um from rest{runs}, more than "
            f"{FARTHEST:g} times the rise; if it meets the frame before, write device.stops",
            stacklevel=3,
        )

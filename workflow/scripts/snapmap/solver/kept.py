"""What is made of a device is kept for the next calls with a device of the same values."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields
from typing import TypeVar

import numpy as np

from ..device.device import Device

Made = TypeVar("Made")
FEW, MOST = 16, 16
"""Most devices of a batch for which something is kept, and most things that are kept."""
_kept: dict[Hashable, object] = {}


def kept(
    make: Callable[[], Made], device: Device, model: Mapping, what: str, *others: Hashable
) -> Made:
    """Give what `make` makes, or what it made of the same device, model, `what` and others before.

    model: name and options; nothing is kept of a user's laws
    others: all else on which the result depends
    """
    if len(device) > FEW or "laws" in model:
        return make()
    key = _values(device), tuple(model.items()), what, others
    if key not in _kept:
        if len(_kept) >= MOST:
            del _kept[next(iter(_kept))]
        _kept[key] = make()
    return _kept[key]


def forget() -> None:
    """Keep nothing of what was made before."""
    _kept.clear()


def _values(device):
    """Give the values of a device or a batch, which has another shape, as a key."""
    parts = device.beam, device
    values = [getattr(part, field.name) for part in parts for field in fields(part)]
    numbers = (np.asarray(value, float) for value in values if value is not device.beam)
    return np.shape(device.mass), *(column.tobytes() for column in numbers)

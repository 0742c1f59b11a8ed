"""What is made of a device is kept for the next calls with a device of the same values."""

from collections.abc import Callable, Hashable
from dataclasses import fields
from typing import Any

import numpy as np

from ..device.device import Device
from .options import Chosen

FEW, MOST = 16, 16
"""Most devices of a batch for which something is kept, and most things that are kept."""
_kept: dict[Hashable, Any] = {}
forget = _kept.clear


def kept(make: Callable[[], Any], device: Device, chosen: Chosen, *others: Hashable) -> Any:
    """Give what `make` makes, or what it made for equal arguments before.

    Of laws nothing is kept. others: all else on which it depends
    """
    if len(device) > FEW or chosen.laws:
        return make()
    parts = device.beam, device
    values = [getattr(part, field.name) for part in parts for field in fields(part)]
    values = [np.asarray(value, float) for value in values if value is not device.beam]
    key = *((value.shape, value.tobytes()) for value in values), chosen, *others
    if key not in _kept:
        if len(_kept) >= MOST:
            del _kept[next(iter(_kept))]
        _kept[key] = make()
    return _kept[key]

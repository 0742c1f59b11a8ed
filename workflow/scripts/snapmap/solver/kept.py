"""What is made of a device is kept for the next calls with a device of the same values."""

from collections.abc import Callable, Hashable
from typing import Any

import numpy as np

from ..device.device import Device, values_of
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
    values = (np.asarray(value, float) for value in values_of(device).values())
    key = *((value.shape, value.tobytes()) for value in values), chosen, *others
    if key not in _kept:
        if len(_kept) >= MOST:
            del _kept[next(iter(_kept))]
        _kept[key] = make()
    return _kept[key]

"""A slab of the grid: the work of one job, named by what it holds."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from ..axes import DEVICE, DIRECTION, NAMES, SHAPE, Grid, make_grid
from ..device import Device
from ..pulse import HANDOUT_SHOCK, Shocks

SINGLE = (DEVICE, SHAPE, DIRECTION, "C")
"""Axes of which a slab has one value: what else it holds may be sought in slabs of the same."""
Slab = Mapping[str, tuple]
"""Values on each axis, in order and ascending: internal units, f0 in Hz; names on axes of NAMES."""


def slab_grid(
    device: Device | Mapping[str, Device],
    slab: Slab,
    skip: bool,
    shocks: Shocks = HANDOUT_SHOCK,
) -> Grid:
    """Set out the points of a slab; arguments as for `make_grid`."""
    if isinstance(device, Mapping):
        device = {name: device[name] for name in slab[DEVICE]}
    axes = {key: slab[key] for key in slab if key not in NAMES}
    return make_grid(device, axes, skip, shocks.some(slab))


def cells_in(slab: Slab) -> int:
    """Number of its cells."""
    return math.prod(len(values) for values in slab.values())


def slab_name(
    device: Device | Mapping[str, Device],
    model: Mapping,
    slab: Slab,
    settings: Mapping,
    shocks: Shocks = HANDOUT_SHOCK,
) -> str:
    """Name a slab by two hashes: what slabs that share cells have in common, and its other axes.

    settings: those on which a result depends
    """
    apart = {key: slab[key] for key in SINGLE if key in slab}
    nominal = [device[name] for name in slab[DEVICE]] if DEVICE in slab else [device]
    pushed = [hashlib.sha256(one.pieces.tobytes()).hexdigest() for one in shocks.some(slab).pulses]
    common = [[asdict(one) for one in nominal], model, settings, pushed, list(slab), apart]
    return f"{_hash(common)}_{_hash([slab[key] for key in slab if key not in SINGLE])}"


def _hash(what):
    plain = json.dumps(what, sort_keys=True, default=np.ndarray.tolist)
    return hashlib.sha256(plain.encode()).hexdigest()[:12]

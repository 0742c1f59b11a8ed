"""A slab of the grid: the work of one job, named by what it holds."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache

import numpy as np

from ..axes import DEVICE, DIRECTION, NAMES, SHAPE, Grid
from ..study import Study

SINGLE = (DEVICE, SHAPE, DIRECTION, "C")
"""Axes of which a slab has one value: what else it holds may be sought in slabs of the same."""
Slab = Mapping[str, tuple]
"""Values on each axis, in order and ascending: internal units, f0 in Hz; names on axes of NAMES."""


def slab_grid(study: Study, slab: Slab) -> Grid:
    """Set out the points of a slab of a study."""
    return study.part(slab).set_out({key: slab[key] for key in slab if key not in NAMES})


def cells_in(slab: Slab) -> int:
    """Number of its cells."""
    return math.prod(len(values) for values in slab.values())


def slab_name(study: Study, slab: Slab) -> str:
    """Name a slab by two hashes: what slabs that share cells have in common, and its other axes."""
    apart = {key: slab[key] for key in SINGLE if key in slab}
    part, settings = study.part(slab), study.settings.asked()
    nominal = [asdict(one) for one in part.devices().values()]
    pulses = [hashlib.sha256(one.pieces.tobytes()).hexdigest() for one in part.settings.pulses]
    common = [nominal, study.model, settings, pulses, list(slab), apart]
    plain = json.dumps(common, sort_keys=True, default=np.ndarray.tolist)
    others = ", ".join(_text(values) for key, values in slab.items() if key not in SINGLE)
    return f"{_hash(plain)}_{_hash(f'[{others}]')}"


@lru_cache  # N is that of many slabs
def _text(values):
    return json.dumps(values)


def _hash(plain):
    return hashlib.sha256(plain.encode()).hexdigest()[:12]

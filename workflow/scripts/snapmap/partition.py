"""A slab of the grid: the work of one job, named by what it holds."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, NamedTuple

from .device import Device
from .protocol import Protocol

if TYPE_CHECKING:  # a job has no use for the config and what it imports
    from .config import Study


class Slab(NamedTuple):
    """Values on the axes of one slab: C in uN us/um, f0 in Hz, N in multiples of g."""

    C: tuple[float, ...]
    f0: tuple[float, ...]
    N: tuple[float, ...]


def slab_name(study: "Study", slab: Slab) -> str:
    """Name a slab by two hashes: what its cells have in common but the code, and its f0 and N."""
    return name_of(study.device, study.model, slab, study.protocol)


def name_of(device: Device, model: Mapping, slab: Slab, protocol: Protocol) -> str:
    """The same, of the parts of a study."""
    common = [asdict(device), model, protocol._asdict(), slab.C]
    return f"{_hash(common)}_{_hash([slab.f0, slab.N])}"


def _hash(what):
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:12]

"""The section `tolerances`: what scatters, and how much."""

from collections.abc import Mapping
from typing import NamedTuple

from ..quantities import QUANTITIES
from ..tolerances.samples import SHOCK_FACTORS, Plan
from .units import read, show


class Tolerances(NamedTuple):
    """What a study asks of devices as made.

    scatters: by the names of values; numbers in internal units, or shares as text
    together: groups of values that one draw moves
    samples, index_samples, seed: as `tolerances.dataset.tolerance` takes them
    """

    scatters: dict
    together: list[list[str]]
    samples: int
    index_samples: int | None
    seed: int


OPTIONS = {"together": [], "samples": 1000, "index_samples": None, "seed": 1}


def read_tolerances(section: Mapping, devices) -> Tolerances:
    """Convert the section; ValueError names what cannot be.

    devices: all that are to scatter so
    """
    keys = [key for key in section if key not in OPTIONS]
    scatters = {key: _scatter(key, section[key]) for key in keys}
    found = Tolerances(scatters, **{key: section.get(key, OPTIONS[key]) for key in OPTIONS})
    for device in devices:
        Plan(device, scatters, found.together)
    if (found.index_samples or 0) > found.samples:
        need = f"is more than samples, {found.samples}"
        raise ValueError(f"tolerances.index_samples: {found.index_samples} {need}")
    return found


def _scatter(key, given):
    if isinstance(given, Mapping):
        return {name: _width(key, width) for name, width in given.items()}
    return _width(key, given)


def _width(key, text):
    try:
        if text.strip().endswith("%"):
            return f"{100 * read(text, 'share'):.12g} %"
        if key in SHOCK_FACTORS:
            raise ValueError(f"{show(text)} is no share; write one such as '5 %'")
        return read(text, QUANTITIES[key].kind)
    except ValueError as error:
        raise ValueError(f"tolerances.{key}: {error}") from None

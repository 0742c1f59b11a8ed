"""The section `tolerances`: what scatters, and how much."""

from collections.abc import Mapping

from ..quantities import QUANTITIES
from ..tolerances.samples import SHOCK_FACTORS, Plan, Tolerances
from .units import read, show


def read_tolerances(section: Mapping, devices) -> Tolerances:
    """Convert the section; ValueError names what cannot be.

    devices: all that are to scatter so
    """
    options = {key: section[key] for key in section if key in Tolerances._fields}
    scatters = {key: _scatter(key, section[key]) for key in section if key not in options}
    found = Tolerances(scatters, **options)
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
        if isinstance(text, str) and text.strip().endswith("%"):
            return f"{100 * read(text, 'share'):.12g} %"
        if key in SHOCK_FACTORS:
            raise ValueError(f"{show(text)} is no share; write one such as '5 %'")
        return read(text, QUANTITIES[key].kind)
    except ValueError as error:
        bare = isinstance(text, int | float) and key not in SHOCK_FACTORS
        share = f", or a share such as '{text} %'" if bare else ""
        raise ValueError(f"tolerances.{key}: {error}{share}") from None

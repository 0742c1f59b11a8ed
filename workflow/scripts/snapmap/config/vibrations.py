"""How beam and mass of a device vibrate, each by itself, in words."""

from collections.abc import Sequence

import numpy as np

from ..beam.modal import natural_frequency
from ..device.device import Device
from ..device.quantities import plain


def vibrations(device: Device, C: Sequence[float]) -> list[list[str]]:
    """Give name, frequency and quality factor of the beam, and of the mass if there is one.

    device: a single one; C: of the mass, uN us/um
    """
    omega, damping = float(natural_frequency(device.beam)), float(device.beam.damping)
    rows = [["beam", _frequency(omega), _quality(omega, damping)]]
    if not device.is_alone:
        omega, mass = float(device.mass_frequency), device.mass
        ends = dict.fromkeys((np.min(C), np.max(C)))
        rates = (f"{_quality(omega, end / mass)} at C = {plain(end)}" for end in ends)
        words = f"{' to '.join(rates)} uN*us/um (critical: {plain(2 * float(mass) * omega)})"
        rows.append(["mass", _frequency(omega), words])
    return rows


def _frequency(omega):
    return f"{plain(1e3 * omega / (2 * np.pi))} kHz"


def _quality(omega, rate):
    """Write the quality factor under a drag per mass of -rate v: omega/rate."""
    return f"{plain(omega / rate)}" if rate else "infinite"

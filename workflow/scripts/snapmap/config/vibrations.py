"""Frequencies and quality factors of beam and mass, each by itself, in words."""

from collections.abc import Sequence

import numpy as np

from ..beam.modal import natural_frequency
from ..device.device import Device
from ..files.text import plain


def vibrations(device: Device, C: Sequence[float] | None) -> list[list[str]]:
    """Give name, frequency and quality factor of the beam, and of the mass if the device has one.

    device: a single device; C: damping of the mass, uN us/um, None under a user's own laws
    """
    omega, damping = float(natural_frequency(device.beam)), float(device.beam.damping)
    rows = [["beam", _frequency(omega), _quality(omega, damping)]]
    if not device.is_alone:
        omega = float(device.mass_frequency)
        words = "not known under model.laws" if C is None else _damped(omega, float(device.mass), C)
        rows.append(["mass", _frequency(omega), words])
    return rows


def _damped(omega, mass, C):
    """Write the quality factor of the mass at the least and the largest C."""
    ends = dict.fromkeys((np.min(C), np.max(C)))
    rates = (f"{_quality(omega, end / mass)} at C = {plain(end)}" for end in ends)
    return f"{' to '.join(rates)} uN*us/um (critical: {plain(2 * mass * omega)})"


def _frequency(omega):
    return f"{plain(1e3 * omega / (2 * np.pi))} kHz"


def _quality(omega, rate):
    """Write the quality factor under a drag per mass of -rate v: omega/rate."""
    return f"{plain(omega / rate)}" if rate else "infinite"

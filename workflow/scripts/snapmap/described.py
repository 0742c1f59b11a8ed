"""How a device vibrates and a recorded shock excites it, in a line."""

from collections.abc import Sequence

import numpy as np

from .beam.modal import natural_frequency
from .device import Device
from .pulse import Pulse
from .quantities import plain
from .spectra.srs import pulse_response


def describe(device: Device, C: Sequence[float] = ()) -> str:
    """One line on how beam and mass vibrate, each by itself: frequencies and quality factors.

    device: a single one; C: of the mass, uN us/um, from 0

    >>> snapmap.describe(snapmap.load_device("config/damped.yaml"))
    'beam 157.8 kHz, quality factor 247.8; mass 3.733 kHz'
    """
    own = _own(device)
    beam, mass = (f"{plain(1e3 * omega / (2 * np.pi))} kHz" for omega in own)
    words = f"beam {beam}, quality factor {_quality(own[0], device.beam.damping)}; "
    words += "no mass" if device.is_alone else f"mass {mass}"
    if device.is_alone or not np.size(C):
        return words
    ends = dict.fromkeys((np.min(C), np.max(C)))
    rates = (f"{_quality(own[1], end / device.mass)} at C = {plain(end)}" for end in ends)
    critical = 2 * device.mass * own[1]
    return f"{words}, quality factor {' to '.join(rates)} uN*us/um (critical: {plain(critical)})"


def excited(device: Device, pulse: Pulse) -> str:
    """One line on the shock response spectrum of a pulse at the device's own frequencies."""
    own = _own(device)[: 1 if device.is_alone else 2]
    response = pulse_response(pulse, pulse.duration, np.array(own) / (2e-6 * np.pi))
    each = [
        f"{plain(a, 3)} at the {of}'s" for a, of in zip(response, ("beam", "mass"), strict=False)
    ]
    each[-1] += " frequency"
    return f"shock response (quality factor 10) over its peak {', '.join(each[::-1])}"


def _own(device):
    """Frequencies of beam and mass, rad/us."""
    return natural_frequency(device.beam), float(device.mass_frequency)


def _quality(omega, rate):
    """Of a swing whose drag per mass is -rate v: a radian takes rate/omega of its energy."""
    return f"{plain(omega / rate)}" if rate else "infinite"

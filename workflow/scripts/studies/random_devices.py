"""Devices and shocks drawn at random, over all that the model is meant for."""

import math

import numpy as np

from snapmap.device import Beam, Device

PULSES, DAMPINGS = 4, (0.01, 0.6)
"""Frequencies of each device, and its dampings over sqrt(K M)."""
FREQUENCIES = 0.05, 20.0
"""Over the device's own."""


def draw_device(draw: np.random.Generator) -> Device:
    """A silicon beam and a mass on a spring, light or heavy, soft or stiff; some contacts hard."""
    Q, span = draw.uniform(2.5, 8.0), _even(draw, 200.0, 2000.0)
    thickness = span / 300 * _even(draw, 0.3, 3.0)
    beam = Beam(
        span=span,
        rise=Q * thickness,
        thickness=thickness,
        depth=draw.uniform(5.0, 30.0),
        youngs_modulus=draw.uniform(1.0e5, 1.7e5),
        density=2.33e-3,
    )
    stiffness = 192 * beam.stiffness_unit
    contact = math.inf if draw.random() < 0.5 else stiffness * _even(draw, 0.1, 100.0)
    return Device(
        beam,
        mass=_even(draw, 1e2, 1e6),
        spring=stiffness * _even(draw, 0.02, 20.0),
        contact=contact,
        gravity=9.81e-6,
    )


def draw_shocks(draw: np.random.Generator, device: Device) -> tuple[list[float], list[float]]:
    """Frequencies (Hz) and dampings C (uN us/um)."""
    own = device.own_frequency / (2 * math.pi) * 1e6
    f0 = sorted(own * _even(draw, *FREQUENCIES) for _ in range(PULSES))
    critical = math.sqrt(device.spring * device.mass)
    return f0, [share * critical for share in DAMPINGS]


def _even(draw, low, high):
    """A number whose logarithm is evenly distributed."""
    return float(math.exp(draw.uniform(math.log(low), math.log(high))))

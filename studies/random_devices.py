"""Random devices and shocks, over the range of the model."""

import math
from dataclasses import replace

import numpy as np

from snapmap.device.device import Beam, Device
from snapmap.pulse.pulse import DIRECTIONS, SHAPES, make_pulse, sampled
from snapmap.pulse.shocks import Shocks

PULSES, DAMPINGS = 4, (0.01, 0.6)
"""Number of pulses of each device, and its dampings over sqrt(K M)."""
FREQUENCIES, SLOWEST = (0.05, 20.0), 0.01
"""Range of f0 over the device's own frequency, and its lower end with slow pulses."""
ARC = {f"cosine_{n}": 8 / (n * math.pi) ** 2 for n in range(2, 6)}
"""Cosines of a beam made as a shallow arc."""


def draw_device(draw: np.random.Generator) -> Device:
    """Draw a silicon beam with a mass on a spring; half of the contacts are hard."""
    Q, span = draw.uniform(2.5, 8.0), even(draw, 200.0, 2000.0)
    thickness = span / 300 * even(draw, 0.3, 3.0)
    depth, E = draw.uniform(5.0, 30.0), draw.uniform(1.0e5, 1.7e5)
    beam = Beam(span, Q * thickness, thickness, depth, youngs_modulus=E, density=2.33e-3)
    stiffness = 192 * beam.stiffness_unit
    contact = math.inf if draw.random() < 0.5 else stiffness * even(draw, 0.1, 100.0)
    mass, spring = even(draw, 1e2, 1e6), stiffness * even(draw, 0.02, 20.0)
    return Device(beam, mass=mass, spring=spring, contact=contact, gravity=9.81e-6)


def draw_any_device(draw: np.random.Generator) -> Device:
    """Draw a device as `draw_device`; some have a stress or a gap, or are free to tilt."""
    device = draw_device(draw)
    beam = device.beam
    if draw.random() < 0.5:
        # Up to half of the tension that leaves no second shape, or as much compression.
        beam = replace(beam, residual_stress=draw.uniform(-0.5, 0.5) * beam.most_stress)
    if draw.random() < 0.25:
        beam = replace(beam, free=1.0, imperfection=beam.thickness * even(draw, 0.01, 1.0))
    gap = beam.rise * even(draw, 0.03, 3.0) if draw.random() < 0.5 else 0.0
    return replace(device, beam=beam, gap=gap)


def draw_widest_device(draw: np.random.Generator) -> Device:
    """Draw a device as `draw_any_device`; some have stops, another shape or temperature."""
    device = draw_any_device(draw)
    if draw.random() < 0.3:
        way = device.gap + device.beam.rise * even(draw, 0.3, 3.0)
        device = replace(device, stop_toward=way, restitution=draw.uniform(0.0, 0.9))
    if draw.random() < 0.3:
        device = replace(device, stop_away=device.beam.rise * even(draw, 0.1, 3.0))
    beam = device.beam
    if draw.random() < 2 / 3:
        # Without compression it has no second shape.
        beam = replace(beam, **ARC)
        beam = replace(beam, residual_stress=draw.uniform(1.1, 2.0) * beam.most_stress)
    there, mismatch = draw.uniform(-40.0, 120.0), draw.uniform(0.0, 2e-6)
    device = replace(device, beam=beam, modulus_slope=-6e-5, expansion_mismatch=mismatch)
    warm = device.warmed({"temperature": there})
    try:
        beam = replace(beam, **{key: warm[key] for key in ("youngs_modulus", "residual_stress")})
        beam.require_second_shape()
    except ValueError:
        return device  # without a second shape at that temperature
    return replace(device, beam=beam, temperature=there)


def draw_pulse(draw: np.random.Generator) -> Shocks:
    """Draw a pulse in either direction: a shape, or a record with ringing and noise."""
    name = draw.choice([*SHAPES, "recorded"])
    x = np.linspace(0.0, 1.0, 201)
    rings = np.sin(np.pi * x) ** 2 * (1 + draw.normal(0.0, 0.3) * np.sin(14 * np.pi * x))
    noise = 0.02 * draw.normal(size=x.size) * np.sin(np.pi * x)
    pulse = sampled(x, rings + noise) if name == "recorded" else make_pulse(str(name))
    return Shocks(pulse, str(draw.choice([*DIRECTIONS])))


def draw_shocks(
    draw: np.random.Generator, device: Device, frequencies: tuple[float, float] = FREQUENCIES
) -> tuple[list[float], list[float]]:
    """Draw frequencies f0 (Hz), and return them with dampings C (uN us/um).

    frequencies: their range over the device's own frequency
    """
    natural = device.own_frequency / (2 * math.pi) * 1e6
    f0 = sorted(natural * even(draw, *frequencies) for _ in range(PULSES))
    critical = math.sqrt(device.spring * device.mass)
    return f0, [share * critical for share in DAMPINGS]


def even(draw, low, high):
    """Draw a number with a uniformly distributed logarithm."""
    return float(math.exp(draw.uniform(math.log(low), math.log(high))))

"""Slow pulses: how long the mass's acceleration may stay above the static threshold."""

import math
from dataclasses import replace

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device.device import Device
from ..pulse.pulse import Pulse
from ..values.kinds import Number

HEAVY = 30.0
"""Least mass, in masses of the beam, with which the beam's own inertia does not round the corner of
the path."""
HOLDS = 0.01
"""Relative distance from the threshold up to which a law holds."""
POINTS = 4096
"""Number of steps into which a pulse is cut."""
FEW = 12
"""Most rows that are followed one by one, in numbers, as short arrays would take longer."""


def growth_rate(device: Device, C: Number) -> Number:
    """Give the rate sigma, 1/us, at which the mass departs along the falling branch of the path.

    C: uN us/um; the dwell is 2/sigma
    It is NaN where the path has no corner from which it falls: the spring is stiffer than the
    falling beam or the contact softer, the mass is light or apart at rest, a stop is in the way, or
    the beam is free to tilt or made with a second cosine.
    """
    beam, damping = device.beam, C * device.damper_factor
    falls = 64 * math.pi * math.pi * beam.stiffness_unit
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = 1 / (1 / falls - 1 / np.asarray(device.contact, float)) - device.spring
        root = np.sqrt(damping * damping + 4 * device.mass * kappa)
        rate = 2 * kappa / (damping + root)
    has_corner = (kappa > 0) & (device.mass >= HEAVY * beam.weight) & np.equal(device.gap, 0)
    has_corner &= np.equal(beam.free, 0) & np.equal(beam.cosine_2, 0)
    if np.any(np.isfinite(device.stop_toward)):
        clear = replace(device, stop_toward=np.inf * np.asarray(device.stop_toward))
        has_corner &= static_threshold(clear) == static_threshold(device)
    return np.where(has_corner, rate, np.nan)[()]


def slow_factor(pulse: Pulse, swings: np.ndarray) -> np.ndarray:
    """Give the threshold of a slow pulse over the static one, (rows,): 1 over the peak of I.

    swings: sigma over f0, (rows,)
    I = sigma int_0^inf exp(-sigma u) p(t + u) du is the lasting part of a pulse p, followed from
    its end by I' = sigma (I - p). The factor is NaN if a pulse jumps, or never presses.
    """
    if any(pulse.ends) or pulse.highest == 0:
        return np.full(swings.shape, np.nan)
    p = pulse.at(np.arange(POINTS + 1) / POINTS)
    double_means, half = (p[:-1] + p[1:])[::-1].tolist(), swings / (2 * POINTS)
    if swings.size > FEW:
        return 1 / _peak(half, double_means, np.fmax)
    return 1 / np.array([_peak(each, double_means, max) for each in half.tolist()])


def _peak(half, double_means, larger):
    """Return the peak of I, of numbers or (rows,); half: half of sigma times a step."""
    lasting = peak = 0.0 * half
    less, more = 1 - half, 1 + half
    for double_mean in double_means:
        lasting = (lasting * less + half * double_mean) / more
        peak = larger(peak, lasting)
    return peak

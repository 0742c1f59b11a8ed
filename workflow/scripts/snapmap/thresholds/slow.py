"""Slow pulses: how long the mass's acceleration may stay above the static threshold."""

import math
from dataclasses import replace

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device.device import Beam, Device
from ..device.shape import midpoint
from ..pulse.pulse import Pulse
from ..values.kinds import Number

HEAVY, SLENDER, FIRM = 100.0, 4.0, 3.0
"""Least mass over that of the beam, rise over thickness, and stiffness of the contact over that of
the falling beam. Below, the beam's inertia rounds the corner of the path, the mass swings as it
gets there, or the contact softens the fall."""
FALLS = 0.1, 0.5
"""Least and largest `fall`. Below, the mass gets past it before the law says; above, a soft spring
lets it swing."""
PART = 0.2
"""Share of the fall that a shock may use; docs/applications/laws.md has the errors within."""
GROWTH = np.array([-1 / 3, 0.0, 9 / 5, 0.0, 25 / 21])
"""Growth n^2/(n^2 - 4) of the odd cosines of the shape as made under the second buckling load, at
which the saddle is."""
HOLDS = 0.01
"""Relative distance from the threshold up to which a law holds."""
POINTS = 4096
"""Number of steps into which a pulse is cut."""
FEW = 12
"""Most rows that are followed one by one, in numbers, as short arrays would take longer."""


def falling_stiffness(beam: Beam) -> Number:
    """Give how steeply the force of a beam falls beyond the corner of its path, uN/um."""
    return 64 * math.pi * math.pi * beam.stiffness_unit


def fall(device: Device, static: Number) -> Number:
    """Give the share by which the acceleration that holds the mass falls from corner to saddle.

    static: static threshold of the device, multiples of g
    """
    beam = device.beam
    way = beam.height - beam.made_rise * midpoint(beam.cosines, GROWTH)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1 - device.spring * way / (device.mass * device.gravity * static)


def obstacles(device: Device, static: Number) -> dict[str, np.ndarray]:
    """Say why the law of slow shocks does not hold for a device: reasons, and where each is true.

    static: as in `fall`
    """
    beam, (least, most) = device.beam, FALLS
    falls, contact = falling_stiffness(beam), np.asarray(device.contact, float)
    reasons = {}
    if np.any(np.isfinite(device.stop_toward)):
        clear = replace(device, stop_toward=np.inf * np.asarray(device.stop_toward))
        reasons["a stop is in the way"] = static_threshold(clear) != static
    share = fall(device, static)
    return reasons | {
        "the beam is free to tilt": np.not_equal(beam.free, 0),
        "the beam as made has a second cosine": np.not_equal(beam.cosine_2, 0),
        "no mass rests on the beam": np.not_equal(device.gap, 0),
        f"the mass is below {HEAVY:g} beams": np.less(device.mass, HEAVY * beam.weight),
        f"rise/thickness is below {SLENDER:g}": np.less(beam.bistability, SLENDER),
        f"the contact is below {FIRM:g} times as stiff as the falling beam": contact < FIRM * falls,
        "the spring is nearly as stiff as the falling beam": ~np.greater_equal(share, least),
        "the spring is soft beside the falling beam": np.greater(share, most),
    }


def first_obstacle(device: Device, static: float) -> str:
    """Say in words why the law of slow shocks does not hold for one device; empty if it does."""
    reasons = obstacles(device, static)
    return next((reason for reason, is_so in reasons.items() if np.all(is_so)), "")


def departure_rate(device: Device, C: Number) -> Number:
    """Give the rate sigma, 1/us, at which the mass departs along the falling branch of the path.

    C: uN us/um; NaN for a spring that is stiffer than the falling beam
    """
    damping, falls = C * device.damper_factor, falling_stiffness(device.beam)
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = 1 / (1 / falls - 1 / np.asarray(device.contact, float)) - device.spring
        root = np.sqrt(damping * damping + 4 * device.mass * kappa)
        return 2 * kappa / (damping + root)


def growth_rate(device: Device, C: Number, static: Number) -> Number:
    """Give `departure_rate`, NaN where one of `obstacles` is; the dwell is 2 over it."""
    holds = ~np.logical_or.reduce([*obstacles(device, static).values()])
    return np.where(holds, departure_rate(device, C), np.nan)[()]


def slow_up_to(device: Device, static: Number) -> Number:
    """Give the threshold, multiples of g, up to which a shock is slow; static: as in `fall`."""
    return static * (1 + PART * fall(device, static))


def is_slow(pulse: Pulse, swings: np.ndarray, fall: np.ndarray) -> np.ndarray:
    """Return whether a pulse is slow enough for the law, by its steepest slope, (rows,).

    swings: sigma over f0; fall: as `fall` gives it; both (rows,)
    """
    steep = math.pi * pulse.steepest / swings
    return steep * steep <= PART * fall


def slow_factor(pulse: Pulse, swings: np.ndarray) -> np.ndarray:
    """Give the threshold of a slow pulse over the static one, (rows,): 1 over the peak of I.

    swings: sigma over f0, (rows,); it holds where `is_slow`
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

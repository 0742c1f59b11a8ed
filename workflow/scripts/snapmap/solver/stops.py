"""Stops of the mass in the plain loop: it bounces, or rests there."""

import numpy as np

from ..numerics.kernels import inlined
from .nodal import System


@inlined
def meet_stops(
    system: System, at: tuple[float, float], y_before: float, y: float, dt: float
) -> tuple[float, float, float, float]:
    """Correct y of the last two instants, if the mass is beyond a stop, as if it had bounced.

    at: as for `potential`, half a step back
    Returns both, the work of the pulse between the old and the new place, and the loss, pJ.
    """
    pushed, taken = 0.0, 0.0
    for side, travel in ((-1.0, system.stop_toward), (1.0, system.stop_away)):
        middle, velocity = (y_before + y) / 2, (y - y_before) / dt
        if side * y > travel and side * velocity > 0:
            place, turned = reflect(system, side * travel, at, middle, velocity)
            falls = potential(system, at, middle) - potential(system, at, place)
            pushed += system.mass * at[1] * (middle - place)
            taken += max(0.0, system.mass * (velocity**2 - turned**2) / 2 + falls)
            y_before, y = place - turned * dt / 2, place + turned * dt / 2
    return y_before, y, pushed, taken


@inlined
def reflect(
    system: System, stop: float, at: tuple[float, float], middle: float, velocity: float
) -> tuple[float, float]:
    """Return the place and velocity, after its reflection, of a mass that has passed a stop.

    middle, velocity: half a step back, before the stop; at: as for `potential`, then
    """
    at_stop, e = potential(system, at, stop), system.restitution
    falls = 2 * (potential(system, at, middle) - at_stop) / system.mass
    if velocity**2 + falls <= 0 and (middle - stop) * velocity < 0:
        return middle, velocity  # the mass turns before the stop
    left = e**2 * max(0.0, velocity**2 + falls)
    place = stop - e * (middle - stop)
    climbs = 2 * (potential(system, at, place) - at_stop) / system.mass
    if left < climbs:
        place, left, climbs = stop, 0.0, 0.0
    return place, -np.copysign(np.sqrt(left - climbs), velocity)


@inlined
def potential(system: System, at: tuple[float, float], z: float) -> float:
    """Return the energy of the mass at z, pJ; at: w(L/2), whose contact counts, and the field a."""
    w_mid, a = at
    overlap = max(0.0, w_mid - z - system.gap)
    return system.spring * z**2 / 2 + system.penalty * overlap**2 / 2 + system.mass * a * z


@inlined
def is_held(system: System, y_before: float, y: float, force: float) -> bool:
    """Tell whether a mass that rests on a stop is pressed there, by its force without damping."""
    rests = y == y_before and (y == -system.stop_toward or y == system.stop_away)
    return rests and force * y >= 0.0

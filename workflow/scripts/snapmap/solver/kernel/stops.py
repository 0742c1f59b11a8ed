"""Stops of the mass, met within a step: docs/theory.md, "Stops"."""

import numpy as np

from ...numerics.kernels import compiled, inlined
from . import rows as R
from .rows import LANES, numbers


@compiled
def has_stops(work):
    """Whether the mass of any lane has one; an empty lane has zeros there."""
    X, any_lane = numbers(work), False
    for l in range(LANES):
        any_lane |= 0.0 < X[R.STOP_TOWARD, l] < np.inf
        any_lane |= 0.0 < X[R.STOP_AWAY, l] < np.inf
    return any_lane


@compiled
def crossed(work):
    """Whether the mass of any lane is beyond a stop."""
    X, any_lane = numbers(work), False
    for l in range(LANES):
        any_lane |= (X[R.Y, l] < -X[R.STOP_TOWARD, l]) | (X[R.Y, l] > X[R.STOP_AWAY, l])
    return any_lane


@compiled
def meet_stops(work):
    """Reflect every mass that is beyond a stop and moves on; (m, d) at the last half step.

    It stays within its energy there: v^2 = d^2 + 2 (U(m) - U(s)) dt^2/M is its speed at the stop s,
    e v that with which it leaves, and m' = s - e (m - s) where it then is.
    """
    X = numbers(work)
    for l in range(LANES):
        if X[R.Y, l] < -X[R.STOP_TOWARD, l] and X[R.DY, l] < 0.0:
            strike(X, l, -X[R.STOP_TOWARD, l])
        if X[R.Y, l] > X[R.STOP_AWAY, l] and X[R.DY, l] > 0.0:
            strike(X, l, X[R.STOP_AWAY, l])


@compiled
def rebound(work):
    """Reflect the masses that have crossed a stop, as the next step else begins with."""
    if has_stops(work) and crossed(work):
        meet_stops(work)


@inlined
def strike(X, l, stop):
    """Reflect the mass of lane l, with an account of its energy."""
    d, mass, e = X[R.DY, l], X[R.M, l], X[R.RESTITUTION, l]
    middle, weight = X[R.Y, l] - d / 2, mass * X[R.A, l]
    squared = d * d - 2 * (stored(X, l, middle, stop) + weight * (stop - middle)) / mass
    if squared <= 0.0 and (middle - stop) * d < 0.0:
        return  # it turns before the stop, and is beyond it by an error of the step
    left = e * e * max(squared, 0.0)
    place = stop - e * (middle - stop)
    away = left - 2 * (stored(X, l, stop, place) + weight * (place - stop)) / mass
    if away < 0.0:
        place, away = stop, left
    turned = -np.copysign(np.sqrt(away), d)
    work = weight * (middle - place)
    taken = mass * (d * d - away) / 2 - stored(X, l, middle, place) + work
    X[R.LOST, l] += taken
    X[R.WORK, l] += 2 * work
    X[R.GROSS_WORK, l] += abs(2 * work)
    X[R.OVERLAP, l] -= place - middle
    X[R.Y, l], X[R.DY, l] = place + turned / 2, turned


@inlined
def stored(X, l, begin, end):
    """What spring and contact take up as the mass goes from `begin` to `end` in a half step."""
    middle = X[R.Y, l] - X[R.DY, l] / 2
    before = max(0.0, X[R.OVERLAP, l] - (begin - middle))
    after = max(0.0, X[R.OVERLAP, l] - (end - middle))
    contact = X[R.CONTACT, l] * (after - before) * (after + before) / 2
    return X[R.K, l] * (end - begin) * (begin + end) / 2 + contact

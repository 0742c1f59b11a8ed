"""Stops of the mass, met within a step: docs/theory.md, "Stops"."""

import numpy as np

from ...numerics.kept_kernels import compiled, inlined
from . import rows as R
from .rows import LANES, row


@compiled
def has_stops(X):
    """Whether the mass of any lane has one; an empty lane has zeros there."""
    some = False
    for l in range(LANES):
        some |= 0.0 < X[row(R.STOP_TOWARD, l)] < np.inf
        some |= 0.0 < X[row(R.STOP_AWAY, l)] < np.inf
    return some


@inlined
def is_beyond(X, l):
    """Whether the mass of lane l is beyond a stop."""
    y = X[row(R.Y, l)]
    return (y < -X[row(R.STOP_TOWARD, l)]) | (y > X[row(R.STOP_AWAY, l)])


@compiled
def crossed(X):
    """Whether the mass of any lane is."""
    some = False
    for l in range(LANES):
        some |= is_beyond(X, l)
    return some


@compiled
def meet_stops(X):
    """Reflect every mass that is beyond a stop and moves on; (m, d) at the last half step.

    It stays within its energy there: v^2 = d^2 + 2 (U(m) - U(s)) dt^2/M is its speed at the stop s,
    e v that with which it leaves, and m' = s - e (m - s) where it then is.
    """
    for l in range(LANES):
        if X[row(R.Y, l)] < -X[row(R.STOP_TOWARD, l)] and X[row(R.Y_STEP, l)] < 0.0:
            strike(X, l, -X[row(R.STOP_TOWARD, l)])
        if X[row(R.Y, l)] > X[row(R.STOP_AWAY, l)] and X[row(R.Y_STEP, l)] > 0.0:
            strike(X, l, X[row(R.STOP_AWAY, l)])


@compiled
def rebound(X):
    """Reflect the masses that have crossed a stop, as the next step else begins with."""
    if has_stops(X) and crossed(X):
        meet_stops(X)


@inlined
def strike(X, l, stop):
    """Reflect the mass of lane l, with an account of its energy."""
    d, mass, e = X[row(R.Y_STEP, l)], X[row(R.MASS, l)], X[row(R.RESTITUTION, l)]
    middle, weight = X[row(R.Y, l)] - d / 2, mass * X[row(R.SHOCK, l)]
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
    X[row(R.LOST, l)] += taken
    X[row(R.WORK, l)] += 2 * work
    X[row(R.GROSS_WORK, l)] += abs(2 * work)
    X[row(R.OVERLAP, l)] -= place - middle
    X[row(R.Y, l)], X[row(R.Y_STEP, l)] = place + turned / 2, turned


@inlined
def stored(X, l, begin, end):
    """What spring and contact take up as the mass goes from `begin` to `end` in a half step."""
    middle, way = X[row(R.Y, l)] - X[row(R.Y_STEP, l)] / 2, end - begin
    before = max(0.0, X[row(R.OVERLAP, l)] - (begin - middle))
    after = max(0.0, X[row(R.OVERLAP, l)] - (end - middle))
    contact = X[row(R.CONTACT, l)] * (after - before) * (after + before) / 2
    return X[row(R.SPRING, l)] * way * (begin + end) / 2 + contact

"""Trains of blows, and drops with rebound: pulses of several parts and of known duration."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, replace
from typing import Annotated, NamedTuple

import numpy as np

from ..files.text import show
from ..values.faults import at_key
from ..values.kinds import Fitting, Whole
from ..values.quantities import Height, PulseTime, single
from ..values.records import build, record, told
from .pulse import Form, G, Pulse, ShapeName

# ASSUME: a blow that ends with a jump returns to 0 along a line, in this share of its duration.
JOIN = 0.01
# ASSUME: rebounds below this share of the first impact's velocity are left out.
LEAST_REBOUND = 0.05
MOST_BLOWS = 100_000


_NUMBER = single("a plain number", "", "2", "(-inf, inf)")


def _peak(value):
    number = _NUMBER.take(value)
    if number == 0:
        raise ValueError("0 is no blow; write a number above or below 0, or a wait")
    return number


Peak = Annotated[float, Fitting("a plain number", by=_peak, json={"type": "number"})]
Times = Annotated[int, Whole(1)]
Rebound = Annotated[float, single("a plain number", "", "0.3", "[0, 0.99]")]


@record
class Blow(Form):
    """A blow {shape, N, duration, rise, fall}, {wait: a time}, or {repeat: a number}."""

    shape: ShapeName | None = None
    """how the acceleration goes over time; a versed sine, or for a requirement as in `pulse`, if
    left out"""
    _: KW_ONLY
    N: Peak = 1.0
    """peak relative to other blows, below 0 for the other direction"""
    duration: PulseTime | None = None
    """duration of the blow; required, except with `wait` or `repeat`"""
    wait: PulseTime | None = None
    """time without a blow; alone in its item"""
    repeat: Times | None = None
    """how often the items before it occur in total; alone in its item"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find keys that exclude each other, or a duration that is missing."""
        for key in ("wait", "repeat"):
            if key in written and len(written) > 1:
                return {key: "stands alone in its item; write the others in an item of their own"}
        if not written.keys() & {"duration", "wait", "repeat"}:
            return {"duration": "missing; write a duration above 0"}
        return {}


@record
class Drop(Form):
    """A free fall, its blow, and the rebounds."""

    shape: ShapeName | None = None
    """how the acceleration of a blow goes over time; a versed sine, or for a requirement as in
    `pulse`, if left out"""
    _: KW_ONLY
    height: Height
    """height of the free fall"""
    duration: PulseTime
    """duration of each blow"""
    rebound: Rebound = 0.0
    """velocity after a blow over that before"""


class Part(NamedTuple):
    """A blow, or the wait or flight between two; its values are in units of N = 1.

    pieces: as in `numerics.pieces`, over time from the part's begin, us
    lasts: us; area: integral over time, us
    peak: 0 for a part that is no blow
    swing: duration of the fastest change, us
    """

    pieces: np.ndarray
    lasts: float
    peak: float = 0.0
    area: float = 0.0
    swing: float = math.inf


def make_train(items: Sequence[Blow | Mapping]) -> Pulse:
    """Make a pulse of blows; its peak is that of the blow with the largest one.

    Raises ValueError, one line, for other items or too many.
    """
    if isinstance(items, str | Mapping) or not isinstance(items, Sequence):
        raise ValueError(f".train: {show(items)} is not a list of blows, waits and repeats")
    parts, section = [], []
    for place, item in enumerate(items):
        with at_key("train", place):
            item = build(Blow, item)
        section.append(told(item))
        if item.repeat is None:
            parts.append(_blow(item, item.N) if item.wait is None else _flat(item.wait, 0.0))
        elif len(parts) * item.repeat > MOST_BLOWS:
            more = f"makes over {MOST_BLOWS} blows and waits; write fewer"
            raise ValueError(f".train[{place}].repeat: {more}")
        else:
            parts *= item.repeat
    return _joined("train", parts, section)


def make_drop(drop: Drop | Mapping) -> Pulse:
    """Make a pulse of a free fall from rest, a blow, and the flights and blows of its rebounds.

    A blow at velocity v changes it by (1 + rebound) v, from which its peak follows.
    Raises ValueError, one line, for another mapping or a blow below 1 g.
    """
    with at_key("drop"):
        drop = build(Drop, drop)
    rebound, velocity = drop.rebound, math.sqrt(2 * G * drop.height)
    peak = (1 + rebound) * velocity / _blow(drop).area
    if peak < G:
        line = f".drop: its blow has only {peak / G:.2g} g"
        raise ValueError(f"{line}; write a shorter duration")
    # In free fall the frame accelerates by -g; the jump at its end is small beside the blow.
    lasts, level, share = velocity / G, -G / peak, 1.0
    parts = [_flat(lasts, level), _blow(drop)]
    while (share := share * rebound) >= LEAST_REBOUND:
        parts += [_flat(2 * share * velocity / G, level), _blow(drop, share)]
    return replace(_joined("drop", parts, told(drop)), peak=peak)


def _blow(form, N=1.0):
    """Make a blow; if its shape ends with a jump, a line brings it back to 0."""
    pulse, duration = form.make(), form.duration
    pieces = pulse.pieces * [duration, N, N / duration, 1 / duration, N, N]
    area, jump, join = N * pulse.area * duration, N * pulse.ends[1], JOIN * duration
    if not jump:
        return Part(pieces, duration, abs(N), area, duration)
    pieces = np.vstack([pieces, [duration, jump, -jump / join, 0.0, 0.0, 0.0]])
    # Time steps as long as the line would miss a part of its area.
    return Part(pieces, duration + join, abs(N), area + jump * join / 2, 10 * join)


def _flat(lasts, value):
    """Make a part of constant value, in units of N = 1, that lasts so many us."""
    return Part(np.array([[0.0, value, 0.0, 0.0, 0.0, 0.0]]), lasts)


def _joined(name, parts, section):
    """Make a pulse of consecutive parts; its peak is their largest."""
    begins = np.cumsum([0.0, *(part.lasts for part in parts)])
    blows = np.array([part.peak > 0 for part in parts], bool)
    if not blows.any():
        raise ValueError(f".{name}: has no blow; write one such as {{duration: 0.5 ms}}")
    lasts, peak = float(begins[-1]), max(part.peak for part in parts)
    pieces = np.vstack([part.pieces for part in parts])
    pieces[:, 0] += np.repeat(begins[:-1], [len(part.pieces) for part in parts])
    best = max(parts, key=lambda part: abs(part.area))
    alone = _scaled(best.pieces, best.lasts, peak)
    return Pulse(
        name,
        _scaled(pieces, lasts, peak),
        lasts,
        section={name: section},
        blows=begins[:-1][blows] / lasts,
        swing=min(part.swing for part in parts) / lasts,
        strongest=Pulse("blow", alone, best.lasts, swing=best.swing / best.lasts),
    )


def _scaled(pieces, lasts, peak):
    """Scale pieces over time, us, to pieces of a pulse, over x from 0 to 1 and with peak 1."""
    scaled = pieces * [1.0, 1 / peak, lasts / peak, lasts, 1 / peak, 1 / peak]
    scaled[:, 0] /= lasts
    return scaled

"""Trains of blows, and drops with rebound: pulses of several parts and of known duration."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .options import take_pulse
from .pulse import SHARES, VERSED_SINE, G, Pulse, make_pulse

# ASSUME: a blow that ends with a jump returns to 0 along a line, in this share of its duration.
JOIN = 0.01
# ASSUME: rebounds below this share of the first impact's velocity are left out.
LEAST_REBOUND = 0.05
MOST_BLOWS = 100_000


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


def make_train(items: Sequence[Mapping]) -> Pulse:
    """Make a pulse of blows; its peak is that of the blow with the largest one.

    items: blows {shape, N, duration (us), rise, fall}, whose peaks are in the ratio of N, negative
        for the other direction; {wait: us}; {repeat: how often all before it comes, in total}
    Raises ValueError, one line, for other items or too many.
    """
    if isinstance(items, str | Mapping) or not isinstance(items, Sequence):
        raise ValueError("pulse.train: is not a list of blows, waits and repeats")
    parts, section = [], []
    for place, item in enumerate(items):
        path, keys = f"pulse.train[{place}]", [*item] if isinstance(item, Mapping) else []
        if keys in (["wait"], ["repeat"]):
            item = take_pulse(path, item, keys)
        else:
            item = take_pulse(path, item, ("duration",), ("shape", "N", *SHARES))
        section.append(item)
        if "repeat" not in item:
            parts.append(_flat(item["wait"], 0.0) if "wait" in item else _blow(**item))
        elif len(parts) * item["repeat"] > MOST_BLOWS:
            raise ValueError(f"{path}.repeat: makes over {MOST_BLOWS} blows and waits; write fewer")
        else:
            parts *= item["repeat"]
    return _joined("train", parts, section)


def make_drop(drop: Mapping) -> Pulse:
    """Make a pulse of a free fall from rest, a blow, and the flights and blows of its rebounds.

    drop: height (um); duration (us), shape, rise and fall of each blow; rebound: velocity after
        over that before a blow, from 0 to 0.99, by default 0
    A blow at velocity v changes it by (1 + rebound) v, from which its peak follows.
    Raises ValueError, one line, for another mapping or a blow below 1 g.
    """
    drop = take_pulse("pulse.drop", drop, ("height", "duration"), ("rebound", "shape", *SHARES))
    rebound, velocity = drop.get("rebound", 0.0), math.sqrt(2 * G * drop["height"])
    blow = {key: drop[key] for key in drop if key not in ("height", "rebound")}
    peak = (1 + rebound) * velocity / _blow(**blow).area
    if peak < G:
        line = f"pulse.drop: its blow has only {peak / G:.2g} g"
        raise ValueError(f"{line}; write a shorter duration")
    # In free fall the frame accelerates by -g; the jump at its end is small beside the blow.
    lasts, level, share = velocity / G, -G / peak, 1.0
    parts = [_flat(lasts, level), _blow(**blow)]
    while (share := share * rebound) >= LEAST_REBOUND:
        parts += [_flat(2 * share * velocity / G, level), _blow(**blow, N=share)]
    return replace(_joined("drop", parts, drop), peak=peak)


def _blow(duration, shape=VERSED_SINE, N=1.0, **shares):
    """Make a blow; if its shape ends with a jump, a line brings it back to 0."""
    pulse = make_pulse(shape, **shares)
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
        raise ValueError(f"pulse.{name}: has no blow; write one such as {{duration: 0.5 ms}}")
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

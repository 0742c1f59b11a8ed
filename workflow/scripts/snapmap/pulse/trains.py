"""Trains of blows, drops with rebound: pulses made of several, of a duration of their own."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from .options import take_pulse
from .pulse import SHARES, VERSED_SINE, Pulse, make_pulse

# ASSUME: a blow that ends with a jump falls to rest within this share of its duration, straight.
JOIN = 0.01
GRAVITY = 9.80665e-6
"""Of a free fall, um/us^2."""
# ASSUME: a rebound below this share of the first impact's velocity is none.
LEAST_REBOUND = 0.05
MOST_BLOWS = 100_000


class Part(NamedTuple):
    """A blow, or the wait or flight between two.

    pieces: as in `numerics.pieces`, over us from its begin; lasts: us
    peak: 0 where it is no blow; area: integral over us, in units of N = 1
    swing: duration of its fastest change, us
    """

    pieces: np.ndarray
    lasts: float
    peak: float = 0.0
    area: float = 0.0
    swing: float = math.inf


def make_train(items: Sequence[Mapping]) -> Pulse:
    """Make a pulse of blows; its peak is that of its strongest.

    items: each a blow {shape, N, duration (us), rise, fall}, N being its peak over those of others,
        below 0 the other way; {wait: us}; or {repeat: how often all before it comes in all}
    Raises ValueError, one line.
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
    """Make a pulse of a free fall from rest, its blow, and every flight and blow of the rebound.

    drop: height (um), duration (us) and shape of each blow, rise, fall; rebound: velocity after
        over before a blow, from 0 to 0.99, 0 if left out
    The blow of a fall to v changes the velocity by (1 + rebound) v; the pulse's own_N follows.
    Raises ValueError, one line.
    """
    drop = take_pulse("pulse.drop", drop, ("height", "duration"), ("rebound", "shape", *SHARES))
    rebound, velocity = drop.get("rebound", 0.0), math.sqrt(2 * GRAVITY * drop["height"])
    blow = {key: drop[key] for key in drop if key not in ("height", "rebound")}
    own_N = (1 + rebound) * velocity / (GRAVITY * _blow(**blow).area)
    if own_N < 1:
        raise ValueError(f"pulse.drop: its blow has only {own_N:.2g} g; write a shorter duration")
    # Free fall over the peak; where it ends with a jump, that is small beside the blow's.
    lasts, level, share = velocity / GRAVITY, -1 / own_N, 1.0
    parts = [_flat(lasts, level), _blow(**blow)]
    while (share := share * rebound) >= LEAST_REBOUND:
        parts += [_flat(2 * share * velocity / GRAVITY, level), _blow(**blow, N=share)]
    note = f"N = {own_N:.5g} is the fall from its height; another N scales the whole record"
    return _joined("drop", parts, drop, own_N=own_N, notes=(note,))


def _blow(duration, shape=VERSED_SINE, N=1.0, **shares):
    """Make a blow; where its shape ends with a jump, a line joins it to rest."""
    pulse = make_pulse(shape, **shares)
    pieces = pulse.pieces * [duration, N, N / duration, 1 / duration, N, N]
    area, jump, join = N * pulse.area * duration, N * pulse.ends[1], JOIN * duration
    if not jump:
        return Part(pieces, duration, abs(N), area, duration)
    pieces = np.vstack([pieces, [duration, jump, -jump / join, 0.0, 0.0, 0.0]])
    # Steps that are as long as the line would miss a part of its area.
    return Part(pieces, duration + join, abs(N), area + jump * join / 2, 10 * join)


def _flat(lasts, value):
    """Make a part of one value, in units of N = 1, that lasts so many us."""
    return Part(np.array([[0.0, value, 0.0, 0.0, 0.0, 0.0]]), lasts)


def _joined(name, parts, section, **others):
    """Make a pulse of parts, one after another, whose peak is the greatest of theirs."""
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
        given={name: section},
        blows=begins[:-1][blows] / lasts,
        swing=min(part.swing for part in parts) / lasts,
        strongest=Pulse("blow", alone, best.lasts, swing=best.swing / best.lasts),
        **others,
    )


def _scaled(pieces, lasts, peak):
    """Scale pieces over us to those of a pulse, over x from 0 to 1 and of peak 1."""
    scaled = pieces * [1.0, 1 / peak, lasts / peak, lasts, 1 / peak, 1 / peak]
    scaled[:, 0] /= lasts
    return scaled

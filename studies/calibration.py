"""Campaigns of simulated shots, and what `calibrate` makes of them, for its page.

./run python -m studies calibration [--small]
"""

from dataclasses import replace

import numpy as np

from snapmap import Study, threshold
from snapmap.applications.calibration.dataset import fit, surface_of
from snapmap.applications.calibration.shots import Group, Shots
from snapmap.device.device import Device
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.options import Chosen, Cosines, Elements

from .common import command_device, few, with_beam
from .tables import Table, write

DURATIONS, C = [250.0, 1000.0], 25.0
SEED, CAMPAIGNS, SHOTS = 11, 200, 15
"""Seed of the draws, number of campaigns, and shots of each duration."""
SPREADS, OFF, LEVELS, STEP = (0.02, 0.03, 0.06, 0.12), 0.1, 0.25, 0.05
RUNGS = -0.2, -0.1, 0.0, 0.1, 0.2
"""Deviations of a threshold from shot to shot; by how much the middle of a design misses it at
most; limits, steps of up-and-down, and levels of a grid about the middle; all relative."""
TRUE, RANGES = 2.0, {"thickness": (1.6, 2.6), "spring": (3.0, 8.0)}
NAMES = "the fitted model", "3 cosines", "20 elements", "a beam free to tilt, imperfection 0.1 um"
NAMES += "a stop at 12 um", "a spring of 6 N/m"
HEAD = ["shots made by", "thresholds off by", "design", "spread", "thickness, um", "half interval"]
HEAD += ["covered", "spread: median", "covered", "outside their own interval"]


def main():
    device = command_device()
    pulse = make_pulse()
    groups = tuple(Group(pulse.name, "+z", 1e6 / time, pulse) for time in few(DURATIONS, 2))
    both = {"thickness": RANGES["thickness"]}, RANGES
    surfaces = [surface_of(Study(device), groups, unknowns, C) for unknowns in few(both)]
    f0 = [group.f0 for group in groups]
    made = {
        name: threshold(study, f0, C).N_first.sel(f0=f0).values.ravel()
        for name, study in few(makers(device)).items()
    }
    fitted, asked = made[NAMES[0]], (DESIGNS[-1], SPREADS[1])
    rows = [
        row(NAMES[0], design, spread, fitted, fitted, groups, surfaces[0])
        for design in few(DESIGNS)
        for spread in few(SPREADS)
    ]
    rows += [row(name, *asked, made[name], fitted, groups, surfaces[0]) for name in [*made][1:]]
    for surface in surfaces[1:]:
        rows.append(row(f"{NAMES[0]}; spring unknown", *asked, fitted, fitted, groups, surface))
    write("calibration", Table("calibration", HEAD, rows))


def makers(device: Device) -> dict[str, Study]:
    """Return what makes the shots, by name."""
    free = with_beam(device, free=1.0, imperfection=0.1)
    models: tuple[Chosen, ...] = Cosines(modes=3), Elements(elements=20, modes=11)
    others = free, replace(device, stop_toward=12.0), replace(device, spring=6.0)
    studies = Study(device), *(Study(device, model) for model in models), *map(Study, others)
    return dict(zip(NAMES, studies, strict=True))


DESIGNS = "up-and-down", "Langlie", "grid", "mixed"


def next_level(design: str, levels: list[float], trips: list[bool]) -> float:
    """Give the next level of a design, relative to its middle; levels, trips: those so far.

    Langlie's is half way to the last level since which half of the shots tripped, or else to the
    lower limit after a trip, and to the upper one after none.
    """
    if design == "mixed":
        design = DESIGNS[len(levels) % 3]
    if design == "grid":
        return RUNGS[len(levels) % len(RUNGS)]
    if not levels:
        return 0.0
    if design == "up-and-down":
        return levels[-1] + (-STEP if trips[-1] else STEP)
    even = np.flatnonzero(np.cumsum([1 if tripped else -1 for tripped in trips[::-1]]) == 0)
    other = levels[-1 - even[0]] if even.size else -LEVELS if trips[-1] else LEVELS
    return (levels[-1] + other) / 2


def campaign(
    design: str, spread: float, N: np.ndarray, groups: tuple[Group, ...], draw: np.random.Generator
) -> Shots:
    """Draw a campaign by a design at devices whose thresholds are N, (groups,)."""
    every, all_trips = [], []
    for _ in groups:
        levels, trips, middle = [], [], draw.uniform(-OFF, OFF)
        for _ in range(SHOTS):
            levels.append(next_level(design, levels, trips))
            trips.append(middle + levels[-1] > spread * draw.normal())
        every += [middle + level for level in levels]
        all_trips += trips
    group = np.repeat(np.arange(len(groups)), SHOTS)
    return Shots(N[group] * np.exp(every), np.array(all_trips), group, groups)


def row(name, design, spread, N, fitted, groups, surface):
    """Sum up campaigns at thresholds N; fitted: those of the fitted model; both (groups,)."""
    draw, apart = np.random.default_rng(SEED), N / fitted - 1
    count = few(CAMPAIGNS, 2)
    found = [fit(campaign(design, spread, N, groups, draw), surface) for _ in range(count)]
    low, middle, high = np.array([(x.low[0], x.estimate[0], x.high[0]) for x in found], float).T
    median, least, most = np.array([x.spread.values for x in found]).T
    outside = (middle < low) | (middle > high) | (median < least) | (median > most)
    return [
        *(name, f"{apart.min():+.1%} to {apart.max():+.1%}", design, f"{spread:.0%}"),
        *(f"{middle.mean():.3f}", f"{np.median(high - low) / 2:.3f}"),
        f"{np.sum((low <= TRUE) & (high >= TRUE))} of {count}",
        f"{np.median(median):.1%}",
        f"{np.sum((least <= spread) & (most >= spread))} of {count}",
        f"{np.sum(outside)}",
    ]

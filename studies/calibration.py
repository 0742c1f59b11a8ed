"""Campaigns of simulated shots, and what `calibrate` makes of them, for its page.

./run python -m studies calibration [--small]
"""

from dataclasses import replace

import numpy as np

from snapmap import Study, threshold
from snapmap.applications.calibration.dataset import fit
from snapmap.applications.calibration.shots import Group, Shots
from snapmap.applications.calibration.surface import Surface, surface_of
from snapmap.device.device import Device
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.options import Chosen, Cosines, Elements

from .common import command_device, few, with_beam
from .tables import Table, write

DURATIONS, C = [250.0, 500.0, 1000.0, 2000.0], 25.0
SEED, CAMPAIGNS, SHOTS = 11, 100, 30
SPREAD, LEVELS = 0.03, 0.25
"""Deviation of a threshold from shot to shot, and of levels from it at most; relative."""
SPREADS, OFF, STEP, RUNGS = (0.02, 0.03, 0.06), 0.1, 0.05, (-0.2, -0.1, 0.0, 0.1, 0.2)
"""Spreads of campaigns by design; by how much the middle of a design misses the threshold at most;
the step of up-and-down, and the levels of a grid."""
TRUE, RANGES = 2.0, {"thickness": (1.6, 2.6), "spring": (3.0, 8.0)}
NAMES = "the fitted model", "3 cosines", "20 elements", "a beam free to tilt, imperfection 0.1 um"
NAMES += "a stop at 12 um", "a spring of 6 N/m"


def main():
    device = command_device()
    pulse = make_pulse()
    groups = tuple(Group(pulse.name, "+z", 1e6 / time, pulse) for time in few(DURATIONS, 2))
    both = {"thickness": RANGES["thickness"]}, RANGES
    surfaces = [surface_of(Study(device), groups, unknowns, C) for unknowns in few(both)]
    made = {name: campaigns(maker, groups) for name, maker in few(makers(device)).items()}
    fitted = made[NAMES[0]][0]
    rows = [row(name, shots, N / fitted - 1, surfaces[0]) for name, (N, shots) in made.items()]
    for surface in surfaces[1:]:
        shots = made[NAMES[0]][1]
        rows.append(row(f"{NAMES[0]}; spring unknown", shots, 0 * fitted, surface))
    head = ["shots made by", "thresholds off by", "thickness, um", "half interval", "covered"]
    by_design = [
        of_design(name, spread, made[NAMES[0]][0][::2], groups[::2], surfaces[0])
        for name in few(DESIGNS)
        for spread in few(SPREADS)
    ]
    heads = ["design", "spread", "thickness, um", "half interval", "covered", "spread: median"]
    heads += ["5 to 95 %", "covered", "outside their own interval"]
    designs = Table("calibration_designs", heads, by_design)
    write("calibration", Table("calibration", [*head, "spread"], rows), designs)


def up_and_down(levels: list[float], trips: list[bool]) -> float:
    """Give the next level, relative to the middle of a design: a step down after a trip, or up."""
    return levels[-1] + (-STEP if trips[-1] else STEP) if levels else 0.0


def langlie(levels: list[float], trips: list[bool]) -> float:
    """Give Langlie's next level: half way to the last level since which half of the shots tripped.

    If there is none, it is half way to the lower limit after a trip, or else to the upper one.
    """
    excess = np.cumsum([1 if tripped else -1 for tripped in trips[::-1]])
    even = np.flatnonzero(excess == 0)
    if not levels:
        return 0.0
    other = levels[-1 - even[0]] if even.size else -LEVELS if trips[-1] else LEVELS
    return (levels[-1] + other) / 2


def grid(levels: list[float], trips: list[bool]) -> float:
    """Give the levels of a grid in turn."""
    return RUNGS[len(levels) % len(RUNGS)]


def mixed(levels: list[float], trips: list[bool]) -> float:
    """Give levels of the three others in turn."""
    return (up_and_down, langlie, grid)[len(levels) % 3](levels, trips)


DESIGNS = {"up-and-down": up_and_down, "Langlie": langlie, "grid": grid, "mixed": mixed}


def of_design(
    name: str, spread: float, N: np.ndarray, groups: tuple[Group, ...], surface: Surface
) -> list[str]:
    """Sum up campaigns of a design, in which each group has half of the shots."""
    draw, found = np.random.default_rng(SEED), []
    for _ in range(few(CAMPAIGNS, 2)):
        all_levels, all_trips = [], []
        for _ in groups:
            levels, trips, middle = [], [], draw.uniform(-OFF, OFF)
            for _ in range(SHOTS // len(groups)):
                levels.append(DESIGNS[name](levels, trips))
                trips.append(middle + levels[-1] > spread * draw.normal())
            all_levels += [middle + level for level in levels]
            all_trips += trips
        group = np.repeat(np.arange(len(groups)), SHOTS // len(groups))
        shots = Shots(N[group] * np.exp(all_levels), np.array(all_trips), group, groups)
        found.append(fit(shots, surface))
    low, middle, high = np.array([(x.low[0], x.estimate[0], x.high[0]) for x in found], float).T
    median, least, most = np.array([x.spread.values for x in found]).T
    outside = (middle < low) | (middle > high) | (median < least) | (median > most)
    return [
        *(name, f"{spread:.0%}", f"{middle.mean():.3f}", f"{np.median(high - low) / 2:.3f}"),
        f"{np.sum((low <= TRUE) & (high >= TRUE))} of {len(found)}",
        f"{np.median(median):.1%}",
        "{:.1%} to {:.1%}".format(*np.percentile(median, [5, 95])),
        f"{np.sum((least <= spread) & (most >= spread))} of {len(found)}",
        f"{np.sum(outside)} of {len(found)}",
    ]


def makers(device: Device) -> dict[str, Study]:
    """Return what makes the shots, by name."""
    free = with_beam(device, free=1.0, imperfection=0.1)
    models: tuple[Chosen, ...] = Cosines(modes=3), Elements(elements=20, modes=11)
    others = free, replace(device, stop_toward=12.0), replace(device, spring=6.0)
    studies = Study(device), *(Study(device, model) for model in models), *map(Study, others)
    return dict(zip(NAMES, studies, strict=True))


def campaigns(study: Study, groups: tuple[Group, ...]) -> tuple[np.ndarray, list[Shots]]:
    """Find the thresholds of a study, (groups,), and draw campaigns of shots."""
    f0 = [group.f0 for group in groups]
    N, draw = threshold(study, f0, C).N_first.sel(f0=f0).values.ravel(), np.random.default_rng(SEED)
    return N, [shots_of(N, groups, draw) for _ in range(few(CAMPAIGNS, 2))]


def shots_of(N: np.ndarray, groups: tuple[Group, ...], draw: np.random.Generator) -> Shots:
    """Draw shots of all groups in turn, each at a level near its threshold."""
    group = np.arange(SHOTS) % len(groups)
    levels = N[group] * np.exp(draw.uniform(-LEVELS, LEVELS, SHOTS))
    trips = levels > N[group] * np.exp(SPREAD * draw.normal(size=SHOTS))
    return Shots(levels, trips, group, groups)


def row(name: str, shots: list[Shots], apart: np.ndarray, surface: Surface) -> list[str]:
    """Sum up the estimates of campaigns; apart: thresholds over those of the fitted model - 1."""
    found = [fit(each, surface) for each in shots]
    low, middle, high = np.array([(x.low[0], x.estimate[0], x.high[0]) for x in found], float).T
    covered = np.sum((low <= TRUE) & (high >= TRUE))
    ends = f"{apart.min():+.1%} to {apart.max():+.1%}"
    half, spread = np.median(high - low) / 2, np.mean([x.spread.values[0] for x in found])
    cells = f"{middle.mean():.3f}", f"{half:.3f}", f"{covered} of {len(shots)}", f"{spread:.1%}"
    return [name, ends, *cells]

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
    write("calibration", Table("calibration", [*head, "spread"], rows))


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

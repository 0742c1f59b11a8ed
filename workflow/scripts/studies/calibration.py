"""How often intervals of calibrated values cover, and what a wrong model does: docs/calibration.md.

PYTHONPATH=workflow/scripts ./run python -m studies.calibration [--small]
"""

import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from snapmap import load_device
from snapmap.calibration.dataset import fit
from snapmap.calibration.shots import Shots, shots_from
from snapmap.calibration.surface import Surface, surface_of
from snapmap.io.markdown import number, table
from snapmap.study import Study
from snapmap.tolerances.batch import thresholds_at

from .few import few

ROOT = Path(__file__).resolve().parents[3]
CAMPAIGNS, SHOTS, SEED = 100, 30, 31
DURATIONS = (250.0, 500.0, 1000.0, 2000.0)
"""us, of shots in turn."""
C = 25.0
RANGES = {"thickness": (1.7, 2.3), "spring": (4.0, 7.0)}
INNER = 0.25, 0.75
"""Of the ranges, within which the truth is drawn."""
SPREAD, REACH = 0.03, 0.25
"""Of the made-up devices; and how far levels lie about the thresholds of the nominal one."""
UNITS, UNIT_SHARE = 6, 0.5
MISFITS = 25
"""Campaigns for each model that is not the one fitted."""
BINS = (0.0, 0.05, 0.5, 0.95, 1.0)
HEAD = ["unknown", "covered", "half of the interval", "spread covered", "s per campaign"]
HEAD_BACK = ["fitted probability", "shots held back", "expected to trip", "tripped"]
HEAD_MISFIT = ["shots made by", "thresholds over the fitted model's", "thickness", "covered"]
HEAD_MISFIT += ["spread", "deviance over shots"]


class Campaign(NamedTuple):
    """Shots of a made-up device: those fitted, and as many held back; and its true values."""

    fitted: Shots
    back: Shots
    truth: dict[str, float]


def main():
    study = Study(device=load_device(ROOT / "config" / "config.yaml"))
    rows, back = [], []
    for names in (["thickness"], ["thickness", "spring"]):
        ranges = {name: RANGES[name] for name in names}
        told, seen = coverage(study, ranges)
        rows += told
        back = back or seen
    print(table(HEAD, [*rows, *coverage(study, {"thickness": RANGES["thickness"]}, UNITS)[0]]))
    print()
    print(table(HEAD_BACK, held_back(back)), end="\n\n")
    print(table(HEAD_MISFIT, misfits(study)))


def coverage(study, ranges, units=0):
    """A row for each unknown; and the fitted probabilities of shots held back, with what they did.

    units: how many specimens are shot in turn; 0 for one each
    """
    draw = np.random.default_rng([SEED, len(ranges), units])
    surface = surface_for(study, ranges)
    low, high = np.array(list(ranges.values())).T
    truths = low + (high - low) * draw.uniform(*INNER, (few(CAMPAIGNS, 3), len(ranges)))
    values = dict(zip(ranges, truths.T, strict=True))
    thresholds = thresholds_of(study, values)
    nominal = nominal_thresholds(study)
    began, found, back = time.perf_counter(), [], []
    for truth, own in zip(truths, thresholds, strict=True):
        made = campaign(study, draw, nominal, own, dict(zip(ranges, truth, strict=True)), units)
        found.append((made, fit(made.fitted, surface)))
    took = (time.perf_counter() - began) / len(found)
    for made, one in found:
        back.append((chances(surface, one, made.back), made.back.tripped))
    spreads = sum(covers(one.spread.sel(bound=["low", "high"]).values, SPREAD) for _, one in found)
    who = f", {units} specimens" if units else ""
    beside = " and ".join(ranges) if len(ranges) > 1 else "alone"
    rows = []
    for name in ranges:
        ones = [(one.sel(unknown=name), made.truth[name]) for made, one in found]
        hits = sum(covers((one.low.item(), one.high.item()), truth) for one, truth in ones)
        half = np.mean([(one.high - one.low).item() / 2 for one, _ in ones])
        label = f"{name} ({beside}{who})"
        share = f"{hits} of {len(found)}"
        rows.append([label, share, number(half), f"{spreads} of {len(found)}", number(took)])
    return rows, back


def surface_for(study, ranges) -> Surface:
    """Thresholds of the fitted model at all durations."""
    rows = {"duration": DURATIONS, "N": [1.0, 1.0, 2.0, 2.0], "tripped": [0, 0, 1, 1]}
    shots = shots_from(rows, study.shocks, study.device)
    return surface_of(study, shots.groups, ranges, C)


def thresholds_of(study, values):
    """True thresholds by the solver itself, (devices, durations)."""
    each = [thresholds_at(study, values, 1e6 / duration, C)[0] for duration in DURATIONS]
    return np.array(each).T


def nominal_thresholds(study):
    """Of the device as drawn, about which levels are chosen, (durations,)."""
    thickness = np.array([study.device.beam.thickness])
    return thresholds_of(study, {"thickness": thickness})[0]


def campaign(study, draw, nominal, own, truth, units=0) -> Campaign:
    """Shots at levels about the nominal thresholds, at a device whose own thresholds are given."""
    while True:
        both = [_shots(study, draw, nominal, own, units) for _ in range(2)]
        if all(isinstance(one, Shots) for one in both):
            return Campaign(*both, truth)


def _shots(study, draw, nominal, own, units):
    place = np.arange(SHOTS) % len(DURATIONS)
    N = nominal[place] * np.exp(draw.uniform(-REACH, REACH, SHOTS))
    apart = SPREAD * draw.standard_normal(SHOTS)
    rows = {"N": N, "duration": np.array(DURATIONS)[place]}
    if units:
        rows["unit"] = np.arange(SHOTS) * units // SHOTS
        own_of_unit = SPREAD * draw.standard_normal(units)[rows["unit"]]
        apart = np.sqrt(1 - UNIT_SHARE) * apart + np.sqrt(UNIT_SHARE) * own_of_unit
    rows["tripped"] = np.log(N / own[place]) > apart
    try:
        return shots_from(rows, study.shocks, study.device)
    except ValueError:  # all of one kind
        return None


def covers(ends, truth):
    """Whether a value lies between two."""
    return bool(ends[0] <= truth <= ends[1])


def chances(surface, found, shots):
    """Fitted probabilities of shots that were held back."""
    low, high = np.array(list(surface.unknowns.values())).T
    logs = surface.at((found.estimate.values - low) / (high - low))
    spread = np.hypot(found.spread.values[0], surface.error)[shots.group]
    return ndtr((np.log(shots.N) - np.ravel(logs)[shots.group]) / spread)


def held_back(back):
    """A row for each range of fitted probabilities: how many shots, expected, and tripped."""
    fitted, tripped = (np.concatenate(columns) for columns in zip(*back, strict=True))
    place = np.digitize(fitted, BINS[1:-1])
    rows = []
    for i, (low, high) in enumerate(pairwise(BINS)):
        mine = place == i
        seen = [f"{fitted[mine].sum():.0f}", str(tripped[mine].sum())]
        rows.append([f"{low:.0%} to {high:.0%}", str(mine.sum()), *seen])
    return rows


def misfits(study):
    """A row for each model of which the shots are, while the usual one is fitted."""
    ranges = {"thickness": RANGES["thickness"]}
    surface, nominal = surface_for(study, ranges), nominal_thresholds(study)
    rows = []
    for name, other in few(others(study), 2).items():
        own = nominal_thresholds(other)
        draw = np.random.default_rng(SEED)
        truth = {"thickness": study.device.beam.thickness}
        found = []
        for _ in range(few(MISFITS, 2)):
            made = campaign(study, draw, nominal, own, truth)
            found.append(fit(made.fitted, surface))
        hits = sum(covers((one.low.item(), one.high.item()), truth["thickness"]) for one in found)
        mean = np.mean([one.estimate.item() for one in found])
        spread = np.mean([one.spread.values[0] for one in found])
        deviance = np.mean([(one.residual**2).mean().item() for one in found])
        apart = ", ".join(f"{ratio - 1:+.2%}" for ratio in own / nominal)
        told = [name, apart, f"{mean:.3f}", f"{hits} of {len(found)}"]
        rows.append([*told, f"{spread:.1%}", f"{deviance:.2f}"])
    return rows


def others(study):
    """Studies whose thresholds are not those of the fitted model, by what sets them apart."""
    device = study.device
    tilts = replace(device.beam, free=1.0, imperfection=0.05)
    return {
        "the fitted model": study,
        "20 elements": replace(study, model={"name": "elements", "elements": 20, "modes": 12}),
        "3 cosines": replace(study, model={"name": "cosines", "modes": 3}),
        "a beam free to tilt": replace(study, device=replace(device, beam=tilts)),
        "a stop at 12 um": replace(study, device=replace(device, stop_toward=12.0)),
        "a stiffer spring, 6 N/m": replace(study, device=replace(device, spring=6.0)),
    }


if __name__ == "__main__":
    main()

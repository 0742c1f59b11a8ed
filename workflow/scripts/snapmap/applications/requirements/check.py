"""Shocks that must or must not trip a device, each held against its own threshold."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ...beam.stress import break_probability
from ...device.device import Device
from ...solver.outcome import FAILED, OUTCOMES, label, side_at_end
from ...solver.settings import THRESHOLD_TOLERANCE
from ...study.axes import duration_of
from ...study.shock import Shock
from ...study.study import ANY, Study
from ...thresholds.surface import first_snaps
from ..histories.history import NEAR, follow_near
from .verdict import (
    DIFFERS,
    MET,
    NO_ARRIVAL,
    OPEN,
    RETURNS,
    STAYS,
    UNCLEAR,
    VIOLATED,
    Verdict,
    each_device,
)

SEARCHED = "N_first", "N_error", "N_always", "ragged"
"""Results of a search along N, for each row."""


def check(
    study: Study,
    requirements: Sequence[Shock],
    C: Sequence[float],
    tolerance: float = THRESHOLD_TOLERANCE,
    temperatures: Sequence[float] = (),
) -> list[Verdict]:
    """Simulate each required shock with its own pulse and find the threshold of that pulse.

    study: its pulse and start do not matter
    C: uN us/um; tolerance: relative tolerance of the thresholds
    temperatures: degC; empty for those of the devices
    Returns a Verdict for each device, temperature, shape and direction of a requirement, and C.
    """
    return [
        verdict
        for required in requirements
        for name, shaken in each_device(required.shaken(study), temperatures)
        for verdict in _verdicts(shaken, name, required, C, tolerance)
    ]


def _verdicts(study, name, required, C, tolerance):
    N, f0, must, settings = required.N, required.f0, required.snaps, study.run
    axes = {"C": C, "f0": [f0]}
    thresholds, grid = first_snaps(study, axes, tolerance), study.set_out(axes)
    near = NEAR if must not in (False, ANY) else np.ones(1)
    runs = follow_near(study, grid, N * near)
    own = runs[0].take((slice(None), near.size // 2))
    outcomes, arrives = label(own, settings.energy_tolerance), np.isfinite(own.t_snap)
    ends = zip(*_ends(runs, settings.energy_tolerance), strict=True)
    columns = {key: thresholds[key].values.ravel() for key in SEARCHED}
    corners = product(study.shocks.each(), C)
    for i, ((shocks, damping), (end, share)) in enumerate(zip(corners, ends, strict=True)):
        row = {key: column[i].item() for key, column in columns.items()}
        first, error = row["N_first"], row["N_error"]
        over = study.device.gravity / shocks.pulse.peak
        is_close = must != ANY and _is_close(**row, N=N)
        verdict = UNCLEAR if outcomes[i] == FAILED or is_close else MET
        end = end if arrives[i] else NO_ARRIVAL
        if verdict == MET and must != ANY and bool(must) != arrives[i]:
            verdict = VIOLATED
        elif verdict == MET and must is True:
            verdict = {STAYS: MET, RETURNS: VIOLATED}.get(end, UNCLEAR)
        yield Verdict(
            requirement=required.name,
            device=name,
            shape=shocks.pulse.name,
            direction=shocks.direction,
            N=N,
            f0=f0,
            duration=duration_of(f0),
            C=damping,
            temperature=float(study.device.temperature),
            must_snap=must,
            outcome=OUTCOMES[outcomes[i]],
            N_first=first,
            N_error=error,
            margin=first / N,
            margin_error=error / N,
            verdict=verdict,
            scale=N * over,
            scale_first=first * over,
            drop=shocks.pulse.words if "drop" in shocks.pulse.section else "",
            start=settings.start,
            end=end,
            share_staying=share,
        )


def _ends(runs, tolerance):
    """Compare runs, each (rows, n): how those of each row end that arrive, and which share stays.

    RETURNS if none stays, though some may still swing.
    """
    sides = np.stack([side_at_end(run, tolerance) for run in runs], axis=1)
    ended = np.stack([np.isfinite(run.t_snap) & (run.well > 0) for run in runs], axis=1)
    ends, shares = [], []
    for side, which in zip(sides, ended, strict=True):
        stays = side[which] == 2
        gone = RETURNS if (side[which] == 1).any() else OPEN
        ends.append((STAYS if stays.all() else DIFFERS) if stays.any() else gone)
        shares.append(float(stays.mean()) if stays.size else np.nan)
    return ends, shares


def judge(verdict: Verdict, device: Device, must_survive: float) -> Verdict:
    """Add survival to a verdict by the largest stress of its shock.

    It is VIOLATED if the beam breaks too probably.
    """
    strength, stress = device.strength_threshold + device.strength, verdict.stress_max
    judged = replace(
        verdict,
        must_survive=must_survive,
        strength_margin=strength / stress if stress > 0 and strength < np.inf else np.nan,
        break_probability=break_probability(device, stress).item(),
    )
    return replace(judged, verdict=VIOLATED) if judged.breaks else judged


def _is_close(N_first: float, N_error: float, N_always: float, ragged: int, N: float) -> bool:
    """Whether N is within the error bar of the first snap, or in the ragged range above it."""
    last = np.fmax(N_first, N_always) if ragged else N_first
    return bool(N_first - N_error <= N <= last + N_error)

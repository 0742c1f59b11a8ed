"""Shocks that must or must not trip a device, each held against its own threshold."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from ...beam.stress import break_probability
from ...device.device import Device
from ...files.text import plain
from ...solver.outcome import FAILED, OUTCOMES, label, side_at_end
from ...solver.settings import THRESHOLD_TOLERANCE
from ...study.axes import duration_of
from ...study.shock import Shock
from ...study.study import ANY, Study
from ...thresholds.surface import first_snaps
from ..histories.near import NEAR, follow_near
from .corners import (
    DIFFERS,
    MET,
    NO_ARRIVAL,
    OPEN,
    RETURNS,
    STAYS,
    UNCLEAR,
    VIOLATED,
    Verdict,
    beyond,
    corner_text,
    end_text,
)

LEVELS = {"random": " g rms", "spectrum": " times it"}
"""Units of the thresholds of vibration and of spectra, by the shape of a verdict."""
SEARCHED = "N_first", "N_error", "N_always", "ragged"
"""Results of a search along N, for each row."""


class Survival(NamedTuple):
    """Whether the beam survives a required shock.

    must_survive: least probability that it must not break; 0 if it may break
    strength_margin: strength over the largest stress, NaN without a strength; of a Weibull
        distribution the strength at which 63 % break
    break_probability: probability that it breaks; 0 or 1 if the strength is a number
    """

    must_survive: float
    strength_margin: float
    break_probability: float


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


def each_device(study: Study, temperatures: Sequence[float] = ()) -> Iterator[tuple[str, Study]]:
    """Yield the name and the study of each device at each temperature.

    The name of a single device is empty. Without temperatures each device keeps its own.
    """
    several = isinstance(study.device, Mapping)
    for name, device in study.devices().items():
        for tempered in [device.at(degrees) for degrees in temperatures] or [device]:
            yield name if several else "", replace(study, device=tempered)


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
            start=settings.start,
            end=end,
            share_staying=share,
        )


def _ends(runs, tolerance):
    """Compare runs, each (rows, n): how those of each row end that arrive, and which share stays.

    RETURNS if none stays, though some may still swing.
    """
    sides = np.stack([side_at_end(run, tolerance) for run in runs], axis=1)
    arrive = np.stack([np.isfinite(run.t_snap) for run in runs], axis=1)
    ends, shares = [], []
    for side, which in zip(sides, arrive, strict=True):
        stays = side[which] == 2
        gone = RETURNS if (side[which] == 1).any() else OPEN
        ends.append((STAYS if stays.all() else DIFFERS) if stays.any() else gone)
        shares.append(float(stays.mean()) if stays.size else np.nan)
    return ends, shares


def judge(
    verdict: Verdict, device: Device, stress: float, must_survive: float
) -> tuple[Verdict, Survival]:
    """Add survival to a verdict by the largest stress of the shock, MPa.

    Returns the verdict, VIOLATED if the beam breaks too probably, and the Survival.
    """
    strength = device.strength_threshold + device.strength
    margin = strength / stress if stress > 0 and strength < np.inf else np.nan
    breaks = break_probability(device, stress).item()
    if breaks > 1 - must_survive:
        verdict = verdict._replace(verdict=VIOLATED)
    return verdict, Survival(must_survive, margin, breaks)


def _is_close(N_first: float, N_error: float, N_always: float, ragged: int, N: float) -> bool:
    """Whether N is within the error bar of the first snap, or in the ragged range above it."""
    last = np.fmax(N_first, N_always) if ragged else N_first
    return bool(N_first - N_error <= N <= last + N_error)


def worst(verdicts: Sequence[Verdict]) -> tuple[Verdict | None, str]:
    """Choose the verdict whose threshold is furthest on the wrong side, or else nearest to it.

    Returns the verdict and its description, or None and "" if no requirement is about a trip.
    """
    tripping = [verdict for verdict in verdicts if verdict.must_snap != ANY]
    if not tripping:
        return None, ""
    furthest = max(tripping, key=lambda verdict: beyond(verdict.margin, verdict.must_snap))
    names = furthest.requirement, furthest.device, corner_text(furthest._asdict())
    where = ", ".join(filter(None, names))
    if np.isnan(furthest.margin):
        return furthest, f"{where}: nothing snaps"
    side = "not sensitive enough" if furthest.must_snap else "too sensitive"
    is_wrong = beyond(furthest.margin, furthest.must_snap) > 0
    words = f"{where}: {side}, " if is_wrong else f"least margin at {where}: "
    need = "must" if furthest.must_snap else "must not"
    unit = LEVELS.get(furthest.shape, "")
    lead = "" if unit else "N = "
    first, N = (f"{lead}{plain(N)}{unit}" for N in (furthest.N_first, furthest.N))
    return furthest, f"{words}trips at {first}, {need} at {N}"


def restless(verdicts: Sequence[Verdict]) -> str:
    """Write which shocks must make the beam stay, but do not surely; the worst corner of each."""
    wrong = [v for v in verdicts if v.must_snap is True and v.end in (RETURNS, DIFFERS, OPEN)]
    lines: dict[str, str] = {}
    for verdict in sorted(wrong, key=lambda verdict: verdict.share_staying):
        row = verdict._asdict()
        where = f"{verdict.requirement}, {corner_text(row)}, N = {plain(verdict.N)}"
        lines.setdefault(verdict.requirement, f"{where}: {end_text(row)}")
    return "; ".join(lines.values())


def summary(verdicts: Sequence[Verdict]) -> str:
    """Write in a line how many requirements are met everywhere, and which are not."""
    kinds = dict.fromkeys((verdict.requirement for verdict in verdicts), MET)
    for kind in (UNCLEAR, VIOLATED):
        kinds |= {verdict.requirement: kind for verdict in verdicts if verdict.verdict == kind}
    parts = [f"{list(kinds.values()).count(MET)} of {len(kinds)} requirements met"]
    for kind in (VIOLATED, UNCLEAR):
        if names := ", ".join(name for name in kinds if kinds[name] == kind):
            parts.append(f"{kind}: {names}")
    return "; ".join(parts)

"""Shocks that must or must not trip a device, each held against its own threshold."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..beam.stress import break_probability
from ..device import Device, batch
from ..quantities import plain
from ..solver.adaptive import choose_model
from ..solver.cells import to_rows
from ..solver.outcome import FAILED, OUTCOMES, label
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE
from ..study import Study, of_requirement
from .surface import thresholds_of

MET, VIOLATED, UNCLEAR = "met", "failed", "unclear"
LEVELS = {"random": " g rms", "spectrum": " times it"}
"""Units of thresholds of what is no single shock."""


class Verdict(NamedTuple):
    """One requirement on one device at one damping.

    N, N_first, N_error: multiples of g; f0: Hz; duration: ms; C: uN us/um
    scale, scale_first: N and N_first as factors of the record; NaN unless it is one
    margin, margin_error: N_first and its bar over N; NaN where nothing snaps
    outcome: of the shock as simulated; verdict: MET, VIOLATED, or UNCLEAR within the bar
    start: as in `Settings`
    """

    requirement: str
    device: str
    shape: str
    direction: str
    N: float
    f0: float
    duration: float
    C: float
    must_snap: bool
    outcome: str
    N_first: float
    N_error: float
    margin: float
    margin_error: float
    verdict: str
    scale: float
    scale_first: float
    start: str = FIRST


class Survival(NamedTuple):
    """What a required shock leaves of the beam.

    must_survive: the least probability with which it must not break; 0 if it may
    strength_margin: strength over the largest stress; of a Weibull distribution that of which 63 %
        break; NaN if it never does
    break_probability: under that stress; 0 or 1 if the strength is a number
    """

    must_survive: float
    strength_margin: float
    break_probability: float


def check(
    study: Study,
    requirements: Sequence[Mapping],
    C: Sequence[float],
    tolerance: float = THRESHOLD_TOLERANCE,
) -> list[Verdict]:
    """Simulate each required shock with its own pulse and find the threshold of that pulse.

    study: whose pulse and start are of no account
    requirements: name, shocks (of one shape and direction), N, f0 (Hz), snaps and start of each
    C: uN us/um; tolerance: of the thresholds in N, relative
    """
    return [
        verdict
        for asked, name, one in each_device(study, requirements)
        for verdict in _verdicts(one, name, asked, C, tolerance)
    ]


def each_device(
    study: Study, requirements: Sequence[Mapping]
) -> Iterator[tuple[Mapping, str, Study]]:
    """Each requirement with the name and the study of each device; a single one has no name."""
    several = isinstance(study.device, Mapping)
    for asked in requirements:
        for name, device in study.devices().items():
            one = of_requirement(study, asked)
            yield asked, name if several else "", replace(one, device=device)


def _verdicts(study, name, asked, C, tolerance):
    N, f0, shocks, settings = asked["N"], asked["f0"], study.shocks, study.settings
    found = thresholds_of(study, {"C": C, "f0": [f0]}, tolerance).squeeze("f0")
    device = batch([study.device])
    rows = to_rows(0, f0, C, pulses=shocks.pulses)
    cells = rows.cells(device, N, settings.horizon)
    seen = choose_model(device, study.model).follow(cells, settings)
    outcomes = label(*seen[:4], settings.energy_tolerance)[:, 0]
    for i, (damping, outcome) in enumerate(zip(C, outcomes, strict=True)):
        row, snapped = found.isel(C=i), bool(np.isfinite(seen.t_snap[i, 0]))
        first, error = row.N_first.item(), row.N_error.item()
        over = study.device.gravity / shocks.pulse.peak
        verdict = UNCLEAR if outcome == FAILED or _is_close(row, N) else MET
        if verdict == MET and snapped != asked["snaps"]:
            verdict = VIOLATED
        yield Verdict(
            *(asked["name"], name, shocks.pulse.name, shocks.direction),
            *(N, f0, 1e3 / f0, damping, asked["snaps"], OUTCOMES[outcome]),
            *(first, error, first / N, error / N, verdict, N * over, first * over, settings.start),
        )


def judge(
    verdict: Verdict, device: Device, stress: float, must_survive: float
) -> tuple[Verdict, Survival]:
    """The verdict once the largest stress of the shock is known, MPa, and what it is based on."""
    strength = device.strength_threshold + device.strength
    margin = strength / stress if stress > 0 and strength < np.inf else np.nan
    breaks = break_probability(device, stress).item()
    if breaks > 1 - must_survive:
        verdict = verdict._replace(verdict=VIOLATED)
    return verdict, Survival(must_survive, margin, breaks)


def judge_closing(
    verdict: Verdict, required: Mapping, closing: Mapping[str, float]
) -> tuple[Verdict, dict[str, float]]:
    """The verdict once it is known what an electrode sees, and its margins.

    required: with closes_within and stays_closed, us, if they are; closing: as from `closing_of`
    Margins: closes_within over t_closed, closed_for over stays_closed; NaN if it never closes.
    """
    found, margins = [verdict.verdict], {}
    if limit := required.get("closes_within"):
        closed = closing["t_closed"]
        found += [_kept(limit - closed, closing["t_closed_error"], verdict)]
        margins["closes_margin"] = limit / closed
    if limit := required.get("stays_closed"):
        closed = closing["closed_for"]
        kept = _kept(closed - limit, closing["closed_for_error"], verdict)
        # What is closed to the end of the run may stay closed beyond.
        found += [UNCLEAR if kept == VIOLATED and closing["openings"] == 0 else kept]
        margins["stays_margin"] = closed / limit
    return verdict._replace(verdict=max(found, key=(MET, UNCLEAR, VIOLATED).index)), margins


def _kept(slack, error, verdict):
    """How a requirement stands by so much, with its error; NaN where it never closes."""
    if np.isnan(slack):
        return UNCLEAR if verdict.verdict == UNCLEAR else VIOLATED
    return MET if slack > error else VIOLATED if slack < -error else UNCLEAR


def _is_close(row: xr.Dataset, N: float) -> bool:
    """Whether N lies within the bar about the first snap, or up to that of a ragged row's last."""
    first, error = row.N_first.item(), row.N_error.item()
    last = np.fmax(first, row.N_always.item()) if row.ragged else first
    return first - error <= N <= last + error


def worst(verdicts: Sequence[Verdict]) -> tuple[Verdict, str]:
    """The verdict whose threshold is furthest on the wrong side, or nearest to it; and in words."""

    def beyond(one):
        """The margin on the wrong side, as a logarithm."""
        size = np.inf if np.isnan(one.margin) else np.log(one.margin)
        return size if one.must_snap else -size

    def level(N):
        return f"{plain(N)}{LEVELS[one.shape]}" if one.shape in LEVELS else f"N = {plain(N)}"

    one = max(verdicts, key=beyond)
    where = ", ".join(filter(None, [one.requirement, one.device, f"C = {plain(one.C)}"]))
    if np.isnan(one.margin):
        return one, f"{where}: nothing snaps"
    side = "not sensitive enough" if one.must_snap else "too sensitive"
    words = f"{where}: {side}, " if beyond(one) > 0 else f"nearest is {where}: "
    need = "must" if one.must_snap else "must not"
    return one, f"{words}trips at {level(one.N_first)}, {need} at {level(one.N)}"


def summary(verdicts: Sequence[Verdict]) -> str:
    """One line: how many requirements are met everywhere, and the names of those that are not."""
    worst = {one.requirement: MET for one in verdicts}
    for kind in (UNCLEAR, VIOLATED):
        worst |= {one.requirement: kind for one in verdicts if one.verdict == kind}
    names = {kind: [key for key in worst if worst[key] == kind] for kind in (VIOLATED, UNCLEAR)}
    told = [f"{len(worst) - sum(map(len, names.values()))} of {len(worst)} requirements met"]
    told += [f"{kind}: {', '.join(keys)}" for kind, keys in names.items() if keys]
    return "; ".join(told)

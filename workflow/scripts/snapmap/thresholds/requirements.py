"""Shocks that must or must not trip a device, each held against its own threshold."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..device import Device, batch
from ..pulse import Shocks
from ..solver.adaptive import choose_model
from ..solver.cells import to_cells
from ..solver.outcome import FAILED, OUTCOMES, label
from ..solver.settings import Settings
from .surface import threshold

MET, VIOLATED, UNCLEAR = "met", "failed", "unclear"


class Verdict(NamedTuple):
    """One requirement on one device at one damping.

    N, N_first, N_error: multiples of g; f0: Hz; duration: ms; C: uN us/um
    margin, margin_error: N_first and its bar over N; NaN where nothing snaps
    outcome: of the shock as simulated; verdict: MET, VIOLATED, or UNCLEAR within the bar
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


def check(
    device: Device | Mapping[str, Device],
    requirements: Sequence[Mapping],
    C: Sequence[float],
    model: Mapping,
    followed: Mapping,
    threads: int = 1,
) -> list[Verdict]:
    """Simulate each required shock with its own pulse and find the threshold of that pulse.

    device: one, or several by name; C: uN us/um; model: name and options
    requirements: name, shocks (of one shape and direction), N, f0 (Hz) and snaps of each
    followed: horizon (us), energy_tolerance and tolerance, as `threshold` takes them
    """
    named = device if isinstance(device, Mapping) else {"": device}
    return [
        verdict
        for asked in requirements
        for name, one in named.items()
        for verdict in _verdicts(one, name, asked, C, model, followed, threads)
    ]


def _verdicts(device, name, asked, C, model, followed, threads):
    shocks: Shocks = asked["shocks"]
    push = {"pulse": shocks.pulse, "direction": shocks.direction, "threads": threads}
    N, f0 = asked["N"], asked["f0"]
    found = threshold(device, [f0], C, model=model, **followed, **push).squeeze("f0")
    settings = Settings(
        followed["horizon"],
        energy_tolerance=followed["energy_tolerance"],
        threads=threads,
        pulses=shocks.pulses,
    )
    device = batch([device])
    cells = to_cells(device, 0, [[N]], f0, np.reshape(C, (-1, 1)), settings.horizon)
    seen = choose_model(device, model).follow(cells, settings)
    outcomes = label(*seen[:4], settings.energy_tolerance)[:, 0]
    for i, (damping, outcome) in enumerate(zip(C, outcomes, strict=True)):
        row, snapped = found.isel(C=i), bool(np.isfinite(seen.t_snap[i, 0]))
        first, error = row.N_first.item(), row.N_error.item()
        verdict = UNCLEAR if outcome == FAILED or _is_close(row, N) else MET
        if verdict == MET and snapped != asked["snaps"]:
            verdict = VIOLATED
        yield Verdict(
            *(asked["name"], name, shocks.pulse.name, shocks.direction),
            *(N, f0, 1e3 / f0, damping, asked["snaps"], OUTCOMES[outcome]),
            *(first, error, first / N, error / N, verdict),
        )


def _is_close(row: xr.Dataset, N: float) -> bool:
    """Whether N lies within the bar about the first snap, or up to that of a ragged row's last."""
    first, error = row.N_first.item(), row.N_error.item()
    last = np.fmax(first, row.N_always.item()) if row.ragged else first
    return first - error <= N <= last + error


def summary(verdicts: Sequence[Verdict]) -> str:
    """One line: how many requirements are met everywhere, and the names of those that are not."""
    worst = {one.requirement: MET for one in verdicts}
    for kind in (UNCLEAR, VIOLATED):
        worst |= {one.requirement: kind for one in verdicts if one.verdict == kind}
    names = {kind: [key for key in worst if worst[key] == kind] for kind in (VIOLATED, UNCLEAR)}
    told = [f"{len(worst) - sum(map(len, names.values()))} of {len(worst)} requirements met"]
    told += [f"{kind}: {', '.join(keys)}" for kind, keys in names.items() if keys]
    return "; ".join(told)

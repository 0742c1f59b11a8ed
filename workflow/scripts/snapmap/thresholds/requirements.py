"""Shocks that must or must not trip a device, each held against its own threshold."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..device import Device
from ..io.recorded import shocks_of
from ..pulse import Shocks
from ..solver.outcome import OUTCOMES
from ..sweeps.cube import sweep
from .surface import threshold

MET, FAILED, UNCLEAR = "met", "failed", "unclear"


class Verdict(NamedTuple):
    """One requirement on one device at one damping.

    N, N_first, N_error: multiples of g; f0: Hz; duration: ms; C: uN us/um
    margin, margin_error: N_first and its bar over N; NaN where nothing snaps
    outcome: of the shock as simulated; verdict: MET, FAILED, or UNCLEAR within the bar
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
    requirements: name, pulse (values for `shocks_of`), N, f0 (Hz) and snaps of each
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
    shocks: Shocks = shocks_of(asked["pulse"])
    push = {"pulse": shocks.pulse, "direction": shocks.direction, "threads": threads}
    N, f0 = asked["N"], asked["f0"]
    found = threshold(device, [f0], C, model=model, **followed, **push)
    options = {key: model[key] for key in model if key != "name"}
    how = {key: followed[key] for key in ("horizon", "energy_tolerance")}
    cells = sweep(device, [N], [f0], C, model["name"], repeat=False, **how, **push, **options)
    for i, damping in enumerate(C):
        row, cell = found.isel(C=i, f0=0), cells.isel(C=i, f0=0, N=0)
        first, error = row.N_first.item(), row.N_error.item()
        yield Verdict(
            *(asked["name"], name, shocks.pulse.name, shocks.direction),
            *(N, f0, 1e3 / f0, damping, asked["snaps"], OUTCOMES[cell.outcome.item()]),
            *(first, error, first / N, error / N, _verdict(row, cell, N, asked["snaps"])),
        )


def _verdict(row: xr.Dataset, cell: xr.Dataset, N: float, must: bool) -> str:
    """UNCLEAR from the bar below the first snap to that above it, or above a ragged row's last."""
    first, error = row.N_first.item(), row.N_error.item()
    last = np.fmax(first, row.N_always.item()) if row.ragged else first
    if cell.outcome.item() == OUTCOMES.index("failed") or first - error <= N <= last + error:
        return UNCLEAR
    return MET if np.isfinite(cell.t_snap.item()) == must else FAILED


def summary(verdicts: Sequence[Verdict]) -> str:
    """One line: how many requirements are met everywhere, and the names of those that are not."""
    worst = {one.requirement: MET for one in verdicts}
    for kind in (UNCLEAR, FAILED):
        worst |= {one.requirement: kind for one in verdicts if one.verdict == kind}
    names = {kind: [key for key in worst if worst[key] == kind] for kind in (FAILED, UNCLEAR)}
    told = [f"{len(worst) - sum(map(len, names.values()))} of {len(worst)} requirements met"]
    told += [f"{kind}: {', '.join(keys)}" for kind, keys in names.items() if keys]
    return "; ".join(told)

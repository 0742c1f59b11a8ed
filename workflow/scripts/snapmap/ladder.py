"""The model `auto`: a ladder of models, and for each cell the cheapest level that suffices."""

from typing import NamedTuple

import numpy as np

from .cells import Cells, Facts, follow_cells
from .device import Device
from .models import RUNGS, Model, build_model, check_options
from .protocol import Protocol
from .thresholds import lowest_snap

REACH = 2
"""Cells along N on either side of a change of label that count as near it."""


class Ladder(NamedTuple):
    """Three models of one device, ever finer.

    base labels every cell; those that are not safe are decided by top, and check says whether
    a second level agrees with it
    errors: of the threshold by base, check and top, relative, as seen against finer rungs
    """

    base: Model
    check: Model
    top: Model
    errors: tuple[float, float, float]

    @property
    def device(self) -> Device:
        """That of all three."""
        return self.base.device

    def with_step(self, factor: float) -> "Ladder":
        """The same ladder with every step multiplied by `factor`."""
        steps = {name: getattr(self, name) for name in ("base", "check", "top")}
        return self._replace(**{name: model.with_step(factor) for name, model in steps.items()})


def choose_model(device: Device, name: str = "handout", **options) -> Model | Ladder:
    """Build the model of a config's model section, or the ladder that `auto` stands for."""
    if name != "auto":
        return build_model(device, name, **options)
    check_options(device, name, options)
    return build_ladder(device, **options)


def build_ladder(device: Device, tolerance: float = 1e-3) -> Ladder:
    """Choose the rungs for a device by their thresholds; ValueError if none is fine enough.

    tolerance: of the threshold, relative; check is the first rung that keeps it, top the next
    """
    models, thresholds, errors = [], [], []
    for modes in RUNGS:
        models.append(build_model(device, "cosines", modes=modes))
        thresholds.append(_thresholds(models[-1], thresholds))
        errors = [_difference(coarse, thresholds[-1]) for coarse in thresholds[:-1]]
        if len(errors) > 2 and errors[-2] < tolerance:
            return Ladder(models[0], *models[-3:-1], (errors[0], *errors[-2:]))
    finest = f"{errors[-2]:.1g}" if len(errors) > 1 else "unknown"
    raise ValueError(f"model.tolerance: {tolerance:g} is below the finest error here, {finest}")


def _difference(coarse, fine):
    return float(np.max(abs(coarse / fine - 1), initial=0.0, where=np.isfinite(coarse + fine)))


def _thresholds(model, coarser):
    """Thresholds under pulses longer than the mass's own period, where they are smooth in f0."""
    device = model.device
    # ASSUME: a rung's error in three long pulses stands for its error everywhere else.
    own_frequency = np.sqrt(device.spring / device.mass) / (2 * np.pi) * 1e6
    f0 = own_frequency * np.array([0.1, 0.2, 0.4])
    damping = np.full(3, 0.2 * np.sqrt(device.spring * device.mass))
    weight = device.spring * device.beam.rise / (device.mass * device.gravity)
    bracket = (weight / 30, 30 * weight)
    if coarser:
        bracket = 0.95 * np.nanmin(coarser[-1]), 1.05 * np.nanmax(coarser[-1])
    protocol = Protocol(horizon=0.0)
    return lowest_snap(model, f0, damping, bracket, protocol, tolerance=1e-5)


def climb(
    ladder: Ladder, cells: Cells, columns: int, protocol: Protocol, threads: int = 1
) -> tuple[Facts, np.ndarray, np.ndarray]:
    """Follow cells, `columns` runs of equally many ascending N, each by the level that suffices.

    A cell is safe where base sees no change of label within REACH along N and its ledger closes.
    Returns the facts; the level that decided each cell, 0 for base and 1 for top; and 0 where
    check and top disagree on whether it snaps, else 1.
    """
    facts = follow_cells(ladder.base, cells, protocol, threads)
    n_cells = facts.well.size
    level, agreed = np.zeros(n_cells, np.int8), np.ones(n_cells, np.int8)
    unsafe = ~(facts.energy_error <= protocol.energy_tolerance) | _at_end(columns, n_cells)
    while True:
        unsafe |= _near_change(np.isfinite(facts.t_snap).reshape(columns, -1))
        new = np.flatnonzero(unsafe & (level == 0))
        if new.size == 0:
            return facts, level, agreed
        some = Cells(*(values[new] for values in cells))
        check = follow_cells(ladder.check, some, protocol, threads)
        top = follow_cells(ladder.top, some, protocol, threads)
        level[new] = 1
        agreed[new] = np.isfinite(check.t_snap) == np.isfinite(top.t_snap)
        for whole, part in zip(facts, top, strict=True):
            whole[new] = part


def _at_end(columns, size):
    """The first and last N of each column: what lies beyond is unknown."""
    ends = np.zeros((columns, size // columns), bool)
    ends[:, [0, -1]] = True
    return ends.ravel()


def _near_change(snapped):
    """Cells within REACH of a change of label along N; (columns * n,)."""
    near = np.zeros(snapped.shape, bool)
    for shift in range(1, min(REACH, snapped.shape[1] - 1) + 1):
        differ = snapped[:, shift:] != snapped[:, :-shift]
        near[:, shift:] |= differ
        near[:, :-shift] |= differ
    return near.ravel()

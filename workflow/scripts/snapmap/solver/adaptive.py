"""The model `auto`: several levels of models, and for each cell the cheapest that suffices."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Optional

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device import Device
from .cells import Cells, Observations
from .models import Follows, build_model, check_options
from .settings import FIRST, Settings

RUNGS = (3, 5, 11)
"""Cosines of the levels: odd ones, as even ones do not move the midpoint."""
REACH = 2
"""Cells along N on either side of a change of label that count as near it."""
LOOKING_STEPS, DECIDING_STEPS, FINE_STEPS = 2.0, 0.5, 0.25
"""Times its own, of the finest model: where it looks for changes, decides, and shows islands."""
LOOKING_TOLERANCE = 2.5e-4
"""Of thresholds that are only looked at, relative."""
TOLERANCE = 1e-3
"""Error of the threshold that `auto` may make, relative, by default; that of its steps, too."""


@dataclass(frozen=True, eq=False)
class Adaptive:
    """Three models of one device or a batch, ever finer.

    base labels every cell; those that are not safe are decided by top, and check says whether a
    second level agrees with it
    """

    base: Follows
    check: Follows
    top: Follows

    @property
    def device(self) -> Device:
        """That of all three."""
        return self.base.device

    @property
    def levels(self) -> tuple[Follows, Follows]:
        """Those that decide cells."""
        return self.base, self.top

    def with_step(self, factor: float) -> "Adaptive":
        """The same levels with every step multiplied by `factor`."""
        return Adaptive(*(one.with_step(factor) for one in (self.base, self.check, self.top)))

    def pick(self, which: int | np.ndarray) -> "Adaptive":
        """The same levels of one device of the batch, or of some."""
        return Adaptive(*(one.pick(which) for one in (self.base, self.check, self.top)))

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow rows of cells along ascending N, (rows, n), each cell by the level that suffices.

        A cell is safe where base sees no change of label within REACH along N and its ledger
        closes; whether others snap is told in the steps of a threshold.
        """
        # Of no cells: the kernel that takes longest to compile comes first, while a job of
        # thresholds beside this one compiles base's.
        none = cells.take(np.zeros(0, int)).flat()
        for _, model in self.top.split(none.device):
            model.follow_once(none, settings)
        seen = self.base.follow(cells, settings)
        level, agreed = np.zeros(cells.f0.shape, np.int8), np.ones(cells.f0.shape, np.int8)
        unsafe = ~(seen.energy_error <= settings.energy_tolerance)
        unsafe[:, [0, -1]] = True  # what lies beyond the ends is unknown
        while True:
            unsafe |= _near_change(np.isfinite(seen.t_snap))
            new = unsafe & (level == 0)
            if not new.any():
                return seen._replace(level=level, agreed=agreed)
            near = cells.take(new)
            check = self.check.follow(near, settings._replace(until="snap"))
            top = self._follow_near_change(near, settings)
            level[new] = 1
            agreed[new] = np.isfinite(check.t_snap) == np.isfinite(top.t_snap)
            seen.replace(new, top)

    def _follow_near_change(self, cells, settings):
        """Follow cells, (cells,), by top; whether one snaps is told in the steps of a threshold."""
        edge = self.top.follow(cells, settings._replace(until="edge"))
        if settings.until != "settled":
            return edge
        seen = self.top.follow(cells, settings)
        differ = np.isfinite(seen.t_snap) != np.isfinite(edge.t_snap)
        # The steps that the motion needs are shorter than those of either.
        seen.replace(differ, self.top.follow(cells.take(differ), settings._replace(until="moved")))
        return seen


class Survey(NamedTuple):
    """Models by which thresholds are found: scans is cheap, and doubts has another opinion.

    looks: where labels change, closely; decides: at which N exactly, in shorter steps or the same
    better: than the one that decides; None where that is the best
    finest: the best, in steps that show what others miss
    static: threshold of slow pulses, about which to look, in multiples of g; (devices,)
    judge: has its say where rows are ragged, in wider steps; None if the others suffice
    finer: takes rows of fast pulses, and the clean ones that this one leaves open by more than
        tolerance, relative; None for no further look
    """

    scans: Follows
    looks: Follows
    decides: Follows
    doubts: Follows
    better: Follows | None
    finest: Follows
    static: np.ndarray
    judge: Follows | None = None
    tolerance: float = np.inf
    finer: Optional["Survey"] = None

    def rough(self, tolerance: float) -> float:
        """How closely `looks` refines where a tolerance is asked for."""
        return tolerance if self.looks is self.decides else max(tolerance, LOOKING_TOLERANCE)

    @property
    def levels(self) -> tuple["Survey", ...]:
        """This one and the finer ones, by the `level` of their thresholds."""
        return self, *(self.finer.levels if self.finer else ())


def choose_model(device: Device, model: Mapping) -> Follows | Adaptive:
    """Build a model, given by its name and options, for a device or a batch."""
    return _levels(device, model) if model["name"] == "auto" else build_model(device, **model)


def _levels(device, model) -> Adaptive:
    options = {key: value for key, value in model.items() if key != "name"}
    check_options(device, "auto", options)
    return build_adaptive(device, **options)


def choose_survey(device: Device, model: Mapping, start: str = FIRST) -> Survey:
    """Build what finds the thresholds of a model, given by its name and options, for a batch.

    start: as in `Settings`
    """
    static = np.asarray(static_threshold(device, back=start != FIRST))
    if model["name"] != "auto":
        decides, levels = build_model(device, **model), build_adaptive(device)
        finest = levels.top.with_step(FINE_STEPS)
        return Survey(levels.base, decides, decides, levels.check, levels.top, finest, static)
    levels = _levels(device, model)
    coarse, middle, fine = levels.base, levels.check, levels.top
    looks, decides, finest = map(fine.with_step, (LOOKING_STEPS, DECIDING_STEPS, FINE_STEPS))
    finer = Survey(coarse, looks, decides, middle, None, finest, static)
    accepted = model.get("tolerance", TOLERANCE)
    others = middle, middle, coarse, None, finest, static, fine
    return Survey(coarse, *others, tolerance=accepted, finer=finer)


def build_adaptive(device: Device, tolerance: float = TOLERANCE) -> Adaptive:
    """Build the levels, with steps for a tolerance of the threshold, relative."""
    levels = (build_model(device, "cosines", modes=modes) for modes in RUNGS)
    # The scheme is of second order.
    return Adaptive(*levels).with_step(np.sqrt(tolerance / TOLERANCE))


def _near_change(snapped):
    """Cells within REACH of a change of label along N; (rows, n)."""
    near = np.zeros(snapped.shape, bool)
    for shift in range(1, min(REACH, snapped.shape[1] - 1) + 1):
        differ = snapped[:, shift:] != snapped[:, :-shift]
        near[:, shift:] |= differ
        near[:, :-shift] |= differ
    return near

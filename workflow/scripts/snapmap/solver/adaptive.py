"""The model `auto`: levels of models, of which the cheapest that suffices decides each cell."""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Optional

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device.device import Device
from .cells import Cells, Observations
from .kept import kept
from .laws import well_of
from .models import Follows, build_model, mixed, require_fitting
from .options import TOLERANCE, Auto, Chosen, Cosines
from .settings import FIRST, Run

RUNGS = (3, 5, 11)
"""Numbers of cosines of the levels; odd ones, as even cosines do not move the midpoint."""
FINER_RUNGS = (5, 7, 11)
"""Numbers of cosines where three are too few: from the second shape, where it matters at which
place the beam is struck, and for shapes as made with the cosines 4 or 5."""
REACH = 2
"""Number of cells along N, on either side of a change of label, that count as near it."""
BESIDE, FAR_BESIDE = 1.02, 1.03
"""Ratio of N up to which cells are near a change of label too: in a clean row those twice, four
times and so on as many cells away, in a ragged row, up to FAR_BESIDE, all."""
DISPUTED, AGREED, UNCOMPARED = range(3)
"""Values of `Observations.agreed`."""
FINE_STEPS = 0.5
"""Factor of the finest model's steps, to decide fast thresholds and to see islands of snap."""


@dataclass(frozen=True, eq=False)
class Adaptive:
    """Three models of a device or a batch, each finer than the one before.

    base: labels every cell
    top: decides the cells that are not safe; check: a second opinion on these
    """

    base: Follows
    check: Follows
    top: Follows

    @property
    def device(self) -> Device:
        """The device or batch of all three models."""
        return self.base.device

    @property
    def levels(self) -> tuple[Follows, Follows]:
        """The two that decide cells, by the `level` of observations."""
        return self.base, self.top

    def with_step(self, factor: float) -> "Adaptive":
        """Return the same levels with every step multiplied by `factor`."""
        return Adaptive(*(level.with_step(factor) for level in (self.base, self.check, self.top)))

    def pick(self, which: int | np.ndarray) -> "Adaptive":
        """Return the same levels of a device of the batch, or of several."""
        return Adaptive(*(level.pick(which) for level in (self.base, self.check, self.top)))

    def follow(self, cells: Cells, settings: Run) -> Observations:
        """Follow rows of cells, (rows, n), of ascending N, each cell by the level that suffices.

        A cell is safe if its ledger closes and no label changes near it along N. Others are decided
        by top, in the steps of EDGE; this repeats until no new cell is unsafe. Cells that snap
        end as in `follow_ends`.
        """
        # A run without cells compiles the kernel that takes longest first, while a job of
        # thresholds beside this one compiles that of base.
        none = cells.take(np.zeros(0, int)).flat()
        for _, model in self.top.split(none.device):
            model.follow_once(none, settings)
        observed = self.base.follow(cells, settings.but(until="snap"))
        by_base = np.isfinite(observed.t_snap)
        level = np.zeros(cells.f0.shape, np.int8)
        agreed = np.full(cells.f0.shape, UNCOMPARED, np.int8)
        unsafe = ~(observed.energy_error <= settings.energy_tolerance)
        unsafe[:, [0, -1]] = True  # what lies beyond the ends is unknown
        while True:
            unsafe |= _near_changes(cells.amplitude, by_base, np.isfinite(observed.t_snap))
            new = unsafe & (level == 0)
            if not new.any():
                break
            near = cells.take(new)
            check = self.check.follow(near, settings.but(until="snap"))
            top = self.top.follow(near, settings.but(until="edge"))
            level[new] = 1
            same = np.isfinite(check.t_snap) == np.isfinite(top.t_snap)
            agreed[new] = np.where(same, AGREED, DISPUTED)
            observed.replace(new, top)
        if settings.until == "settled":
            # Where the second run does not snap, as may be near a threshold, the end stays unknown.
            snapped = np.isfinite(observed.t_snap)
            ends = self.follow_ends(cells.take(snapped), settings)
            known = np.isfinite(ends.t_snap) | ~(ends.energy_error <= settings.energy_tolerance)
            snapped[snapped] = known
            observed.replace(snapped, ends.take(known)._replace(t_snap=observed.t_snap[snapped]))
        return observed._replace(level=level, agreed=agreed)

    def follow_ends(self, cells: Cells, settings: Run) -> Observations:
        """Follow cells that snap to their end, (cells,), by check; those that come back, by top.

        The fewer cosines share the energy of a snap, the more often a beam comes back.
        """
        ends = self.check.follow(cells, settings.but(until="end"))
        back = np.isfinite(ends.t_snap) & (ends.well != 2)
        ends.replace(back, self.top.follow(cells.take(back), settings.but(until="end")))
        return ends


class Survey(NamedTuple):
    """Models that determine thresholds.

    scans: the cheap model, which finds where labels change along N
    decides: model whose changes are the thresholds
    ragged: model in its place where labels change back and forth, in the steps of maps
    others: models to compare it with; if there are two, the second is better than `decides`
    finest: the best model, in steps that show what others miss; None if it decides
    static: threshold of slow pulses, near which to look, in multiples of g, (devices,)
    judges: finer models to compare rows with, too
    tolerance: largest relative error of a clean row that `finer` does not take over
    finer: survey of rows with fast pulses, and of clean rows of larger error; None for no other
    lawful: whether models have a user's laws, for which no static threshold is known
    """

    scans: Follows
    decides: Follows
    ragged: Follows
    others: tuple[Follows, ...]
    finest: Follows | None
    static: np.ndarray
    judges: tuple[Follows, ...] = ()
    tolerance: float = np.inf
    finer: Optional["Survey"] = None
    lawful: bool = False

    @property
    def levels(self) -> tuple["Survey", ...]:
        """This survey and finer ones, by the `level` of their thresholds."""
        return self, *(self.finer.levels if self.finer else ())


def choose_model(device: Device, chosen: Chosen, start: str = FIRST) -> Follows | Adaptive:
    """Build the chosen model for a device or a batch; start: as in `Run`."""
    if not isinstance(chosen, Auto):
        return build_model(device, chosen)
    require_fitting(device, chosen)
    build = partial(build_adaptive, device, chosen.tolerance, start)
    return kept(build, device, chosen, "levels", start)


def choose_survey(device: Device, chosen: Chosen, start: str = FIRST) -> Survey:
    """Build the survey of the chosen model for a batch; start: as in `Run`."""
    return kept(partial(_survey, device, chosen, start), device, chosen, "survey", start)


def _survey(device, chosen, start):
    static = np.asarray(static_threshold(device, back=start != FIRST))
    if laws := chosen.laws:
        # No finer model judges a kernel's thresholds, so they are found in finer steps.
        return _of_laws(build_model(device, chosen).with_step(FINE_STEPS), laws, static)
    levels = choose_model(device, chosen if isinstance(chosen, Auto) else Auto(), start)
    coarse, middle, fine = levels.base, levels.check, levels.top
    finest = fine.with_step(FINE_STEPS)
    if not isinstance(chosen, Auto):
        decides = build_model(device, chosen)
        return Survey(coarse, decides, decides, (middle, fine), finest, static)
    finer = Survey(coarse, finest, fine, (middle,), None, static)
    tolerance = chosen.tolerance
    return Survey(coarse, middle, middle, (coarse,), finest, static, (fine,), tolerance, finer)


def _of_laws(model, laws, static):
    """Return the survey of a model with laws, which is compared with itself in shorter steps."""
    if laws.force:
        device, (saddle, _, energy) = model.device, well_of(laws.force, model.device.beam.rise)
        # The largest force is about 1.5 times the mean.
        holds = 1.5 * energy / saddle + device.spring * (saddle + device.gap)
        static = holds / (device.mass + device.beam.weight / 2) / device.gravity
    half = model.with_step(FINE_STEPS)
    return Survey(model, model, model, (half,), half, static, lawful=True)


def build_adaptive(device: Device, tolerance: float = TOLERANCE, start: str = FIRST) -> Adaptive:
    """Build the levels in steps for a relative tolerance of thresholds; start: as in `Run`."""
    beam = device.beam
    uneven = np.not_equal(beam.cosine_4, 0) | np.not_equal(beam.cosine_5, 0)
    finer = uneven | (start != FIRST)

    def level(*rungs):
        def build(is_finer):
            return build_model(device, Cosines(modes=rungs[int(is_finer)]))

        return mixed(build, finer if rungs[0] != rungs[1] else False)

    levels = map(level, RUNGS, FINER_RUNGS)
    # The error of the scheme grows with the square of the step.
    return Adaptive(*levels).with_step(np.sqrt(tolerance / TOLERANCE))


def _near_changes(N, by_base, snapped):
    """Return which cells are near a change of label along N, of base or of the latest, (rows, n).

    N: ascending, in any unit; by_base, snapped: labels of base, and the latest
    """
    change, change_of_base = (labels[:, 1:] != labels[:, :-1] for labels in (snapped, by_base))
    ragged = (change.sum(axis=1) > 1) | (change_of_base.sum(axis=1) > 1)
    ragged |= _are_apart(N, by_base != snapped)
    near = _beside(N, change) | _beside(N, change_of_base)
    near[ragged] |= _around(N[ragged], (change | change_of_base)[ragged])
    return near


def _are_apart(N, differ):
    """Return in which rows the cells that differ extend over more than BESIDE in N, (rows,)."""
    rows, size = np.arange(len(N)), N.shape[1]
    first, last = np.argmax(differ, axis=1), size - 1 - np.argmax(differ[:, ::-1], axis=1)
    return differ.any(axis=1) & (N[rows, last] > BESIDE * N[rows, first])


def _beside(N, change):
    """Return cells, (rows, n), within REACH of changes, (rows, n - 1), and some within BESIDE."""
    near, size, distance = np.zeros(N.shape, bool), N.shape[1], 1
    while distance < size:
        below, above = change[:, distance - 1 :], change[:, : size - distance]
        if distance > REACH:
            below = below & (N[:, :-distance] * BESIDE >= N[:, distance - 1 : -1])
            above = above & (N[:, distance:] <= N[:, 1 : size - distance + 1] * BESIDE)
            if not (below.any() or above.any()):
                break
        near[:, :-distance] |= below
        near[:, distance:] |= above
        distance *= 2
    return near


def _around(N, change):
    """Return all cells, (rows, n), within FAR_BESIDE of changes, (rows, n - 1)."""
    near = np.zeros(N.shape, bool)
    above = np.where(change, N[:, 1:] * FAR_BESIDE, -np.inf)
    below = np.where(change, N[:, :-1] / FAR_BESIDE, np.inf)[:, ::-1]
    near[:, 1:] = N[:, 1:] <= np.maximum.accumulate(above, axis=1)
    near[:, :-1] |= N[:, :-1] >= np.minimum.accumulate(below, axis=1)[:, ::-1]
    return near

"""The model `auto`: several levels of models, and for each cell the cheapest that suffices."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Optional

import numpy as np

from ..beam.limit_loads import static_threshold
from ..device.device import Device
from .cells import Cells, Observations
from .laws import laws_of, well_of
from .models import Follows, build_model, check_options, mixed
from .settings import FIRST, Settings

RUNGS = (3, 5, 11)
"""Cosines of the levels: odd ones, as even ones do not move the midpoint."""
FINER_RUNGS = (5, 7, 11)
"""The same where three are blind: the way back hangs on where the beam is struck, and they lack
the cosines 4 and 5 of a shape as made."""
REACH = 2
"""Cells along N on either side of a change of label that are near it, however far apart."""
BESIDE, FAR_BESIDE = 1.02, 1.03
"""How far around a change of label finer levels look, in clean and ragged rows: in the latter at
every cell, in the former at REACH, and at twice, four times as many cells and so on."""
DISPUTED, AGREED, UNCOMPARED = range(3)
"""Whether two levels agree on a cell."""
FINE_STEPS = 0.5
"""Steps of the finest model over its usual ones, to decide fast thresholds and to see islands that
others miss."""
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
        """The device or batch of all three."""
        return self.base.device

    @property
    def levels(self) -> tuple[Follows, Follows]:
        """The two levels that decide cells."""
        return self.base, self.top

    def with_step(self, factor: float) -> "Adaptive":
        """Give the same levels with every step multiplied by `factor`."""
        return Adaptive(*(level.with_step(factor) for level in (self.base, self.check, self.top)))

    def pick(self, which: int | np.ndarray) -> "Adaptive":
        """Give the same levels of one device of the batch, or of several."""
        return Adaptive(*(level.pick(which) for level in (self.base, self.check, self.top)))

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow rows of cells along ascending N, (rows, n), each cell by the level that suffices.

        A cell is safe where base sees no change of label near it along N and its ledger closes.
        Near a change top decides, in ragged rows until it agrees with base for a stretch. Whether
        these cells snap is decided in the steps of a threshold.
        """
        # Of no cells: the kernel that takes longest to compile comes first, while a job of
        # thresholds beside this one compiles base's.
        none = cells.take(np.zeros(0, int)).flat()
        for _, model in self.top.split(none.device):
            model.follow_once(none, settings)
        observed = self.base.follow(cells, settings)
        by_base = np.isfinite(observed.t_snap)
        level = np.zeros(cells.f0.shape, np.int8)
        agreed = np.full(cells.f0.shape, UNCOMPARED, np.int8)
        unsafe = ~(observed.energy_error <= settings.energy_tolerance)
        unsafe[:, [0, -1]] = True  # what lies beyond the ends is unknown
        while True:
            unsafe |= _near_changes(cells.amplitude, by_base, np.isfinite(observed.t_snap))
            new = unsafe & (level == 0)
            if not new.any():
                return observed._replace(level=level, agreed=agreed)
            near = cells.take(new)
            check = self.check.follow(near, settings._replace(until="snap"))
            top = self.follow_by_top(near, settings)
            level[new] = 1
            same = np.isfinite(check.t_snap) == np.isfinite(top.t_snap)
            agreed[new] = np.where(same, AGREED, DISPUTED)
            observed.replace(new, top)

    def follow_by_top(self, cells: Cells, settings: Settings) -> Observations:
        """Follow cells, (cells,), near a change of label, in a threshold's steps to their snaps."""
        edge = self.top.follow(cells, settings._replace(until="edge"))
        if settings.until != "settled":
            return edge
        observed = self.top.follow(cells, settings)
        differ = np.isfinite(observed.t_snap) != np.isfinite(edge.t_snap)
        # The steps that the motion needs are shorter than those of either.
        moved = self.top.follow(cells.take(differ), settings._replace(until="moved"))
        observed.replace(differ, moved)
        return observed


class Survey(NamedTuple):
    """Models by which thresholds are determined.

    scans: the cheap one, which tells where to look; decides: at which N labels change
    ragged: decides where they change back and forth, in the steps of maps
    others: with which that is compared; of two, the second is better than the one that decides
    finest: the best, in steps that show what others miss; None where it decides
    static: threshold of slow pulses, about which to look, in multiples of g; (devices,)
    judges: finer ones, with which rows are compared, too
    finer: takes rows of fast pulses, and the clean ones that this one leaves open by more than
        tolerance, relative; None for no further look
    lawful: whether models have a user's own laws, of which no static threshold is known
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
        """This survey and the finer ones, by the `level` of their thresholds."""
        return self, *(self.finer.levels if self.finer else ())


def choose_model(device: Device, model: Mapping, start: str = FIRST) -> Follows | Adaptive:
    """Build a model, given by its name and options, for a device or a batch.

    start: as in `Settings`
    """
    if model["name"] == "auto":
        return _levels(device, start, **model)
    return build_model(device, **model)


def _levels(device, start, name, **options) -> Adaptive:
    check_options(device, name, options)
    return build_adaptive(device, start=start, **options)


def choose_survey(device: Device, model: Mapping, start: str = FIRST) -> Survey:
    """Build what finds the thresholds of a model, given by its name and options, for a batch.

    start: as in `Settings`
    """
    static = np.asarray(static_threshold(device, back=start != FIRST))
    if laws := laws_of(model):
        return _of_laws(build_model(device, **model), laws, static)
    is_auto = model["name"] == "auto"
    levels = _levels(device, start, **model) if is_auto else build_adaptive(device, start=start)
    coarse, middle, fine = levels.base, levels.check, levels.top
    finest = fine.with_step(FINE_STEPS)
    if not is_auto:
        decides = build_model(device, **model)
        return Survey(coarse, decides, decides, (middle, fine), finest, static)
    finer = Survey(coarse, finest, fine, (middle,), None, static)
    tolerance = model.get("tolerance", TOLERANCE)
    return Survey(coarse, middle, middle, (coarse,), finest, static, (fine,), tolerance, finer)


def _of_laws(model, laws, static):
    """The survey of a model with laws, which no other follows: by its own shorter steps."""
    if laws.force:
        device, (saddle, _, energy) = model.device, well_of(laws.force, model.device.beam.rise)
        # The largest force is about 1.5 times the mean.
        holds = 1.5 * energy / saddle + device.spring * (saddle + device.gap)
        static = holds / (device.mass + device.beam.weight / 2) / device.gravity
    half = model.with_step(FINE_STEPS)
    return Survey(model, model, model, (half,), half, static, lawful=True)


def build_adaptive(device: Device, tolerance: float = TOLERANCE, start: str = FIRST) -> Adaptive:
    """Build the levels, with steps for a tolerance of the threshold, relative.

    start: as in `Settings`
    """
    beam = device.beam
    uneven = np.not_equal(beam.cosine_4, 0) | np.not_equal(beam.cosine_5, 0)
    finer = uneven | (start != FIRST)

    def level(*rungs):
        def build(is_finer):
            return build_model(device, "cosines", modes=rungs[int(is_finer)])

        return mixed(build, finer if rungs[0] != rungs[1] else False)

    levels = map(level, RUNGS, FINER_RUNGS)
    # The scheme is of second order.
    return Adaptive(*levels).with_step(np.sqrt(tolerance / TOLERANCE))


def _near_changes(N, by_base, snapped):
    """Cells near a change of label along N, of those that base saw or of those known; (rows, n).

    N: ascending, in any unit
    """
    change, change_of_base = (labels[:, 1:] != labels[:, :-1] for labels in (snapped, by_base))
    ragged = (change.sum(axis=1) > 1) | (change_of_base.sum(axis=1) > 1)
    ragged |= _are_apart(N, by_base != snapped)
    near = _beside(N, change) | _beside(N, change_of_base)
    near[ragged] |= _around(N[ragged], (change | change_of_base)[ragged])
    return near


def _are_apart(N, differ):
    """Whether cells of a row differ that are farther apart than BESIDE, (rows,)."""
    rows, size = np.arange(len(N)), N.shape[1]
    first, last = np.argmax(differ, axis=1), size - 1 - np.argmax(differ[:, ::-1], axis=1)
    return differ.any(axis=1) & (N[rows, last] > BESIDE * N[rows, first])


def _beside(N, change):
    """Cells within REACH of changes, (rows, n - 1), and some more within BESIDE; (rows, n)."""
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
    """All cells within FAR_BESIDE of changes, (rows, n - 1); (rows, n)."""
    near = np.zeros(N.shape, bool)
    above = np.where(change, N[:, 1:] * FAR_BESIDE, -np.inf)
    below = np.where(change, N[:, :-1] / FAR_BESIDE, np.inf)[:, ::-1]
    near[:, 1:] = N[:, 1:] <= np.maximum.accumulate(above, axis=1)
    near[:, :-1] |= N[:, :-1] >= np.minimum.accumulate(below, axis=1)[:, ::-1]
    return near

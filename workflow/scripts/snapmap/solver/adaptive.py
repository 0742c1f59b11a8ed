"""The model `auto`: several levels of models, and for each cell the cheapest that suffices."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..beam.equilibria import static_threshold
from ..device import Device, batch
from .bracket import SCAN_STEP, lowest_snap
from .cells import Cells, Observations, to_rows
from .cost import steps_and_costs, tell
from .model import Follows, mix
from .models import RUNGS, build_model, check_options
from .settings import Settings

REACH = 2
"""Cells along N on either side of a change of label that count as near it."""
TOLERANCE = 1e-3
"""Error of the threshold that `auto` may make, relative, unless told."""
LONG_PULSES = np.array([0.1, 0.2, 0.4])
"""Frequencies, over the mass's own, at which levels are compared."""
REACHES, REFINED = (1.005, 1.05, 2.0, 30.0), 1e-5
"""How far from what is known thresholds are looked for, and how closely they are found."""
COMPARED, IN_TURN = 40, 800
"""Cells of each pulse that the choice of rungs takes, counted as the fourth rung's; and more of a
single device, as they run in turn."""


@dataclass(frozen=True, eq=False)
class Adaptive:
    """Three models of one device or a batch, ever finer.

    base labels every cell; those that are not safe are decided by top, and check says whether
    a second level agrees with it
    errors: of the threshold by base, check and top, relative, as seen against finer rungs; (3,), of
        a batch (devices, 3)
    """

    base: Follows
    check: Follows
    top: Follows
    errors: np.ndarray

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
        return self._each(lambda model: model.with_step(factor))

    def pick(self, which: int | np.ndarray) -> "Adaptive":
        """The same levels of one device of the batch, or of some."""
        if self.errors.ndim == 1:
            return self
        return replace(self._each(lambda model: model.pick(which)), errors=self.errors[which])

    def follow(self, cells: Cells, settings: Settings) -> Observations:
        """Follow rows of cells along ascending N, (rows, n), each cell by the level that suffices.

        A cell is safe where base sees no change of label within REACH along N and its ledger
        closes.
        """
        seen = self.base.follow(cells, settings)
        level, agreed = np.zeros(cells.f0.shape, np.int8), np.ones(cells.f0.shape, np.int8)
        unsafe = ~(seen.energy_error <= settings.energy_tolerance)
        unsafe[:, [0, -1]] = True  # what lies beyond the ends is unknown
        while True:
            unsafe |= _near_change(np.isfinite(seen.t_snap))
            new = unsafe & (level == 0)
            if not new.any():
                return seen._replace(level=level, agreed=agreed)
            check = self.check.follow(cells.some(new), settings)
            top = self.top.follow(cells.some(new), settings)
            level[new] = 1
            agreed[new] = np.isfinite(check.t_snap) == np.isfinite(top.t_snap)
            seen.replace(new, top)

    def _each(self, change):
        changed = {name: change(getattr(self, name)) for name in ("base", "check", "top")}
        return replace(self, **changed)


class Survey(NamedTuple):
    """Models by which thresholds are found: scans is cheap, and doubts has another opinion.

    better: than the one that decides; None where that is the best
    static: threshold of slow pulses, about which to look, in multiples of g; (devices,)
    """

    scans: Follows
    decides: Follows
    doubts: Follows
    better: Follows | None
    static: np.ndarray


def choose_model(
    device: Device, model: Mapping, threads: int = 1, static: np.ndarray | None = None
) -> Follows:
    """Build a model, given by its name and options, for a device or a batch.

    static: threshold of slow pulses, if known; (devices,)
    """
    options = {key: value for key, value in model.items() if key != "name"}
    if model["name"] != "auto":
        return build_model(device, **model)
    check_options(device, "auto", options)
    tell_choice(device, threads)
    adaptive = build_adaptive(device, **options, threads=threads, static=static)
    _tell_of_errors(adaptive, options.get("tolerance", TOLERANCE))
    return adaptive


def choose_survey(device: Device, model: Mapping, threads: int = 1) -> Survey:
    """Build what finds the thresholds of a model, given by its name and options, for a batch."""
    static = static_threshold(device)
    chosen = choose_model(device, model, threads, static)
    if model["name"] == "auto":
        return Survey(chosen.base, chosen.top, chosen.check, None, static)
    tell_choice(device, threads)
    levels = build_adaptive(device, threads=threads, static=static)
    return Survey(levels.base, chosen, levels.check, levels.top, static)


def build_adaptive(
    device: Device,
    tolerance: float = TOLERANCE,
    threads: int = 1,
    static: np.ndarray | None = None,
) -> Adaptive:
    """Choose the rungs for each device by their thresholds.

    tolerance: of the threshold, relative; check is the first rung that keeps it, top the next, or
        the last two, whose errors tell, where none does
    static: threshold of slow pulses, if known; (devices,)
    """
    devices = batch([device]) if np.ndim(device.mass) == 0 else device
    undecided, built = np.arange(len(devices)), []
    near = np.atleast_1d(static_threshold(devices) if static is None else static)
    near = np.repeat(near[:, np.newaxis], LONG_PULSES.size, axis=1)
    thresholds = np.empty((len(devices), 0, LONG_PULSES.size))
    errors, parts = np.empty((len(devices), 3)), []
    for modes in RUNGS:
        built.append(build_model(devices.pick(undecided), "cosines", modes=modes))
        found = _thresholds(built[-1], near, REACHES[len(built) == 1 :], threads)
        seen = _differences(thresholds, found)
        thresholds = np.concatenate([thresholds, found[:, np.newaxis]], axis=1)
        near = np.where(np.isfinite(found), found, near)
        if len(built) < 4:
            continue
        done = seen[:, -2] < tolerance
        if done.any():
            errors[undecided[done]] = seen[done][:, [0, -2, -1]]
            parts.append((undecided[done], *(model.pick(done) for model in built[-3:-1])))
        undecided, thresholds, seen = undecided[~done], thresholds[~done], seen[~done]
        near = near[~done]
        built = [model.pick(~done) for model in built]
        if not undecided.size:
            break
    else:
        errors[undecided] = seen[:, [0, -1, -1]]
        parts.append((undecided, *built[-2:]))
    check, top = (mix(devices, [(part[0], part[i]) for part in parts]) for i in (1, 2))
    adaptive = Adaptive(build_model(devices, "cosines", modes=RUNGS[0]), check, top, errors)
    return adaptive if devices is device else adaptive.pick(0)


def tell_choice(device: Device, threads: int = 1) -> None:
    """Warn of a long choice of levels before it begins; a ValueError refuses one without end."""
    devices = batch([device]) if np.ndim(device.mass) == 0 else device
    own = devices.own_frequency
    lasts = 2 * np.pi / own * np.sum(1 / LONG_PULSES)
    # At least four rungs are compared; the fourth takes most of the time.
    cost = steps_and_costs(build_model(devices, "cosines", modes=RUNGS[3]))[1] * lasts
    seconds = COMPARED * cost.sum() / threads + IN_TURN * cost.max()
    slowest = f"a device with a period of {2e-6 * np.pi / own[np.argmax(cost)]:.3g} s"
    tell("model: choosing its levels", seconds, slowest, "write a stiffer spring", stacklevel=4)


def _tell_of_errors(adaptive, tolerance):
    """Warn where no rung keeps the tolerance."""
    errors = np.atleast_2d(adaptive.errors)[:, 1:].max(axis=1)
    if many := np.count_nonzero(errors >= tolerance):
        warnings.warn(
            f"model.tolerance: {tolerance:g} is not kept on {many} of {errors.size} devices; "
            f"{RUNGS[-1]} cosines are off by up to {errors.max():.1g}",
            stacklevel=3,
        )


def _differences(coarser, fine):
    """Largest relative difference of each rung's thresholds from the finest's, (devices, rungs).

    No less than what the thresholds are refined to; inf where there are none to compare.
    """
    with np.errstate(invalid="ignore"):
        apart = abs(coarser / fine[:, np.newaxis] - 1)
    known = np.isfinite(apart)
    largest = np.max(apart, axis=-1, initial=REFINED, where=known)
    return np.where(known.any(axis=-1), largest, np.inf)


def _thresholds(model, near, reaches, threads):
    """Thresholds under pulses longer than the mass's own period, where they are smooth in f0.

    near: about where to look, (devices, pulses); reaches: within these factors of it, in turn
    """
    device = model.device
    # ASSUME: a rung's error in three long versed sines stands for its error everywhere else.
    f0 = np.multiply.outer(device.own_frequency / (2 * np.pi) * 1e6, LONG_PULSES)
    damping = np.repeat(0.2 * np.sqrt(device.spring * device.mass), LONG_PULSES.size)
    which = np.repeat(np.arange(len(device)), LONG_PULSES.size)
    rows = to_rows(which, f0.ravel(), damping)
    settings = Settings(horizon=0.0, threads=threads)
    found, near = np.full(near.size, np.nan), near.ravel()
    for reach in reaches:
        left = np.flatnonzero(np.isnan(found))
        bracket = near[left] / reach, near[left] * reach
        step = min(SCAN_STEP, reach - 1)
        found[left] = lowest_snap(model, rows.some(left), bracket, settings, REFINED, step)
    return found.reshape(-1, LONG_PULSES.size)


def _near_change(snapped):
    """Cells within REACH of a change of label along N; (rows, n)."""
    near = np.zeros(snapped.shape, bool)
    for shift in range(1, min(REACH, snapped.shape[1] - 1) + 1):
        differ = snapped[:, shift:] != snapped[:, :-shift]
        near[:, shift:] |= differ
        near[:, :-shift] |= differ
    return near

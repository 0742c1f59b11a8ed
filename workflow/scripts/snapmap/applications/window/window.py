"""Reserves of required shocks over axes of device and damper, and the yield."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ...beam.stress import break_probability
from ...device.samples import Plan, Tolerances
from ...files.text import plain
from ...numerics.statistics import share_bounds
from ...solver.cells import to_rows
from ...solver.motion import largest_stress
from ...study.axes import KIND_OF, TEMPERATURE, Units, rows_of
from ...study.shock import Shock
from ...study.study import ANY, OF_THRESHOLDS, SNAPS, Study
from ...study.variables import dress
from ...thresholds.population import Batch, choose_levels
from ...thresholds.surface import first_snaps
from ...thresholds.survey import NOTHING_SNAPS
from .between import FAR, between, least_reserve, reserves_between


def window_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    requirements: Sequence[Shock],
    tolerances: Tolerances | None = None,
) -> xr.Dataset:
    """Find the thresholds and reserves of required shocks over axes.

    axes: values of the device, internal units, and C, uN us/um; of several temperatures, which no
        design chooses, the worst counts for each requirement
    requirements: of several shocks the worst counts
    Variables are N_first and N_error, multiples of g, and reserve, a factor, (requirement, *axes);
    with a strength stress_max, MPa, too; with tolerances yield, (*axes), and its bounds: the share
    of devices that meet all requirements at all temperatures.
    """
    windows, thresholds = [], {}
    for required in requirements:
        shaken, f0, under = required.shaken(study), required.f0, []
        for shocks in shaken.shocks.each():
            single = shaken.under(shocks)
            pulse = shocks.pulses[0].pieces.tobytes(), shaken.run, f0
            if pulse not in thresholds:
                surface = first_snaps(single, {**axes, "f0": [f0]})
                thresholds[pulse] = surface.squeeze("f0", drop=True)
            under.append(_under_shock(single, axes, required, thresholds[pulse]))
        windows.append(_worst(under))
    design, document = windows[0].reserve.dims, study.document(OF_THRESHOLDS)
    names = [required.name for required in requirements]
    window = xr.concat(windows, xr.Variable("requirement", names))
    if tolerances:
        least, most = _count_meeting(study, axes, requirements, tolerances)
        window["yield"] = design, (least + most) / (2 * tolerances.samples)
        low, high = (share_bounds(count, tolerances.samples) for count in (least, most))
        window["yield_bound"] = ("bound", *design), np.stack([low[0], high[1]])
        window = window.assign_coords(bound=["low", "high"])
        document["tolerances"] = tolerances.section
    temperatures = {"temperatures": axes[TEMPERATURE]} if _varies(axes) else {}
    window["reserve"].attrs["off_between_points"] = _off_between(window.reserve.values)
    return dress("window", window, document, **temperatures)


def _varies(axes):
    """Whether the axes have several temperatures."""
    return len(axes.get(TEMPERATURE, ())) > 1


def _off_between(reserve):
    """Bound of the interpolation error of reserves, by their second differences."""
    reserve = np.clip(reserve, 1 / FAR, FAR)
    second = (np.diff(reserve, n=2, axis=axis) for axis in range(1, reserve.ndim))
    return float(sum(np.nanmax(abs(difference), initial=0) / 8 for difference in second))


def _worst(under):
    """Choose the shock of the least reserve of a requirement, and the largest stress under all."""
    if len(under) == 1:
        return under[0]
    every = xr.concat(under, "shock")
    worst = every.isel(shock=every.reserve.fillna(np.inf).argmin("shock"))
    if "stress_max" in every:
        worst["stress_max"] = every.stress_max.max("shock")
    return worst


def _under_shock(study, axes, required, thresholds):
    """The reserve of a requirement under one shock, and the stress; thresholds: of its pulse."""
    N, survives = required.N, required.survives
    thresholds = thresholds.drop_attrs()
    first = thresholds.N_first.where(thresholds.status != NOTHING_SNAPS, np.inf)
    window = thresholds[["N_first", "N_error"]]
    window["reserve"] = N / first if required.snaps else first / N
    if required.snaps == ANY:
        window["reserve"] = xr.full_like(first, np.inf).where(first.notnull())
    window["N_required"], window["must_snap"] = N, np.int8(SNAPS[required.snaps])
    grid = study.set_out({**axes, "f0": [required.f0]})
    if np.isfinite(grid.device.strength).any():
        rows, stress = rows_of(grid), np.full(window.reserve.shape, np.nan)
        rows = rows.take(exists := rows.device >= 0)
        cells = rows.cells(grid.device, N, study.horizon).flat()
        largest = largest_stress(grid.device, study.model, cells, study.run)
        broken = break_probability(grid.device.pick(cells.device), largest) > 1 - survives
        stress.flat[exists] = largest
        window.reserve.values.flat[np.flatnonzero(exists)[broken]] = 0.0
        window["stress_max"] = tuple(axes), stress
    if not _varies(axes):
        return window
    # An unknown reserve counts as 1, between met and failed.
    worst = window.reserve.fillna(1.0).argmin(TEMPERATURE)
    at_worst = window.isel({TEMPERATURE: worst}).reset_coords(TEMPERATURE)
    if "stress_max" in window:
        at_worst["stress_max"] = window.stress_max.max(TEMPERATURE)
    return at_worst


def _count_meeting(study, axes, requirements, tolerances):
    """Count samples that surely and possibly meet all requirements, (2, *axes)."""
    grid, C, start = study.set_out(axes), np.asarray(axes["C"]), study.start
    pulses = [pulse for required in requirements for pulse in required.shocks.pulses]
    f0 = np.array([required.f0 for required in requirements for _ in required.shocks.pulses])
    # ASSUME: a model that suffices at both ends of C suffices between them.
    rows = to_rows(0, f0, C[[0, -1], np.newaxis], np.arange(f0.size), pulses)
    choices = choose_levels(study.device, study.model, rows, study.run)
    meets = np.zeros((*grid.device_of.shape, C.size, 2, tolerances.samples), bool)
    for place, number in np.ndenumerate(grid.device_of):
        if number < 0:
            continue
        device = grid.device.pick(number)
        plan = Plan(device, tolerances.scatters, tolerances.together)
        values = plan.values(plan.points(tolerances.samples, tolerances.seed)[0])
        batch, meets[place] = Batch(device, values, study.model, choices, start), True
        for required in requirements:
            settings = required.shaken(study).run
            for pulse in required.shocks.pulses:
                rows = to_rows(0, required.f0, C, 0, [pulse])
                meets[place] &= batch.meets(required, rows, settings).transpose(2, 0, 1)
    if _varies(axes):
        meets = meets.all(axis=list(axes).index(TEMPERATURE))
    return np.moveaxis(meets.sum(axis=-1), -1, 0)


def summary(window: xr.Dataset, units: Units) -> str:
    """Write in a line where all requirements are met, the widest margin, and the yield there.

    window: as `window_of` returns it, over two axes of several values; units: of the axes
    """
    window = window.squeeze([key for key in window.reserve.dims[1:] if window.sizes[key] == 1])
    axes, reserve = window.reserve.dims[1:], window.reserve.values
    met, least = least_reserve(reserve) >= 1, least_reserve(reserves_between(reserve))
    words = f"thresholds on the right side of all requirements at {met.sum()} of {met.size} points"
    if not np.isfinite(least).any():
        return f"{words}; nothing else is known"
    if not np.isfinite(window.N_first).any():
        return f"{words}; nothing snaps at any"
    words += f", by interpolation on {np.mean(least >= 1):.1%} of the plane; the widest margin, "
    best = np.unravel_index(np.nanargmax(least), least.shape)
    if least[best] >= FAR:
        far = np.mean(least >= FAR)
        return f"{words}a factor over {FAR:g}, is that of {far:.1%} of the plane"
    where = []
    for key, place in zip(axes, best, strict=True):
        unit, size = units.get(key, (KIND_OF[key].unit, 1.0))
        value = between(window[key].values, 1)[place]
        where.append(f"{key} = {plain(value / size, 6)} {unit}".strip())
    words += f"a factor of {plain(least[best], 4)}, is at {', '.join(where)}"
    meeting = between(window["yield"].values)[best] if "yield" in window else np.nan
    return f"{words}, yield {meeting:.1%}" if np.isfinite(meeting) else words

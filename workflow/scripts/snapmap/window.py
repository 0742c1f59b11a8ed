"""Where on the axes of device and damper requirements are met, by how much, and the yield."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from .axes import point_text
from .beam.stress import break_probability
from .io.variables import dress
from .motion.envelopes import largest_stress
from .quantities import plain
from .solver.cells import rows_of, to_rows
from .study import ANY, SNAPS, THRESHOLD_SETTINGS, Study, of_requirement
from .thresholds.islands import NOTHING_SNAPS
from .thresholds.surface import thresholds_of
from .tolerances.batch import Batch, choose_levels
from .tolerances.samples import Plan, Tolerances
from .tolerances.statistics import wilson


def window_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    requirements: Sequence[Mapping],
    tolerances: Tolerances | None = None,
) -> xr.Dataset:
    """Find the thresholds of required shocks over axes, and how far each N is on its right side.

    axes: values of the device, internal units, and C, uN us/um
    requirements: name, shocks, N, f0 (Hz), snaps, survives of each, which holds under all its
        shocks: the variables are those of the worst
    Variables: N_first and N_error, multiples of g, and reserve, a factor, (requirement, *axes); of
    devices with a strength stress_max, MPa; with tolerances yield, (*axes), with its bounds.
    """
    each, thresholds = [], {}
    for required in requirements:
        own, f0, under = of_requirement(study, required), required["f0"], []
        for shocks in own.shocks.each():
            shaken = replace(own, shocks=shocks)
            pulse = shocks.pulses[0].pieces.tobytes(), own.settings, f0
            if pulse not in thresholds:
                seen = thresholds_of(shaken, {**axes, "f0": [f0]})
                thresholds[pulse] = seen.squeeze("f0", drop=True)
            under.append(_of_one(shaken, axes, required, thresholds[pulse]))
        each.append(_worst(under))
    names, document = [one["name"] for one in requirements], study.document(THRESHOLD_SETTINGS)
    found = xr.concat(each, xr.Variable("requirement", names))
    if tolerances:
        count = _good(study, axes, requirements, tolerances)
        found["yield"] = tuple(axes), count / tolerances.samples
        found["yield_bound"] = ("bound", *axes), np.stack(wilson(count, tolerances.samples))
        found = found.assign_coords(bound=["low", "high"])
        document["tolerances"] = tolerances.section
    return dress("window", found, document)


def _worst(under):
    """Of one requirement under several shocks that of the least reserve, and the largest stress."""
    if len(under) == 1:
        return under[0]
    every = xr.concat(under, "shock")
    worst = every.isel(shock=every.reserve.fillna(np.inf).argmin("shock"))
    if "stress_max" in every:
        worst["stress_max"] = every.stress_max.max("shock")
    return worst


def _of_one(study, axes, required, thresholds):
    """How far one requirement is met, by the thresholds of its pulse, and the largest stress."""
    N, survives = required["N"], required["survives"]
    first = thresholds.N_first.where(thresholds.status != NOTHING_SNAPS, np.inf)
    found = thresholds[["N_first", "N_error"]].drop_attrs()
    found["reserve"] = N / first if required["snaps"] else first / N
    if required["snaps"] == ANY:
        found["reserve"] = xr.full_like(first, np.inf).where(first.notnull())
    found["N_required"], found["must_snap"] = N, np.int8(SNAPS[required["snaps"]])
    grid = study.set_out({**axes, "f0": [required["f0"]]})
    if np.isfinite(grid.device.strength).any():
        rows, stress = rows_of(grid), np.full(found.reserve.shape, np.nan)
        rows = rows.take(there := rows.device >= 0)
        cells = rows.cells(grid.device, N, study.settings.horizon).flat()
        stress.flat[there] = most = largest_stress(study, grid.device, cells)
        broken = break_probability(grid.device.pick(cells.device), most) > 1 - survives
        found.reserve.values.flat[np.flatnonzero(there)[broken]] = 0.0
        found["stress_max"] = tuple(axes), stress
    return found


def _good(study, axes, requirements, tolerances):
    """How many samples of the device at each point of the axes meet all requirements."""
    grid, settings, C = study.set_out(axes), study.settings, np.asarray(axes["C"])
    pulses = [pulse for required in requirements for pulse in required["shocks"].pulses]
    f0 = np.array([one["f0"] for one in requirements for _ in one["shocks"].pulses])
    # ASSUME: the model that suffices at both ends of C does so between them.
    rows = to_rows(0, f0, C[[0, -1], np.newaxis], np.arange(f0.size), pulses)
    choices = choose_levels(study.device, study.model, rows, settings)
    count = np.zeros((*grid.device_of.shape, C.size))
    for place, number in np.ndenumerate(grid.device_of):
        if number < 0:
            continue
        device = grid.device.pick(number)
        plan = Plan(device, tolerances.scatters, tolerances.together)
        values = plan.values(plan.points(tolerances.samples, tolerances.seed)[0])
        batch, good = Batch(device, values, study.model, choices, settings.start), True
        for required in requirements:
            own = of_requirement(study, required).settings
            for pulse in required["shocks"].pulses:
                good &= batch.meets(required, to_rows(0, required["f0"], C, 0, [pulse]), own)
        count[place] = good.sum(axis=0)
    return count


def summary(found: xr.Dataset) -> str:
    """One line: at how many points all are met, and where by the widest margin, with the yield."""
    least = found.reserve.min("requirement")
    at = least.fillna(0).argmax(...)
    best, met = found.isel(at), int((least >= 1).sum())
    where = point_text({key: best[key].item() for key in least.dims})
    words = f"all requirements met at {met} of {least.size} points; the widest margin, a factor of "
    words += f"{plain(least.isel(at).item(), 4)}, is at {where}"
    return words + (f", yield {best['yield'].item():.1%}" if "yield" in found else "")

"""The variables of a cube: rows of cells along N are followed and labelled."""

from collections.abc import Callable, Sequence

import numpy as np

from ..pulse.pulse import blow_at
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.outcome import ABSENT, FAILED, REPEATED_STEP, label, t_snap_error, work_error
from ..solver.settings import FIRST, Run

Observers = Sequence[Callable]
"""Functions of model, cells, observations and settings that give further variables by name."""
ABSENCE = {
    "outcome": ABSENT,
    **dict.fromkeys(("well", "halvings", "level", "blow"), 0),
    **dict.fromkeys(("agreed", "reproduced", "well_reproduced"), 1),
}
"""Values of variables where there is no device; NaN for all others."""


def follow_rows(
    model: Follows, rows: Rows, N: Sequence[float], settings: Run, observers: Observers = ()
) -> dict[str, np.ndarray]:
    """Follow rows of cells through all N; returns the variables of a cube by name, (rows, N)."""
    exists, N = rows.device >= 0, np.asarray(N)
    order = np.argsort(N, kind="stable")
    cells = rows.take(exists).cells(model.device, N[order], settings.horizon)
    first = model.follow(cells, settings)
    variables = _variables(first, settings)
    if settings.repeats:
        again = model.with_step(REPEATED_STEP).follow(cells, settings)
        variables |= _repeated(variables, _variables(again, settings))
        for compare in (work_error, t_snap_error):
            variables[compare.__name__] = compare(first, again).astype(np.float32)
    for observe in observers:
        variables |= observe(model, cells, first, settings)
    if any(pulse.blows.size for pulse in rows.pulses):
        variables["blow"] = blow_at(rows.pulses, cells.pulse, first.t_snap * cells.f0)
    for key, values in variables.items():
        variables[key] = np.full((exists.size, N.size), ABSENCE.get(key, np.nan), values.dtype)
        variables[key][np.ix_(exists, order)] = values
    return variables


def _variables(runs, settings):
    """Give the variables of cells, by name, that one run of each determines."""
    names = "t_snap", "t_settled", "energy_error", "pulse_work", "halvings", "level", "agreed"
    variables = {"outcome": label(runs, settings.energy_tolerance)}
    variables |= {name: getattr(runs, name) for name in names}
    variables["pulse_work"] = runs.pulse_work.astype(np.float32)
    if settings.until == "settled":
        failed = variables["outcome"] == FAILED
        well = runs.well if settings.start == FIRST else np.where(runs.well, 3 - runs.well, 0)
        variables["well"] = np.where(failed, 0, well).astype(np.int8)
        variables["well_share"] = np.where(failed, np.nan, runs.well_share).astype(np.float32)
    return {key: values for key, values in variables.items() if values is not None}


def _repeated(first, again):
    """Compare two runs of cells; returns variables that tell where they agree."""
    same = again["outcome"] == first["outcome"]
    variables = {"reproduced": same.astype(np.int8)}
    if "well" in first:
        snapped = [np.isfinite(run["t_snap"]) for run in (first, again)]
        # Where a run tells no well, its label is compared.
        same = (again["well"] == first["well"]) & ((first["well"] != 0) | np.equal(*snapped))
        variables["well_reproduced"] = same.astype(np.int8)
    return variables

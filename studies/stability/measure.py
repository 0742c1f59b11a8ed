"""Follow every hard case with every model at many steps, and judge the runs."""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product

import numpy as np
import xarray as xr

from snapmap.device.device import Device
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.options import Chosen
from snapmap.solver.outcome import FAILED, label
from snapmap.solver.settings import Run
from snapmap.solver.steps import stability_limit
from snapmap.thresholds.probe import Probe, lowest_snap

from ..common import bending_limit, stepped
from .cases import APART, CASES, MODELS, Case, changed
from .verdicts import LEFT_OUT, NO_RUNS, REFUSED, Runs, judge, snap_shift

STEPS = (0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.05)
FINE_STEPS = (0.1, 0.075)
SEARCHED = (300.0, 3000.0)
"""Range of the search for the threshold, multiples of g."""
BUDGET = 18.0
"""Most time for all steps of a case, s, else only the default step runs; a case whose default step
takes an eighth of it is left out."""


def measure(
    device: Device,
    cases: Sequence[Case] = CASES,
    models: Mapping[str, Chosen] = MODELS,
    steps: Sequence[float] = STEPS,
) -> xr.Dataset:
    """Follow every case with every model at every step.

    models: by label; steps: shares of the stability limit
    Over case, model and step are `outcome` of the first cell, and the worst of all cells:
    `energy_error` (inf: blew up), `snap_shift` (relative), `verdict`. The variables default_* are
    those of a sweep, which takes the default step, and halves it (`halvings`, -1: not run) if a
    ledger does not close. `limit` is the stability limit, us.
    """
    pairs = product(cases, models.values())
    measured = [measure_pair(device, case, chosen, steps) for case, chosen in pairs]
    axes = {"case": [case.name for case in cases], "model": list(models), "step": list(steps)}
    data = {}
    for name in measured[0]:
        column = np.array([pair[name] for pair in measured])
        shape = (len(cases), len(models), *column.shape[1:])
        data[name] = tuple(axes)[: len(shape)], column.reshape(shape)
    return xr.Dataset(data, axes, {"title": "Hard cases"})


def measure_pair(
    device: Device, case: Case, chosen: Chosen, steps: Sequence[float]
) -> dict[str, object]:
    """Follow one case with one model; returns values by the names of the dataset.

    steps: shares of its stability limit
    A list holds a value for each step.
    """
    device = changed(device, case)
    try:
        model = build_model(device, chosen)
    except ValueError:
        return _blank(steps, REFUSED)
    is_plain = model.name == "reference"
    limit = stability_limit(device, model.modal) if is_plain else bending_limit(model)
    default = _default_step(device, model, case)
    values = _blank(steps, LEFT_OUT) | {"limit": limit, "default_step": default / limit}
    search = [FINE_STEPS[0] * limit] * 4 * case.of_threshold  # a dozen runs, over at the snap
    if _seconds(model, case, [default, *search]) > BUDGET / 8:
        return values
    return values | _follow(case, model, limit, steps)


def _default_step(device, model, case):
    """The default step of a sweep for the case, us."""
    cells, settings = to_cells(device, [0], 0.0, case.f0, case.C, case.horizon), Run()
    return model.steps.of(cells, settings.question).item()


def _follow(case, model, limit, steps):
    """Values at the default step, and also at all steps unless that takes too long."""
    cells, settings = _cells(model, case, limit), Run(horizon=case.horizon)

    @cache
    def follow_at(dt):
        return _to_runs(stepped(model, dt).follow_once(cells, settings))

    fine, values = NO_RUNS, {}
    if _seconds(model, case, limit * np.array([*FINE_STEPS, *steps])) < BUDGET:
        fine = Runs(*np.hstack([follow_at(step * limit) for step in FINE_STEPS]))
        at_steps = [_summary(follow_at(step * limit), fine) for step in steps]
        values = {key: [summary[key] for summary in at_steps] for key in at_steps[0]}
    observed = model.follow(cells, settings)
    at_default = _summary(_to_runs(observed), fine)
    values |= {f"default_{key}": value for key, value in at_default.items()}
    return values | {"halvings": observed.halvings.max()}


def _seconds(model, case, steps):
    """Expected time of the runs at some steps, us, in s; it decides what is left out."""
    nanoseconds = 40 * LANES if model.name == "reference" else 60 + model.modes**2
    duration = 1e6 / case.f0 + case.horizon
    groups = np.ceil(case.cells / LANES)
    return float(np.sum(duration / np.array(steps)) * groups * nanoseconds * 1e-9)


def _cells(model, case, limit):
    N = case.N
    if case.of_threshold:
        fine = stepped(model, FINE_STEPS[0] * limit)
        row, settings = to_rows(0, case.f0, case.C), Run(horizon=300.0)
        N *= lowest_snap(Probe(fine, row, settings), SEARCHED, tolerance=10 * APART)[0]
    copies = N * (1 - APART * np.arange(case.cells))
    return to_cells(model.device, 0, copies, case.f0, case.C, case.horizon)


def _to_runs(observed):
    outcome = label(observed, Run().energy_tolerance)
    return Runs(outcome, observed.t_snap, observed.t_settled, observed.energy_error)


def _blank(steps, verdict):
    """Values of a case that is not run; the verdict tells why."""
    blank = {"outcome": FAILED, "energy_error": np.nan, "snap_shift": np.nan, "verdict": verdict}
    at_steps = {key: [value] * len(steps) for key, value in blank.items()}
    default = {f"default_{key}": value for key, value in blank.items()}
    return {"limit": np.nan, "default_step": np.nan, "halvings": -1, **at_steps, **default}


def _summary(runs, fine):
    """The outcome of the first cell, and the worst energy error, shift and verdict of all."""
    return {
        "outcome": runs.outcome[0],
        "energy_error": np.nan_to_num(runs.energy_error, nan=np.inf).max(),
        "snap_shift": np.fmax.reduce(snap_shift(runs, fine)),
        "verdict": judge(runs, fine).max(),
    }

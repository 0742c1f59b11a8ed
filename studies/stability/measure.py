"""Follow every hard case with every model at many steps, and judge the runs."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
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
from snapmap.study.variables import flags, variables
from snapmap.thresholds.probe import Probe, lowest_snap

from ..common import bending_limit, stepped
from .cases import APART, CASES, MODELS, Case, changed
from .verdicts import LEFT_OUT, NO_RUNS, REFUSED, VERDICTS, Runs, judge, snap_shift

STEPS = (0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.05)
FINE_STEPS = (0.1, 0.075)
SEARCHED = (300.0, 3000.0)
"""Range of the search for the threshold, multiples of g."""
BUDGET = 18.0
"""Most time for all steps of a case, s, else only the default step runs; a case whose default step
takes an eighth of it is left out."""
VARIABLES = {
    "limit": {"long_name": "stability limit of the time step", "units": "us"},
    "outcome": {**variables("cube")["outcome"], "long_name": "outcome of the case's first cell"},
    "energy_error": {
        "long_name": "largest residual of an energy ledger over the gross work of the pulse",
        "units": "1",
        "comment": "inf: a run blew up; NaN: not run",
    },
    "snap_shift": {
        "long_name": "largest difference of a believed snap time from the fine runs', over it",
        "units": "1",
        "comment": "NaN: there are none to compare",
    },
    "verdict": {"long_name": "verdict on the worst of the case's cells", **flags(VERDICTS)},
    "step": {"long_name": "time step over the stability limit", "units": "1"},
    "halvings": {
        "long_name": "how often the default step was halved until every ledger closed",
        "units": "1",
        "comment": "-1: not run",
    },
}


def measure(
    device: Device,
    cases: Sequence[Case] = CASES,
    models: Mapping[str, Chosen] = MODELS,
    steps: Sequence[float] = STEPS,
    threads: int = 1,
) -> xr.Dataset:
    """Follow every case with every model at every step.

    models: by label; steps: shares of the stability limit
    The variables default_* are those of a sweep, which takes the default step, and halves it if a
    ledger does not close.
    """
    pairs = list(product(cases, models.values()))
    with ThreadPoolExecutor(threads) as pool:
        measured = list(pool.map(lambda pair: measure_pair(device, *pair, steps), pairs))
    values = {key: np.array([pair[key] for pair in measured]) for key in measured[0]}
    return dress(cases, models, steps, values)


def dress(
    cases: Sequence[Case],
    models: Mapping[str, Chosen],
    steps: Sequence[float],
    values: Mapping[str, np.ndarray],
) -> xr.Dataset:
    """Make a dataset of values with axes and CF attributes.

    values: by name, of all pairs of case and model, cases first, (pairs,) or (pairs, steps)
    """
    axes = {"case": [case.name for case in cases], "model": list(models), "step": list(steps)}
    data = {}
    for name, column in values.items():
        shape = (len(cases), len(models), *column.shape[1:])
        dtype = float if column.dtype.kind == "f" else np.int8
        attributes = VARIABLES[name.removeprefix("default_")]
        data[name] = (tuple(axes)[: len(shape)], column.reshape(shape).astype(dtype), attributes)
    return xr.Dataset(data, axes).assign_attrs(Conventions="CF-1.11", title="Hard cases")


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
    cells, settings = _cells(model, case, limit), Run(case.horizon)

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

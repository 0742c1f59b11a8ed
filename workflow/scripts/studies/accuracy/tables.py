"""The tables of docs/accuracy.md."""

import numpy as np
import xarray as xr

from snapmap.io.markdown import DASH, number, table

from .cases import FAMILIES, MODELS
from .figures import of_family

COLUMNS = {
    "threshold_worst": "threshold",
    "t_snap_worst": "$t_{\\rm snap}$",
    "label_error": "labels, all",
    "label_error_in_pulse": "labels, in the pulse",
}
"""Errors, and how columns name them."""


def tables(found: xr.Dataset) -> str:
    """What is converged, the models and the other sources of error, as Markdown."""
    made = [converged_table(found), cases_table(found, MODELS)]
    made.append(cases_table(found, FAMILIES[len(MODELS) :]))
    return "\n".join([f"Only {found.left_out}.\n"] * bool(found.left_out) + made)


def converged_table(found: xr.Dataset) -> str:
    """The converged thresholds and their own errors; in italics what is not well posed."""
    head = ["pulse", "direction", "$f_0$, Hz", "$C$"]
    for name in found.reference.values:
        head += [str(name), "own error", "elements", "own error"]
    rows = []
    for i in range(found.sizes["row"]):
        row = found.isel(row=i)
        cells = [str(row["shape"].values), str(row.direction.values)]
        cells += [number(row.f0.item()), number(row.C.item())]
        for j in range(found.sizes["reference"]):
            cells += _converged(row.isel(reference=j))
        rows.append(cells)
    return table(head, rows)


def _converged(run):
    mark = "" if run.threshold_decided else "*"
    models = "converged", "elements"
    pairs = [(f"{model}_threshold", f"{model}_threshold_error") for model in models]
    return [
        f"{mark}{run[key].item():.{digits}g}{mark}" if np.isfinite(run[key]) else DASH
        for pair in pairs
        for key, digits in zip(pair, (7, 2), strict=True)
    ]


def cases_table(found: xr.Dataset, families) -> str:
    """Errors and times of the cases of some families; bold on the Pareto front."""
    head = ["", *COLUMNS.values(), "us per simulation", "simulations/s"]
    rows = []
    for cases in (of_family(found, family) for family in families):
        for i in range(cases.sizes["model"]):
            case = cases.isel(model=i)
            bold = "**" * int(case.on_front)
            errors = [_percent(case[key].item()) for key in COLUMNS]
            speed = [case.time_per_simulation.item(), case.simulations_per_second.item()]
            rows.append([f"{bold}{case.model.item()}{bold}", *errors, *map(number, speed)])
    return table(head, rows)


def _percent(error):
    return f"{100 * error:.2g} %" if np.isfinite(error) else DASH

"""The report as an xarray dataset: every case held against its reference."""

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from snapmap.axes import COORDINATES, PULSE_AXES
from snapmap.solver.settings import SNAP

from .answers import Answer
from .cases import CONVERGED, FAMILIES, MODELS, Case
from .comparison import disagreement, largest_errors, pareto_front
from .converged import Converged, decided, gap
from .probe import Probe

QUANTITIES = {"threshold": ("lowest N that snaps", "1"), "t_snap": ("time of the snap", "us")}
"""Long name and unit of each of `Answer.values`."""
LABELS = "share of cells with another label"


def dress(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    converged: Mapping[str, Converged],
    probe: Probe,
) -> xr.Dataset:
    """Hold every case against its reference and return all of it, with CF attributes.

    answers: of the cases and of the converged runs, by name
    """
    family = np.array([FAMILIES.index(case.family) for case in cases], np.int8)
    coordinates = {
        "model": [case.name for case in cases],
        "family": _flags("model", family, "family of cases that differ in one thing", FAMILIES),
        "against": ("model", [case.against for case in cases], {"long_name": "held against"}),
        "reference": list(converged),
        **_rows(probe),
    }
    variables = _comparison(cases, answers, converged, probe) | _references(converged, probe)
    return xr.Dataset(variables, coordinates).assign_attrs(
        Conventions="CF-1.11",
        title="Error from each source, and the time that a simulation takes",
        discretisations_gap=max(gap(run) for run in converged.values()),
        judged_by=_judge(converged),
    )


def _judge(converged):
    """The variable by which models are ranked: labels where no threshold is known to be right."""
    return "threshold_worst" if decided(converged[CONVERGED])[0].any() else "label_error"


def _rows(probe):
    """Coordinates of the thresholds."""
    shocks, rows = probe.shocks, probe.rows
    names = np.array([*itertools.product(shocks.shapes, shocks.directions)])
    values = {"C": rows.C, "f0": rows.f0} | dict(zip(PULSE_AXES, names[rows.pulse].T, strict=True))
    return {key: ("row", column, COORDINATES[key]) for key, column in values.items()}


def summary(found: xr.Dataset) -> str:
    """What no model beats, by which error, how many thresholds could be decided, what is cut down.

    One line.
    """
    front = found.isel(model=np.flatnonzero(found.on_front))
    points = zip(front.model.values, front[found.judged_by].values, strict=True)
    known = int(found.threshold_decided[0].sum()), found.sizes["row"]
    best = ", ".join(f"{name} ({worst:.1e})" for name, worst in points)
    line = f"not beaten {best or 'none'}; {known[0]} of {known[1]} thresholds are well posed"
    if found.judged_by == "label_error":
        snapped = found.share_snapped[0].item()
        line += f", so errors are those of labels; {snapped:.0%} of the cells snap"
    return "; only ".join([line, *filter(None, [found.left_out])])


def _comparison(cases, answers, converged, probe):
    """The variables along `model`."""
    found = [(answers[case.name], answers[case.against]) for case in cases]
    values = np.array([one.values for one, _ in found])
    errors = values / np.array([other.values for _, other in found]) - 1
    known = [decided(converged.get(case.against, converged[CONVERGED])) for case in cases]
    worst = largest_errors(errors, np.array(known))
    seconds = np.array([one.seconds for one, _ in found])
    labels = _label_errors(found, probe.axes["f0"])
    compared = labels | _errors(values, errors, worst)
    _, judged, _ = compared[_judge(converged)]
    return {**_settings(cases), **_ranking(cases, seconds, judged), **compared}


def _settings(cases):
    modes = [case.model.modes for case in cases]
    contact = [case.model.device.contact for case in cases]
    steps = [case.model.steps.longest[SNAP].item() for case in cases]
    return {
        "modes": _variable("model", modes, "number of modes", "1"),
        "step": _variable("model", steps, "longest time step", "us"),
        "contact": _variable("model", contact, "contact penalty; inf: hard", "uN um-1"),
    }


def _ranking(cases, seconds, worst):
    ranked = [case.family in MODELS for case in cases]
    front = pareto_front(np.where(ranked, seconds, np.nan), worst).astype(np.int8)
    return {
        "time_per_simulation": _variable("model", seconds * 1e6, "time per cell of the map", "us"),
        "simulations_per_second": _variable("model", 1 / seconds, "cells of the map per s", "s-1"),
        "on_front": _flags("model", front, "no model is faster and more accurate", ("no", "yes")),
    }


def _label_errors(found, f0):
    labels = [disagreement(one.t_snap, other.t_snap, f0) for one, other in found]
    all_cells, in_pulse = np.transpose(labels)
    return {
        "label_error": _variable("model", all_cells, f"{LABELS}, of all cells", "1"),
        "label_error_in_pulse": _variable("model", in_pulse, f"{LABELS} in the pulse", "1"),
    }


def _errors(values, errors, worst):
    variables, dims = {}, ("model", "row")
    for i, (key, (name, unit)) in enumerate(QUANTITIES.items()):
        relative = f"error of the {name}, relative"
        variables[key] = _variable(dims, values[:, i], name, unit)
        variables[f"{key}_error"] = _variable(dims, errors[:, i], relative, "1")
        variables[f"{key}_worst"] = _variable("model", worst[:, i], f"largest {relative}", "1")
    return variables


def _references(converged, probe):
    """The variables along `reference`."""
    runs, dims = list(converged.values()), ("reference", "row")
    labels = [disagreement(r.repeated, r.answer.t_snap, probe.axes["f0"])[0] for r in runs]
    seconds = [run.answer.seconds * 1e6 for run in runs]
    snapped = [np.isfinite(run.answer.t_snap).mean() for run in runs]
    variables = {
        "share_snapped": _variable("reference", snapped, "share of the map's cells that snap", "1"),
        "converged_time": _variable("reference", seconds, "time per cell of the map", "us"),
        "converged_label_error": _variable("reference", labels, f"{LABELS} at twice the step", "1"),
    }
    by_elements = [run.other_error for run in runs]
    columns = {
        "converged_{}": ([run.answer.values for run in runs], "{}"),
        "converged_{}_error": ([run.error for run in runs], "own error of the {}"),
        "elements_{}": ([run.other for run in runs], "{}, by elements"),
        "elements_{}_error": (by_elements, "own error of the {}, by elements"),
    }
    known = np.array([decided(run) for run in runs], np.int8)
    for i, (key, (name, unit)) in enumerate(QUANTITIES.items()):
        for column, (values, text) in columns.items():
            values = np.array(values)[:, i]
            variables[column.format(key)] = _variable(dims, values, text.format(name), unit)
        text = f"whether the {name} is known well enough to fault a model"
        variables[f"{key}_decided"] = _flags(dims, known[:, i], text, ("no", "yes"))
    return variables


def _variable(dims, values, long_name, units):
    return dims, np.asarray(values), {"long_name": long_name, "units": units}


def _flags(dims, values, long_name, meanings):
    flags = np.arange(len(meanings), dtype=np.int8)
    meanings = {"flag_values": flags, "flag_meanings": " ".join(meanings)}
    return dims, values, {"long_name": long_name} | meanings

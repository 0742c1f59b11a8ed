"""Verdicts of a study as a table, and changes of the device that meet a requirement."""

import csv
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from math import nan

from ...files.atomic import replacing
from ..application import Config
from ..design.design import remedy, with_value
from ..histories.history import FARTHEST, Extremes, warn_of_travel
from .check import Survival, restless, summary, worst
from .corners import UNCLEAR, VIOLATED, Verdict, at_corner, beyond
from .required import Required, RequiredShock


def hint(
    study: Config, requirements: Sequence[Required], verdicts: Sequence[Verdict], wrong: Verdict
) -> str:
    """Write which changes of a single value meet a requirement, and which others fail by them.

    verdicts: of all requirements, at each C; wrong: the one of them to correct
    Returns "" if its threshold is on the right side, if no single shock is required, or if no
    change helps.
    """
    shocks = [required for required in requirements if isinstance(required, RequiredShock)]
    goals = [shock for shock in shocks if shock.name == wrong.requirement]
    if not goals or beyond(wrong.margin, wrong.must_snap) <= 0:
        return ""
    shaken = at_corner(study, goals[0], wrong._asdict())
    device = study.devices()[wrong.device or "device"]
    of_device = [verdict for verdict in verdicts if verdict.device == wrong.device]
    dampings = list(dict.fromkeys(verdict.C for verdict in of_device))
    fails = _places(of_device, VIOLATED)
    changes = []
    for words, key, value in remedy(shaken, goals[0], wrong.C, wrong.N_first):
        try:
            changed = replace(study, device=with_value(device, key, value))
            judged = [v for required in shocks for v, _ in required.check(changed, dampings)]
        except ValueError:  # it has no second shape at one of the temperatures
            continue
        failing = _places(judged, VIOLATED)
        # It may still be missed at another corner, or by its other demands.
        if (wrong.requirement, wrong.C) in (*failing, *_places(judged, UNCLEAR)):
            continue
        if broken := list(dict.fromkeys(name for name, C in failing if (name, C) not in fails)):
            words += f" (then {' and '.join(broken)} {'fails' if len(broken) == 1 else 'fail'})"
        changes.append(words)
    return f"{' or '.join(changes)} meets it, all else unchanged" if changes else ""


def _places(verdicts, kind):
    """List the requirement and C of each verdict of a kind."""
    return [(verdict.requirement, verdict.C) for verdict in verdicts if verdict.verdict == kind]


def write_verdicts(study: Config, requirements: Sequence[Required], path: str) -> None:
    """Judge requirements, write a row for each device, corner and C, and print a summary."""
    C = study.axes["C"].tolist()
    judged = [pair for required in requirements for pair in required.check(study, C)]
    verdicts = [verdict for verdict, _ in judged]
    wrong, words = worst(verdicts)
    lines = [summary(verdicts), restless(verdicts), words]
    breaks = dict.fromkeys(
        verdict.requirement
        for verdict, beside in judged
        if beside.get("break_probability", 0) > 1 - beside.get("must_survive", 0)
    )
    if breaks:
        lines.insert(1, f"the beam breaks in {', '.join(breaks)}")
    if wrong:
        lines.append(hint(study, requirements, verdicts, wrong))
    always = chain(Verdict._fields, Extremes._fields, Survival._fields)
    columns = dict.fromkeys(chain(always, *(beside for _, beside in judged)))
    with replacing(path) as part, open(part, "w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, columns, restval=nan)
        rows.writeheader()
        for verdict, beside in judged:
            rows.writerow(verdict._asdict() | beside)
    _warn_of_travel(judged)
    print(f"{path}: {'; '.join(filter(None, lines))}")


def _warn_of_travel(judged):
    """Warn once, by their names, of the requirements in which the mass travels too far."""
    rises = [
        (beside.get("travel_over_rise", 0.0), verdict.requirement) for verdict, beside in judged
    ]
    far = [pair for pair in rises if pair[0] > FARTHEST]
    if far:
        names = ", ".join(dict.fromkeys(name for _, name in far))
        warn_of_travel(max(far)[0], f" in {len(far)} of {len(rises)} rows, of {names}")

"""What the verdicts of a study say together, and changes of the device that meet a requirement."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...files.text import plain
from ...study.study import ANY
from ..application import Config
from ..design.design import remedy, with_value
from ..histories.history import FARTHEST, warn_of_travel
from .required import Required, RequiredShock
from .verdict import (
    DIFFERS,
    MET,
    OPEN,
    RETURNS,
    UNCLEAR,
    VIOLATED,
    Verdict,
    at_corner,
)

LEVELS = {"random": " g rms", "spectrum": " times it"}
"""Units of the thresholds of vibration and of spectra, by the shape of a verdict."""


def sum_up(study: Config, requirements: Sequence[Required], verdicts: Sequence[Verdict]) -> str:
    """Write all verdicts of a study in a line, with changes of the device that meet the worst.

    Warns, once, of the requirements in which the mass travels too far.
    """
    wrong, words = worst(verdicts)
    breaks = dict.fromkeys(verdict.requirement for verdict in verdicts if verdict.breaks)
    broken = f"the beam breaks in {', '.join(breaks)}" if breaks else ""
    lines = [summary(verdicts), broken, restless(verdicts), words]
    if wrong:
        lines.append(hint(study, requirements, verdicts, wrong))
    far = [verdict for verdict in verdicts if verdict.travel_over_rise > FARTHEST]
    if far:
        names = ", ".join(dict.fromkeys(verdict.requirement for verdict in far))
        where = f" in {len(far)} of {len(verdicts)} rows, of {names}"
        warn_of_travel(max(verdict.travel_over_rise for verdict in far), where)
    return "; ".join(filter(None, lines))


def summary(verdicts: Sequence[Verdict]) -> str:
    """Write in a line how many requirements are met everywhere, and which are not."""
    kinds = dict.fromkeys((verdict.requirement for verdict in verdicts), MET)
    for kind in (UNCLEAR, VIOLATED):
        kinds |= {verdict.requirement: kind for verdict in verdicts if verdict.verdict == kind}
    parts = [f"{list(kinds.values()).count(MET)} of {len(kinds)} requirements met"]
    for kind in (VIOLATED, UNCLEAR):
        if names := ", ".join(name for name in kinds if kinds[name] == kind):
            parts.append(f"{kind}: {names}")
    return "; ".join(parts)


def restless(verdicts: Sequence[Verdict]) -> str:
    """Write which shocks must make the beam stay, but do not surely; the worst corner of each."""
    wrong = [v for v in verdicts if v.must_snap is True and v.end in (RETURNS, DIFFERS, OPEN)]
    lines: dict[str, str] = {}
    for verdict in sorted(wrong, key=lambda verdict: verdict.share_staying):
        where = f"{verdict.requirement}, {verdict.corner}, N = {plain(verdict.N)}"
        lines.setdefault(verdict.requirement, f"{where}: {verdict.end_text}")
    return "; ".join(lines.values())


def worst(verdicts: Sequence[Verdict]) -> tuple[Verdict | None, str]:
    """Choose the verdict whose threshold is furthest on the wrong side, or else nearest to it.

    Returns the verdict and its description, or None and "" if no requirement is about a trip.
    """
    tripping = [verdict for verdict in verdicts if verdict.must_snap != ANY]
    if not tripping:
        return None, ""
    furthest = max(tripping, key=lambda verdict: verdict.beyond)
    where = f"{furthest.requirement}, {furthest.corner}"
    if np.isnan(furthest.margin):
        return furthest, f"{where}: nothing snaps"
    side = "not sensitive enough" if furthest.must_snap else "too sensitive"
    words = f"{where}: {side}, " if furthest.beyond > 0 else f"least margin at {where}: "
    need = "must" if furthest.must_snap else "must not"
    unit = LEVELS.get(furthest.shape, "")
    lead = "" if unit else "N = "
    first, N = (f"{lead}{plain(N)}{unit}" for N in (furthest.N_first, furthest.N))
    return furthest, f"{words}trips at {first}, {need} at {N}"


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
    if not goals or wrong.beyond <= 0:
        return ""
    shaken = at_corner(study, goals[0], wrong)
    device = study.devices()[wrong.device or "device"]
    of_device = [verdict for verdict in verdicts if verdict.device == wrong.device]
    dampings = list(dict.fromkeys(verdict.C for verdict in of_device))
    fails = _places(of_device, VIOLATED)
    changes = []
    for words, key, value in remedy(shaken, goals[0], wrong.C, wrong.N_first):
        try:
            changed = replace(study, device=with_value(device, key, value))
            judged = [v for required in shocks for v in required.check(changed, dampings)]
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

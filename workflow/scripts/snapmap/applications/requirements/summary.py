"""Shares of a batch beside its verdicts, and what all verdicts of a study say together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from ...files.text import plain
from ...numerics.statistics import devices_to_decide
from ...study.shock import Shock
from ...study.study import ANY
from ..histories.history import FARTHEST, warn_of_travel
from .verdict import MET, UNCLEAR, VIOLATED, Verdict


def with_shares(
    verdicts: Sequence[Verdict], shocks: Sequence[Shock], made: xr.Dataset
) -> list[Verdict]:
    """Add to verdicts the shares of devices as made, which decide where a requirement asks for one.

    shocks: those of the requirements; made: dataset of `tolerances_of` for them
    """
    by_name = {shock.name: shock for shock in shocks}
    return [_with_share(verdict, by_name.get(verdict.requirement), made) for verdict in verdicts]


def _with_share(verdict, shock, made):
    if not shock:
        return verdict
    at = {"requirement": shock.name, "C": verdict.C}
    at |= {"device": verdict.device} if verdict.device else {}
    here = made[["share_meeting", "share_meeting_bound"]].sel(at)
    share, (low, high) = here.share_meeting.item(), here.share_meeting_bound.values.tolist()
    found = replace(verdict, share=share, share_low=low, share_high=high)
    if not shock.share:
        return found
    word = MET if low >= shock.share else VIOLATED if high < shock.share else UNCLEAR
    needed = devices_to_decide(share, shock.share, shock.confidence) if word == UNCLEAR else np.nan
    return replace(found, share_asked=shock.share, verdict=word, devices=needed)


def missing_fire(level: xr.DataArray, samples: int) -> str:
    """Write how many devices a level of all-fire or no-fire takes; "" if these are enough."""
    needed = devices_to_decide(1.0, level.share, level.confidence)
    return f"takes {needed} devices" if samples < needed else ""


LEVELS = {"random": " g rms", "spectrum": " times it"}
"""Units of the thresholds of vibration and of spectra, by the shape of a verdict."""


def sum_up(verdicts: Sequence[Verdict]) -> str:
    """Write all verdicts of a study in a line.

    Warns, once, of the requirements in which the mass travels too far.
    """
    breaks = dict.fromkeys(verdict.requirement for verdict in verdicts if verdict.breaks)
    broken = f"the beam breaks in {', '.join(breaks)}" if breaks else ""
    lines = summary(verdicts), of_batch(verdicts), broken, restless(verdicts), worst(verdicts)[1]
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
    if any(verdict.is_nominal for verdict in verdicts):
        parts[0] += " (by the nominal device where no share is asked for)"
    for kind in (VIOLATED, UNCLEAR):
        if names := ", ".join(name for name in kinds if kinds[name] == kind):
            parts.append(f"{kind}: {names}")
    return "; ".join(parts)


def of_batch(verdicts: Sequence[Verdict]) -> str:
    """Write which share of the devices as made meets each requirement, at the worst C."""
    known = [verdict for verdict in verdicts if np.isfinite(verdict.share)]
    least: dict[str, str] = {}
    for verdict in sorted(known, key=lambda verdict: verdict.share):
        least.setdefault(verdict.requirement, f"{verdict.requirement} {verdict.share_text}")
    return f"share of the devices as made that meet {', '.join(least.values())}" if least else ""


def restless(verdicts: Sequence[Verdict]) -> str:
    """Write which shocks must make the beam stay, but do not surely; the worst corner of each."""
    wrong = [v for v in verdicts if v.must_snap is True and v.share_staying < 1]
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

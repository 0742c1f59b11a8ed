"""Verdicts of a batch: the share that meets each requirement, all-fire and no-fire."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from ...numerics.statistics import devices_to_decide
from ...study.shock import Shock
from .verdict import MET, UNCLEAR, VIOLATED, Verdict


def with_shares(
    verdicts: Sequence[Verdict], shocks: Sequence[Shock], made: xr.Dataset
) -> list[Verdict]:
    """Add to verdicts the shares of devices as made, which decide where a requirement asks for one.

    shocks: those of the requirements; made: dataset of `tolerances_of` for them
    """
    found, by_name = [], {shock.name: shock for shock in shocks}
    for verdict in verdicts:
        if shock := by_name.get(verdict.requirement):
            verdict = _with_share(verdict, shock, made)
        found.append(verdict)
    return found


def _with_share(verdict, shock, made):
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

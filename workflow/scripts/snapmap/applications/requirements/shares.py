"""Verdicts of a batch: the share that meets each requirement, all-fire and no-fire."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from ...files.text import plain
from ...numerics.statistics import devices_to_decide
from ...study.shock import Shock
from .verdict import MET, UNCLEAR, VIOLATED, Verdict


def with_shares(
    verdicts: Sequence[Verdict], shocks: Sequence[Shock], made: xr.Dataset
) -> list[Verdict]:
    """Add to verdicts the shares of devices as made, which decide where a requirement asks for one.

    shocks: those of the requirements; made: dataset of `tolerances_of` for them
    """
    by_name = {shock.name: shock for shock in shocks}
    return [
        _with_share(verdict, by_name[verdict.requirement], made)
        if verdict.requirement in by_name
        else verdict
        for verdict in verdicts
    ]


def _with_share(verdict, shock, made):
    at = {"requirement": shock.name, "C": verdict.C}
    if verdict.device:
        at["device"] = verdict.device
    here = made[["share_meeting", "share_meeting_bound"]].sel(at)
    share, (low, high) = here.share_meeting.item(), here.share_meeting_bound.values.tolist()
    found = replace(verdict, share=share, share_low=low, share_high=high)
    if not shock.share:
        return found
    word = MET if low >= shock.share else VIOLATED if high < shock.share else UNCLEAR
    needed = devices_to_decide(share, shock.share, shock.confidence) if word == UNCLEAR else np.nan
    return replace(found, share_asked=shock.share, verdict=word, devices=needed)


def fewest(level: xr.DataArray) -> float:
    """Give the number of devices as made that a level of all-fire or no-fire takes."""
    return devices_to_decide(1.0, level.attrs["share"], level.attrs["confidence"])


def fire_text(level: xr.DataArray, samples: int) -> str:
    """Write a level of all-fire or no-fire, or why it is not known."""
    if np.isfinite(level):
        return plain(level.item())
    needed = fewest(level)
    return f"takes {needed} devices" if samples < needed else "some devices never snap"

"""Corners of requirements: the device, temperature, shape and direction of each verdict."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...files.text import plain
from ...solver.settings import FIRST
from ...study.shock import Shock
from ...study.study import ANY, SNAPS, Study

MET, VIOLATED, UNCLEAR = "met", "failed", "unclear"
STAYS, RETURNS, OPEN, DIFFERS = "stays", "arrives and returns", "still swings", "ends differ"
NO_ARRIVAL, NOT_FOLLOWED = "does not arrive", "not followed"
"""How a beam ends after a required shock."""


class Verdict(NamedTuple):
    """The verdict on a requirement for one device, C, temperature, and shape and direction.

    N, N_first, N_error: multiples of g; f0: Hz; duration: ms; C: uN us/um; temperature: degC
    must_snap: true (it must arrive and stay), false, ARRIVES, or ANY
    scale, scale_first: N and N_first as factors of a recorded shock, else NaN
    margin, margin_error: N_first and its error bar over N; NaN where nothing snaps
    outcome: outcome of the required shock, simulated
    verdict: MET, VIOLATED, or UNCLEAR if N is within the error bar
    start: as in `Run`
    end: how the required shock ends, in the runs near N that arrive: STAYS if all stay, DIFFERS if
        some do, else RETURNS or OPEN; NO_ARRIVAL at N itself, or NOT_FOLLOWED
    share_staying: share of these runs that stay in the other shape
    """

    requirement: str
    device: str
    shape: str
    direction: str
    N: float
    f0: float
    duration: float
    C: float
    temperature: float
    must_snap: bool | str
    outcome: str
    N_first: float
    N_error: float
    margin: float
    margin_error: float
    verdict: str
    scale: float = np.nan
    scale_first: float = np.nan
    start: str = FIRST
    end: str = NOT_FOLLOWED
    share_staying: float = np.nan


def read_verdicts(path: str | Path) -> list[dict]:
    """Read the rows of requirements.csv; names such as 12 or nan stay text.

    `must_snap` is True, False, `arrives` or `any`.
    """
    import pandas  # imported late: most runs read no table

    text = {"dtype": str, "keep_default_na": False}
    words = pandas.read_csv(path, usecols=["requirement", "device", "must_snap"], **text)
    truths = {"True": True, "False": False}
    must_snap = words.must_snap.map(lambda word: truths.get(word, word))
    rows = pandas.read_csv(path).assign(**words.assign(must_snap=must_snap))
    return rows.to_dict("records")


def corners(rows: Iterable[Mapping]) -> list[list[Mapping]]:
    """Group rows of verdicts by requirement, device and C; each group begins with its worst."""
    groups: dict[tuple, list[Mapping]] = {}
    for row in rows:
        groups.setdefault((row["requirement"], row["device"], row["C"]), []).append(row)
    return [sorted(group, key=badness, reverse=True) for group in groups.values()]


def at_corner(study: Study, required: Shock, corner: Mapping) -> Study:
    """Narrow a study to a requirement at the device, temperature, shape and direction of a corner.

    corner: a Verdict as a mapping
    """
    device = study.device
    device = device[corner["device"]] if isinstance(device, Mapping) else device
    if corner["temperature"] != device.temperature:
        device = device.at(corner["temperature"])
    study = required.shaken(study)
    pushed = corner["shape"], corner["direction"]
    for shocks in study.shocks.each():
        if (shocks.pulse.name, shocks.direction) == pushed:
            return replace(study, device=device).under(shocks)
    raise KeyError(pushed)


def badness(row: Mapping) -> tuple[int, float, float]:
    """Rank a row of verdicts, higher if worse: by its verdict, then by `beyond`.

    A beam that must stay is worse, the fewer of its runs do. Where a trip does not matter, the
    least of the other margins counts.
    """
    severity = (MET, UNCLEAR, VIOLATED).index(row["verdict"])
    must_stay = row["must_snap"] is True
    straying = np.nan_to_num(1 - row.get("share_staying", np.nan)) if must_stay else 0.0
    if row["must_snap"] == ANY:
        margins = {key: row[key] for key in row if key.endswith("_margin")}
        if not row["must_survive"] > 0:
            margins["strength_margin"] = np.nan
        reserve = np.fmin.reduce([np.nan, *margins.values()])
        return severity, straying, -np.inf if np.isnan(reserve) else -reserve
    return severity, straying, beyond(row["margin"], row["must_snap"])


def beyond(margin: float, must_snap: bool) -> float:
    """Logarithm of how far a margin is on the wrong side; below 0 on the right side."""
    size = np.inf if np.isnan(margin) else np.log(margin)
    return size if must_snap else -size


def corner_text(row: Mapping) -> str:
    """Write shape, direction, C and temperature of a verdict."""
    shock = f"{row['shape']} {row['direction']}"
    return f"{shock}, C = {plain(row['C'])}, {plain(row['temperature'])} degC"


def end_text(row: Mapping) -> str:
    """Write how the beam ends after a required shock; row: a Verdict as a mapping."""
    staying = f", {100 * row['share_staying']:.0f} % of the runs stay"
    return row["end"] + (staying if row["end"] == DIFFERS else "")


def must_text(name: str, must_snap: bool | int | str) -> str:
    """Write a requirement's name and what the device must do.

    must_snap: as in rows of verdicts, or as coded in datasets
    """
    needs = {0: "does not trip", 1: "trips and stays", 2: "trips or not", 3: "arrives"}
    need = needs[SNAPS[must_snap] if isinstance(must_snap, str) else must_snap]
    return f"{name}, {need}"

"""Thresholds as a line of text, and as a plain table for other tools."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from ..files.tables import write_table
from ..files.text import plain
from ..study.axes import duration_of
from .survey import NOT_FOLLOWED, NOTHING_SNAPS, STATUS


def write_thresholds(thresholds: xr.Dataset, path: str | Path) -> None:
    """Write the table of `tidy`, whose places keep all digits."""
    table = tidy(thresholds)
    units = {key: thresholds[key].attrs.get("units", "1") for key in table if key in thresholds}
    units = {key: unit for key, unit in units.items() if unit != "1"} | {"duration": "ms"}
    write_table(table, path, units, [*thresholds.N_first.dims, "duration"])


def tidy(thresholds: xr.Dataset) -> pd.DataFrame:
    """Make a table with a row for each threshold: its place on all axes, then its variables.

    thresholds: a Dataset of `threshold`
    Limits of long and short pulses are repeated in each row. `status` is in words. The ends of
    islands are left out.
    """
    N_first = thresholds.N_first
    dims, kept = N_first.dims, [key for key, a in thresholds.items() if "island" not in a.dims]
    table = thresholds[kept].broadcast_like(N_first).transpose(*dims).to_dataframe().reset_index()
    table["duration"] = table["f0"].map(duration_of)
    table["status"] = np.array(STATUS)[table["status"]]
    return table[[*dims, "duration", *kept]]


def summary(thresholds: xr.Dataset, lowest: float = -np.inf, highest: float = np.inf) -> str:
    """Sum up thresholds in one line: their range, errors, and which direction needs less.

    lowest, highest: ends of a grid's N; the line says which maps lie on one side of the threshold
    """
    N_first, status = thresholds.N_first, thresholds.status
    exists = np.isfinite(N_first.values)
    N, error = N_first.values[exists], thresholds.N_error.values[exists]
    ends = dict.fromkeys(to_digits(N[i], error[i]) for i in (*N.argsort()[:1], *N.argsort()[-1:]))
    ends = f"{'from' if len(ends) > 1 else 'at'} N = {' to '.join(ends)}, " if ends else ""
    known = (error / N)[np.isfinite(error)]
    typical = f"{100 * np.median(known):.2f} %" if known.size else "unknown"
    ragged = int(thresholds.ragged.where(N_first.notnull(), 0).sum())
    line = (
        f"{N.size} of {N_first.size} thresholds found, {ends}"
        f"{ragged} of them ragged, {int((known > 0.01).sum())} with an error above 1 %, "
        f"median error {typical}"
    )
    for number in (NOTHING_SNAPS, NOT_FOLLOWED):
        if count := int((status == number).sum()):
            line += f"; {STATUS[number].replace('_', ' ')} in {count}"
    beyond = {
        "above": N_first < lowest,
        "below": (N_first > highest) | (status == NOTHING_SNAPS) & (highest < np.inf),
    }
    for side, rows in beyond.items():
        if (maps := rows.all("f0")).any():
            where = f" in {int(maps.sum())} of {maps.size} maps" if maps.size > 1 else ""
            line += f"; the grid lies wholly {side} the threshold{where}"
    if thresholds.sizes.get("direction", 1) < 2:
        return line
    # If nothing snaps in one direction, the other needs less.
    lower = N_first.fillna(np.inf).idxmin("direction").where(N_first.notnull().any("direction"))
    sides = [f"{side} in {int((lower == side).sum())}" for side in N_first.direction.values]
    return f"{line}; less N is needed along {', '.join(sides)} of {lower.size} pairs"


def to_digits(N: float, error: float) -> str:
    """Write a threshold to the digits that its error allows, at most four."""
    known = math.floor(math.log10(N)) - math.floor(math.log10(error)) if error > 0 else 3
    return plain(N, min(max(known, 0), 3) + 1)

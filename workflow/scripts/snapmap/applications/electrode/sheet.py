"""Closures of an electrode under required shocks, for a data sheet."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...files.text import plain, table
from ...study.study import Study
from ..requirements.corners import corner_text

CLOSURES = {
    "t_closed": ("first closure", " us"),
    "closed_for": ("then closed, to the end if it never opens", " us"),
    "openings": ("openings", ""),
    "closed_share": ("share of the time since then closed", ""),
}
"""Words and unit of each of `Closures`."""


def sections(study: Study, rows: Sequence[Mapping]) -> list[str]:
    """Write a line and a table in Markdown; none if nothing closes. rows: of requirements.csv"""
    closed = [row for row in rows if np.isfinite(row.get("t_closed", np.nan))]
    if not closed:
        return []
    horizon = plain(study.run.horizon / 1e3)
    cells = []
    for row in closed:
        where = f"{row['requirement']}, {corner_text(row)}"
        for key, (words, unit) in CLOSURES.items():
            value, error = plain(row[key]), plain(row[f"{key}_error"], 1)
            cells.append([words, value + unit, error + unit, where])
    words = f"The electrode, to {horizon} ms after a shock:\n"
    return [words, table(["what", "value", "error", "under"], cells)]

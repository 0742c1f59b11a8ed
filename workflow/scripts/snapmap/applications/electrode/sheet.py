"""Closures of an electrode under required shocks, for a data sheet."""

from collections.abc import Sequence

import numpy as np

from ...files.text import plain, table
from ...study.study import Study
from ..requirements.verdict import Verdict

CLOSURES = {
    "t_closed": ("first closure", " us"),
    "closed_for": ("then closed, to the end if it never opens", " us"),
    "openings": ("openings", ""),
    "closed_share": ("share of the time since then closed", ""),
}
"""Words and unit of each of `Closures`."""


def sections(study: Study, verdicts: Sequence[Verdict]) -> list[str]:
    """Write a line and a table in Markdown; none if nothing closes."""
    closed = [verdict for verdict in verdicts if np.isfinite(verdict.more.get("t_closed", np.nan))]
    if not closed:
        return []
    horizon = plain(study.horizon / 1e3)
    cells = []
    for verdict in closed:
        where, more = f"{verdict.requirement}, {verdict.corner}", verdict.more
        for key, (words, unit) in CLOSURES.items():
            value, error = plain(more[key]), plain(more[f"{key}_error"], 1)
            cells.append([words, value + unit, error + unit, where])
    words = f"The electrode, to {horizon} ms after a shock:\n"
    return [words, table(["what", "value", "error", "under"], cells)]

"""What maps and the page show of each cell: whether it snaps, when, and where its beam ends."""

import json
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.colors import ListedColormap

from ..solver.outcome import WHOLE_SWING, ended_elsewhere
from . import style


class State(NamedTuple):
    """An end state: its name, what it means in words, and its colour."""

    name: str
    words: str
    colour: str


STATES = (
    State("rest_proven", "not tripped, proven", "#0b4a8f"),
    State("rest_seen", "not tripped when last seen", "#99bbe0"),
    State("crossing", "still going back and forth", "#dedacd"),
    State("tripped_seen", "tripped when last seen", "#df7f25"),
    State("tripped_proven", "tripped for good, proven", "#ad4a00"),
    State("failed", "failed", "#000000"),
    State("absent", "no second stable shape", "#ffffff"),
)
"""Colours answer whether the beam is tripped at the end, their strength how that is known.

Steps of lightness tell them apart in grey, hue and lightness to the colour-blind.
"""
REST_PROVEN, REST_SEEN, CROSSING, TRIPPED_SEEN, TRIPPED_PROVEN = range(5)
FAILED, ABSENT = range(5, len(STATES))

SNAPS = (
    State("waiting", "does not snap", "#d3dde5"),
    State("snapped", "snaps", "#6fae9f"),
    STATES[FAILED],
    STATES[ABSENT],
)
"""Whether a cell snaps within its run."""
WAITING = State("waiting", "no snap seen", "#ececec")
# Short of its lightest end, which in grey is as light as a cell without a snap.
TIME_COLOURS = ListedColormap(colormaps["cividis"](np.linspace(0, 0.88, 256)))
WIDE = 30
"""Ratio of snap times from which their colours are logarithmic."""
TIMES = WAITING, WAITING, *SNAPS[2:]
"""As SNAPS, of a map of times, where a cell that snaps has the colour of its time."""


def end_states(cells: xr.Dataset) -> xr.DataArray:
    """The index in STATES of each cell, int8; cells: with outcome, t_snap, well and well_share.

    A run that ended at its snap, as those of the model `reference`, was last seen there.
    """
    is_one_of = _outcomes(cells)
    proven = is_one_of["never"] | is_one_of["returned"] | is_one_of["latched"]
    starts = style.starts(json.loads(cells.attrs.get("config", "{}")))
    tripped = (cells.well == 2) | ((cells.well == 0) & (cells.t_snap.notnull() ^ bool(starts)))
    crossing = (cells.well != 0) & ~(cells.well_share >= WHOLE_SWING)
    rest = xr.where(proven, REST_PROVEN, REST_SEEN)
    codes = xr.where(tripped, xr.where(proven, TRIPPED_PROVEN, TRIPPED_SEEN), rest)
    codes = xr.where(crossing & ~proven, CROSSING, codes)
    return _without_runs(codes, is_one_of, FAILED, ABSENT)


def snap_states(cells: xr.Dataset) -> xr.DataArray:
    """The index in SNAPS of each cell, int8; cells: with outcome and t_snap."""
    return _without_runs(cells.t_snap.notnull(), _outcomes(cells), 2, 3)


def time_states(cells: xr.Dataset) -> xr.DataArray:
    """The index in TIMES of each cell, int8; -1 where it snaps."""
    codes = snap_states(cells)
    return codes.where(codes != 1, -1)


def end_elsewhere(cells: xr.Dataset) -> xr.DataArray:
    """Whether a run of each cell with another step ended elsewhere; no where there was none."""
    if "well_reproduced" not in cells:
        return xr.zeros_like(cells.outcome, bool)
    return ended_elsewhere(cells.well_reproduced, cells.well_share)


SHOWN = {
    "snaps": (SNAPS, snap_states),
    "times": (TIMES, time_states),
    "ends": (STATES, end_states),
}
"""What maps show: the states that a cell may have, and the function that tells them."""


def _outcomes(cells):
    names = cells.outcome.attrs["flag_meanings"].split()
    return {name: cells.outcome == code for code, name in enumerate(names)}


def _without_runs(codes, outcomes, failed, absent):
    """Put what has no run of its own in place of its state."""
    for name, state in (("failed", failed), ("absent", absent)):
        if name in outcomes:
            codes = xr.where(outcomes[name], state, codes)
    return codes.astype(np.int8)

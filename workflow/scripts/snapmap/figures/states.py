"""The states of cells on maps and on the page: whether cells snap, when, and where beams end."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.colors import ListedColormap

from ..files.text import show
from ..solver.outcome import WHOLE_SWING, ended_elsewhere
from ..study.provenance import config_of
from . import captions


class State(NamedTuple):
    """An end state: its name, what it means in words, and its colour."""

    name: str
    words: str
    colour: str


STATES = (
    State("rest_settled", "not tripped, settled", "#093c76"),
    State("rest_seen", "not tripped when last seen", "#99bbe0"),
    State("crossing", "still going back and forth", "#dedacd"),
    State("tripped_seen", "tripped when last seen", "#df7f25"),
    State("tripped_settled", "tripped, settled", "#943f00"),
    State("elsewhere", "ends elsewhere with another step", "#8d69a8"),
    State("failed", "failed", "#000000"),
    State("absent", "no second stable shape", "#ffffff"),
)
"""States of a beam at its end, of which each cell has one. Hue tells whether it is tripped,
strength how sure that is; `elsewhere` is what a run with another step contradicts.

Colours differ in lightness for grey print, and in hue and lightness for the colour-blind.
"""
REST_SETTLED, REST_SEEN, CROSSING, TRIPPED_SEEN, TRIPPED_SETTLED, ELSEWHERE = range(6)
FAILED, ABSENT = range(6, len(STATES))

SNAPS = (
    State("waiting", "does not snap", "#cbdff2"),
    State("snapped", "snaps", "#6fae9f"),
    STATES[FAILED],
    STATES[ABSENT],
)
"""States of a cell by whether it snaps within its run."""
WAITING = State("waiting", "no snap seen", SNAPS[0].colour)
# Without the lightest colours, which in grey look like a cell without a snap.
TIME_COLOURS = ListedColormap(colormaps["viridis"](np.linspace(0, 0.78, 256)))
WIDE = 30
"""Largest ratio of snap times with linear colours; beyond, they are logarithmic."""
TIMES = WAITING, WAITING, *SNAPS[2:]
"""States on a map of times, as SNAPS; a cell that snaps has the colour of its time instead."""


def end_states(cells: xr.Dataset) -> xr.DataArray:
    """Give the index in STATES of each cell, int8.

    cells: with outcome, t_snap, well and well_share, and well_reproduced if they ran twice; a run
        that ends at its snap, as those of the model `reference`, was last seen there
    """
    is_one_of = _outcomes(cells)
    settled = is_one_of["never"] | is_one_of["returned"] | is_one_of["latched"]
    starts = captions.starts(config_of(cells.attrs))
    tripped = (cells.well == 2) | ((cells.well == 0) & (cells.t_snap.notnull() ^ bool(starts)))
    crossing = (cells.well != 0) & ~(cells.well_share >= WHOLE_SWING)
    rest = xr.where(settled, REST_SETTLED, REST_SEEN)
    codes = xr.where(tripped, xr.where(settled, TRIPPED_SETTLED, TRIPPED_SEEN), rest)
    codes = xr.where(crossing & ~settled, CROSSING, codes)
    if "well_reproduced" in cells:
        codes = xr.where(ended_elsewhere(cells.well_reproduced, cells.well_share), ELSEWHERE, codes)
    return _without_runs(codes, is_one_of, FAILED, ABSENT)


def snap_states(cells: xr.Dataset) -> xr.DataArray:
    """Give the index in SNAPS of each cell, int8; cells: with outcome and t_snap."""
    return _without_runs(cells.t_snap.notnull(), _outcomes(cells), 2, 3)


def time_states(cells: xr.Dataset) -> xr.DataArray:
    """Give the index in TIMES of each cell, -1 where it snaps; cells: with outcome and t_snap."""
    codes = snap_states(cells)
    return codes.where(codes != 1, -1)


SHOWN = {
    "snaps": (SNAPS, snap_states),
    "times": (TIMES, time_states),
    "ends": (STATES, end_states),
}
"""States that cells may have on each kind of map, and the function that tells them."""


def coloured(shows: str, colours: Mapping[str, str]) -> tuple[Sequence[State], Callable]:
    """Give an entry of SHOWN with other colours, by the words of their states; ValueError."""
    known, classify = SHOWN[shows]
    if wrong := [*colours.keys() - {state.words for state in known}]:
        words = ", ".join(state.words for state in known)
        raise ValueError(f"colours: {show(wrong[0])} is none of the states {words}")
    return [
        state._replace(colour=colours.get(state.words, state.colour)) for state in known
    ], classify


def _outcomes(cells):
    names = cells.outcome.attrs["flag_meanings"].split()
    return {name: cells.outcome == code for code, name in enumerate(names)}


def _without_runs(codes, outcomes, failed, absent):
    """Put the indices of `failed` and `absent` cells in place of their states."""
    for name, state in (("failed", failed), ("absent", absent)):
        if name in outcomes:
            codes = xr.where(outcomes[name], state, codes)
    return codes.astype(np.int8)

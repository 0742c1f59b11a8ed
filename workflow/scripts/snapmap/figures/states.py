"""Where the beam of each cell is at the end of its run, as maps and the page show it."""

from typing import NamedTuple

import numpy as np
import xarray as xr

WHOLE_SWING = 0.999
"""Share of the last swing above which the beam has kept to one side."""


class State(NamedTuple):
    """An end state: its name, what it means in words, and its colour."""

    name: str
    words: str
    colour: str


STATES = (
    State("rest_proven", "not tripped, proven", "#2166ac"),
    State("rest_seen", "not tripped when last seen", "#b3d1e8"),
    State("crossing", "still going back and forth", "#f4f4f0"),
    State("tripped_seen", "tripped when last seen", "#fdcf8a"),
    State("tripped_proven", "tripped for good, proven", "#d9600a"),
    State("failed", "failed", "#000000"),
    State("absent", "no second stable shape", "#ffffff"),
)
"""Colours answer whether the beam is tripped at the end, their strength how that is known."""
REST_PROVEN, REST_SEEN, CROSSING, TRIPPED_SEEN, TRIPPED_PROVEN, FAILED, ABSENT = range(len(STATES))


def end_states(cells: xr.Dataset) -> xr.DataArray:
    """The index in STATES of each cell, int8; cells: with outcome, well and well_share."""
    names = cells.outcome.attrs["flag_meanings"].split()
    is_one_of = {name: cells.outcome == code for code, name in enumerate(names)}
    proven = is_one_of["never"] | is_one_of["returned"] | is_one_of["latched"]
    tripped, crossing = cells.well == 2, ~(cells.well_share >= WHOLE_SWING)
    rest = xr.where(proven, REST_PROVEN, REST_SEEN)
    found = xr.where(tripped, xr.where(proven, TRIPPED_PROVEN, TRIPPED_SEEN), rest)
    found = xr.where(crossing & ~proven, CROSSING, found)
    for name, state in (("failed", FAILED), ("absent", ABSENT)):
        if name in is_one_of:
            found = xr.where(is_one_of[name], state, found)
    return found.astype(np.int8)

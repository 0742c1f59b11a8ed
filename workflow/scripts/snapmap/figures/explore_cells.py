"""What the page's code knows of the cells: their end states, facts, thresholds and motion."""

import base64
import zlib

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex

from ..solver.outcome import OUTCOMES, WHOLE_SWING
from . import states

WORDS = {
    "unsnapped": "no snap, end open",
    "never": "never snaps",
    "snapped": "snaps, end open",
    "latched": "snaps and stays",
    "returned": "snaps and returns",
    "failed": "failed",
    "absent": "no second stable shape",
}
"""Of each outcome, in the order of the codes."""
GREY = "#999999"
"""Of what is absent, in place of the white that maps in print hatch."""
RAMP = [to_hex(colour) for colour in states.TIME_COLOURS(np.linspace(0, 1, 9))]
"""Colours of snap times, from the first to the last."""
TRACED = ("w_low", "w_high", "z_mass", "energy", "beam_energy")
EDGES = ("N_first", "N_error", "N_always")
STEPS, MISSING = 254, 255


def views(cells: xr.Dataset) -> list[dict]:
    """What the map can show: whether cells snap, when, and where they end if that is known.

    Of each its name and words; states, and the array that has their codes; and a colour scale for
    plotly, with RAMP in place of `snaps` on the map of times.
    """
    times = (states.WAITING, *states.SNAPS[1:])
    shown = [("snap", "snaps", "snap", states.SNAPS), ("time", "time", "snap", times)]
    shown += [("end", "where it ends", "end", states.STATES)] * ("well" in cells)
    made = []
    for name, words, code, (*known, absent) in shown:
        known = [*known, absent._replace(colour=GREY)]
        colours = [[state.colour] * 2 for state in known]
        view = {"name": name, "words": words, "code": code}
        if name == "time":
            colours[1] = view["ramp"] = RAMP
        view["scale"] = [
            ((place + share) / len(colours), colour)
            for place, ramp in enumerate(colours)
            for share, colour in zip(np.linspace(0, 1, len(ramp)).tolist(), ramp, strict=True)
        ]
        made.append(view | {"states": [state._asdict() for state in known]})
    return made


def cell_data(cells: xr.Dataset, traces: xr.Dataset, found: xr.Dataset) -> dict:
    """All that differs from cell to cell, as JSON; arrays (*axes), (*axes, bin) or (*axes but N).

    cells, traces: of the same points, the latter unpacked; found: thresholds at these
    """
    dims = cells.outcome.dims
    edges = {key: found[key].transpose(*dims[:-1]) for key in EDGES}
    columns = _columns(cells, traces) | edges
    arrays = {key: column.values for key, column in columns.items()}
    failed = cells.outcome.values == OUTCOMES.index("failed")
    for key in TRACED:
        arrays |= _scaled(key, traces[key].transpose(*dims, "bin").values, failed)
    return {
        "views": views(cells),
        "wide": states.WIDE,
        "outcomes": [{"name": name, "words": WORDS[name]} for name in OUTCOMES],
        "whole": WHOLE_SWING,
        "bins": traces.sizes["bin"],
        "missing": MISSING,
        "reach": float(traces.energy.attrs["clipped_at"]),
        "traced": TRACED,
        "arrays": {key: _pack(values) for key, values in arrays.items()},
    }


def opening(cells: xr.Dataset, x: str, y: str) -> list[int]:
    """Place on each axis of the cell to begin with: at the threshold, near the middle of x and y.

    One that snaps, and ends alike with another step, if there is any.
    """
    dims, snaps = cells.outcome.dims, np.isfinite(cells.t_snap.values)
    known = ~np.isin(cells.outcome.values, (OUTCOMES.index("failed"), OUTCOMES.index("absent")))
    sure = ~states.end_elsewhere(cells).values
    first = _at_threshold(snaps, known, dims, x, y)
    choice = next(some for some in (first & sure, first, known, ~known) if some.any())
    places, size = np.argwhere(choice), np.array(choice.shape)
    off = ((places - (size - 1) / 2) / size) ** 2
    drawn = np.isin(dims, (x, y))
    nearest = np.lexsort([off[:, drawn].sum(axis=1), off[:, ~drawn].sum(axis=1)])[0]
    return places[nearest].tolist()


def _at_threshold(snaps, known, dims, x, y):
    """Whether a cell is the first along N that snaps; on a map without N, at a change of label."""
    if y == "N":
        below = np.cumsum(snaps, axis=-1) - snaps
        return snaps & (below == 0) & ~snaps[..., :1]
    changes = np.zeros_like(snaps)
    for axis in map(dims.index, (x, y)):
        snap, quiet, change = (np.moveaxis(v, axis, 0) for v in (snaps, known & ~snaps, changes))
        change[1:] |= snap[1:] & quiet[:-1]
        change[:-1] |= snap[:-1] & quiet[1:]
    return changes


def _columns(cells, traces):
    """Codes and numbers of each cell, (*axes)."""
    dims = cells.outcome.dims
    unknown = xr.full_like(cells.t_snap, np.nan)
    energy = traces.energy.transpose(*dims, "bin")
    proof = np.ceil(cells.t_settled / traces.bin_length).transpose(*dims).fillna(0)
    at_proof = energy.isel(bin=proof.clip(0, energy.sizes["bin"] - 1).astype(int))
    return {
        "snap": states.snap_states(cells),
        **({"end": states.end_states(cells)} if "well" in cells else {}),
        "outcome": cells.outcome,
        "elsewhere": states.end_elsewhere(cells),
        "well": cells.get("well", xr.zeros_like(cells.outcome)),
        "t_snap": cells.t_snap,
        "t_settled": cells.t_settled,
        "share": cells.get("well_share", xr.ones_like(cells.t_snap)),
        "work_error": cells.get("work_error", unknown),
        "t_snap_error": cells.get("t_snap_error", unknown),
        # Unrounded, as the page says of both on which side of the saddle's they are.
        "energy_at_proof": at_proof,
        "energy_at_end": energy.isel(bin=-1),
        "bin_length": traces.bin_length.transpose(*dims),
        "second": traces.second_equilibrium.broadcast_like(cells.outcome).transpose(*dims),
    }


def _scaled(key, values, failed):
    """Motion in codes over each cell's own range, as differences, which are packed smaller.

    values: (*axes, bin), of what has failed as far as others go; the scale and the offset, (*axes),
    undo it
    """
    others = values[~failed]
    if np.isfinite(others).any():
        values = np.clip(values, np.nanmin(others), np.nanmax(others))
    seen = np.isfinite(values)
    low = np.where(seen, values, np.inf).min(axis=-1, keepdims=True)
    high = np.where(seen, values, -np.inf).max(axis=-1, keepdims=True)
    low, high = (np.where(np.isfinite(end), end, 0.0) for end in (low, high))
    scale = np.where(high > low, (high - low) / STEPS, 1.0)
    codes = np.where(seen, np.rint((values - low) / scale), MISSING).astype(np.uint8)
    steps = np.diff(codes, axis=-1, prepend=np.uint8(0))
    return {key: steps, f"{key}_scale": scale[..., 0], f"{key}_offset": low[..., 0]}


def _pack(values):
    """Codes in a byte each, numbers in four."""
    kind = np.float32 if values.dtype.kind == "f" else np.uint8
    whole = zlib.compress(np.ascontiguousarray(values, kind).tobytes(), level=6)
    return {"kind": kind.__name__, "bytes": base64.b64encode(whole).decode()}

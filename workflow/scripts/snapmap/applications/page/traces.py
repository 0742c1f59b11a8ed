"""Every cell's motion in brief: a band of w, z_M and the energy over time bins."""

import json
import math
from dataclasses import replace

import numpy as np
import xarray as xr

from ...beam.equilibria import Barrier
from ...solver.models import deciders
from ...solver.motion import BANDS, follow_motion, motion_levels
from ...solver.outcome import FAILED
from ...study.axes import NAMES, rows_of
from ...study.study import Study
from ...study.variables import dress
from ..histories.history import warn_of_travel

CELLS = 40_000
"""A larger grid is thinned along its longest axes by whole strides."""
BINS = (200, 100, 50)
"""Time bins of a cell: the most of these with which a page keeps to BYTES, or the fewest."""
BYTES = 10_000_000
"""Of the page, which keeps one for each value."""
DIGITS = {"quantize_mode": "BitRound", "significant_digits": 20}
"""Binary digits kept in the file: a beam that rests at 10 um may move by 0.001."""
# ASSUME: energies above four times the saddle's are drawn as four times: what counts is near one.
ENERGY_REACH = 4.0
MOST = 1e30
"""Of what a failed run blew up to, all that is kept."""


def trace(study: Study, cube: xr.Dataset) -> xr.Dataset:
    """Follow the cells of a study's cube again, at its steps, and keep their motion.

    A cell of `auto` is followed by the level that decided it, and a cell of `reference` by the same
    elements in their modes.
    Returns BANDS, (bin, *axes), and the length of the bins, (*axes); NaN where there is no device.
    """
    cube = thin(cube.sortby([key for key in cube.outcome.dims if key not in NAMES]))
    axes = {key: cube[key].values for key in cube.outcome.dims}
    names = {key: axes.pop(key).tolist() for key in NAMES if key in axes}
    grid, settings = replace(study.part(names), skip=True).set_out(axes), study.settings
    levels = motion_levels(grid.device, study.model, settings)
    level = cube.level.values.ravel() if "level" in cube else np.zeros(cube.outcome.size, int)
    rows, N = rows_of(grid), grid.axes["N"]
    cells = rows.cells(grid.device, N, settings.horizon).flat()
    device_of, size = cells.device, cells.device.size
    window = _window(grid.device, cube, cells, settings)
    bins = next((n for n in BINS if n * len(BANDS) * size <= BYTES), BINS[-1])
    values = np.full((len(BANDS), bins, size), np.nan, np.float32)
    bin_length, stress = np.zeros(size, np.float32), np.full(size, np.nan, np.float32)
    decided = np.stack([level, cube.halvings.values.ravel()])
    for at, part in deciders(levels, device_of, decided, np.flatnonzero(device_of >= 0)):
        motion, length, stress[at] = follow_motion(part, cells.take(at), window[at], bins, settings)
        values[..., at], bin_length[at] = _shown(motion, length, window[at]), length
    y = values[2] - values[2, 0]
    ran = np.isfinite(y).all(axis=0) & (cube.outcome.values.ravel() != FAILED)
    if ran.any():
        extremes = y[:, ran].min(axis=0), y[:, ran].max(axis=0)
        warn_of_travel(grid.device.pick(device_of[ran]), *extremes)
    return _as_traces(grid, cube, values, bin_length, stress, levels[0])


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth value of the longest axes, so that no more than CELLS cells are left."""
    strides = dict.fromkeys(reversed(cube.outcome.dims), 1)

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while math.prod(map(left, strides)) > CELLS:
        # Where C is short, as it is, only f0 and N are thinned.
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def _window(device, cube, cells, settings):
    """How long each cell is shown, us."""
    # ASSUME: a settled cell is shown for one swing of the mass beyond its proof, the others to
    # the horizon, as what follows there is open, or to the snap where the sweep ended there: its
    # step need not be fine enough for what comes after.
    swing = 2 * np.pi / device.own_frequency[cells.device]
    settled, snap = cube.t_settled.values.ravel(), cube.t_snap.values.ravel()
    ended = np.fmin(cells.t_end, snap) if settings.until == "snap" else cells.t_end
    return np.where(np.isnan(settled), ended, settled + swing)


def _shown(values, bin_length, window):
    """Values as they are kept: beyond the window, where a run may blow up, as far as within it."""
    begins = np.arange(values.shape[1])[:, np.newaxis] * bin_length
    within = {"axis": 1, "keepdims": True, "where": begins < window}
    with np.errstate(invalid="ignore"):
        low, high = values.min(**within, initial=MOST), values.max(**within, initial=-MOST)
        low[3:], high[3:] = 0.0, np.fmin(high[3:], ENERGY_REACH)
        values = np.clip(values, np.fmax(low, -MOST), np.fmin(high, MOST))
    return np.where(np.isfinite(values), values, np.nan)


def _as_traces(grid, cube, values, bin_length, stress, model):
    dims, device, number = cube.outcome.dims, grid.device, np.maximum(grid.device_of, 0)
    barrier = np.empty((len(Barrier._fields), len(device)))
    for members, part in model.split(np.arange(len(device))):
        barrier[:, members] = [column[members] for column in part.barrier]
    barrier = Barrier(*barrier)
    of_device = {
        "second_equilibrium": barrier.second,
        "saddle": barrier.first + barrier.midpoint,
        "barrier": barrier.energy,
    }
    of_cell = {"bin_length": bin_length}
    if np.isfinite(device.strength).any():
        of_device["strength"] = device.strength + device.strength_threshold
        of_cell["stress_max"] = stress
    data = {
        key: (("bin", *dims), band.reshape(-1, *grid.shape), {}, DIGITS)
        for key, band in zip(BANDS, values, strict=True)
    }
    for key in BANDS[3:]:
        data[key][2]["clipped_at"] = ENERGY_REACH
    data |= {key: (dims, column.reshape(grid.shape)) for key, column in of_cell.items()}
    data |= {
        key: (dims[: number.ndim], np.where(grid.device_of < 0, np.nan, column[number]))
        for key, column in of_device.items()
    }
    axes = {key: cube[key].values for key in dims}
    comment = "bin n, from 0, begins n bin lengths after the start of the pulse"
    document = json.loads(cube.attrs["config"])
    return dress("traces", xr.Dataset(data, axes), document, comment=comment)

"""The largest stress of each cell of a cube, by the models that decided them."""

import json
from dataclasses import replace

import numpy as np
import xarray as xr

from ...solver.models import deciders
from ...solver.motion import follow_stress, motion_levels
from ...study.axes import NAMES, rows_of
from ...study.study import Study
from ...study.variables import dress
from ...sweeps.cube import thin


def stress_of_cube(study: Study, cube: xr.Dataset) -> xr.Dataset:
    """Follow the cells of a study's cube again, at its steps, for the largest stress.

    The level of `auto` that decided a cell follows it; modes of the same elements follow a cell of
    `reference`.
    Returns `stress_max`, (*axes), NaN where there is no device, and `strength` of the devices; MPa.
    """
    cube = thin(cube.sortby([key for key in cube.outcome.dims if key not in NAMES]))
    axes = {key: cube[key].values for key in cube.outcome.dims}
    names = {key: axes.pop(key).tolist() for key in NAMES if key in axes}
    grid, settings = replace(study.part(names), skip=True).set_out(axes), study.run
    levels = motion_levels(grid.device, study.model, settings)
    level = cube.level.values.ravel() if "level" in cube else np.zeros(cube.outcome.size, int)
    cells = rows_of(grid).cells(grid.device, grid.axes["N"], settings.horizon).flat()
    window = _window(grid.device, cube, cells, settings)
    stress = np.full(cells.device.size, np.nan, np.float32)
    decided = np.stack([level, cube.halvings.values.ravel()])
    for at, part in deciders(levels, cells.device, decided, np.flatnonzero(cells.device >= 0)):
        stress[at] = follow_stress(part, cells.take(at), window[at], settings)
    dims, number = cube.outcome.dims, np.maximum(grid.device_of, 0)
    strength = (grid.device.strength + grid.device.strength_threshold)[number]
    data = {
        "stress_max": (dims, stress.reshape(grid.shape)),
        "strength": (dims[: number.ndim], np.where(grid.device_of < 0, np.nan, strength)),
    }
    document = json.loads(cube.attrs["config"])
    return dress("stress", xr.Dataset(data, {key: cube[key].values for key in dims}), document)


def _window(device, cube, cells, settings):
    """The time for which each cell is followed, us, (cells,)."""
    # ASSUME: one swing of the mass beyond the proof has the largest stress of a settled cell. The
    # others are followed to the horizon, or to a snap that ended them in the sweep: their step may
    # be too coarse for the motion after it.
    swing = 2 * np.pi / device.own_frequency[cells.device]
    settled, snap = cube.t_settled.values.ravel(), cube.t_snap.values.ravel()
    ended = np.fmin(cells.t_end, snap) if settings.until == "snap" else cells.t_end
    return np.where(np.isnan(settled), ended, settled + swing)

"""Every cell's motion in brief: a band of w, z_M and the energy over time bins, a byte for each."""

import json
import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr

from .cells import Cells, to_cells
from .cube import COORDINATES
from .device import Device
from .grid import AXES
from .ladder import Ladder, choose_model
from .lanes import LANES, SAMPLE, device_coefficients, trace_lanes
from .outcome import OUTCOMES
from .protocol import Protocol
from .provenance import provenance

CELLS = 50_000
"""A larger grid is thinned along f0 and N by whole strides."""
BINS = 40, 200
"""Fewest and most time bins of a cell; between them, as many as BYTES allow."""
BYTES = 10_000_000
LEVELS = 254
"""Steps of a packed value over its range, about the pixels of a small plot; 255 is missing."""
# ASSUME: energies above four times the saddle's are drawn as four times: what counts is near one,
# which lies halfway between two packed values, so that rounding moves nothing across it.
ENERGY_REACH = 4.0

VARIABLES = {
    "w_low": {"long_name": "least deflection of the beam's midpoint in the bin", "units": "um"},
    "w_high": {"long_name": "greatest deflection of the beam's midpoint in the bin", "units": "um"},
    "z_mass": {"long_name": "position of the mass at the start of the bin", "units": "um"},
    "energy": {"long_name": "energy over the saddle's, at the start of the bin", "units": "1"},
    "beam_energy": {"long_name": "the beam's share of the energy", "units": "1"},
}
_OUTWARD = {"w_low": np.floor, "w_high": np.ceil}


def trace(
    device: Device, cube: xr.Dataset, model: Mapping, protocol: Protocol, threads: int = 1
) -> xr.Dataset:
    """Follow the cells of a cube again, at its steps, and keep their motion, packed as netCDF does.

    model: name and options, as the cube's; a cell of `auto` is followed by the level that decided
        it, and a cell of `reference` by the same elements in their modes
    Returns the variables of VARIABLES, (bin, C, f0, N), which `xarray.decode_cf` unpacks, and the
    length of the bins, (C, f0, N); values beyond their range are clipped.
    """
    cube = thin(cube.sortby(list(AXES)))
    levels = _levels(device, model)
    level = cube.level.values.ravel() if "level" in cube else np.zeros(cube.outcome.size, int)
    halvings = cube.halvings.values.ravel()
    C, f0, N = (grid.ravel() for grid in np.meshgrid(*(cube[key] for key in AXES), indexing="ij"))
    cells = to_cells(device, N, f0, C, protocol.horizon)
    window = _window(device, cube, cells, protocol)
    bins = int(np.clip(BYTES // (len(VARIABLES) * f0.size), *BINS))
    values, bin_length = np.empty((len(VARIABLES), bins, f0.size)), np.empty(f0.size)
    for number, halved in np.unique([level, halvings], axis=1).T:
        mine = np.flatnonzero((level == number) & (halvings == halved))
        stepped = levels[number].with_step(0.5**halved)
        some = Cells(*(column[mine] for column in cells))
        found = _follow(stepped, some, window[mine], bins, threads)
        values[..., mine], bin_length[mine] = found
    return _dress(device, cube, dict(zip(VARIABLES, values, strict=True)), bin_length, levels[0])


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth f0 and every mth N, so that no more than CELLS cells are left."""
    strides = {"f0": 1, "N": 1}

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while cube.sizes["C"] * left("f0") * left("N") > CELLS and max(left("f0"), left("N")) > 1:
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def _levels(device, model):
    options = {key: model[key] for key in model if key != "name"}
    name = "handout" if model["name"] == "reference" else model["name"]
    built = choose_model(device, name, **options)
    return (built.base, built.top) if isinstance(built, Ladder) else (built,)


def _window(device, cube, cells, protocol):
    """How long each cell is shown, us."""
    # ASSUME: a settled cell is shown for one swing of the mass beyond its proof, the others to
    # the horizon, as what follows there is open, or to the snap where the sweep ended there: its
    # step need not be fine enough for what comes after.
    swing = 2 * np.pi * np.sqrt(device.mass / device.spring)
    settled, snap = cube.t_settled.values.ravel(), cube.t_snap.values.ravel()
    ended = np.fmin(cells.t_end, snap) if protocol.until == "snap" else cells.t_end
    return np.where(np.isnan(settled), ended, settled + swing)


def _follow(model, cells, window, bins, threads):
    """Values, (variables, bins, cells), and lengths of the bins, us; window: time followed, us."""
    row = device_coefficients(model, target=-np.inf)
    width = SAMPLE * np.ceil(window / (bins * SAMPLE * model.dt)).astype(np.int64)
    values = np.empty((len(VARIABLES), bins, width.size))
    # Lanes run together to the end of the longest: those of one call should be of one length.
    order = np.argsort(width, kind="stable")

    def follow(some):
        loads = *(column[some] for column in cells[:3]), width[some]
        w_range, instants = trace_lanes(model.modal.load.size, row, model.dt, loads, bins)
        positions = model.device.beam.rise + np.concatenate([w_range, instants[:1]])
        values[:3, :, some], values[3:, :, some] = positions, instants[1:] / model.barrier.energy

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(LANES, order.size, LANES))))
    return values, width * model.dt


def _dress(device, cube, values, bin_length, model):
    shape = [cube.sizes[key] for key in AXES]
    known = (cube.outcome != OUTCOMES.index("failed")).values.ravel()
    w_reach = _reach(device, values["w_low"][:, known], values["w_high"][:, known])
    ranges = {
        "w_low": w_reach,
        "w_high": w_reach,
        "z_mass": _reach(device, values["z_mass"][:, known]),
        "energy": (0.0, ENERGY_REACH),
        "beam_energy": (0.0, ENERGY_REACH),
    }
    data = {}
    for key, attributes in VARIABLES.items():
        codes, packing = _pack(values[key], *ranges[key], _OUTWARD.get(key, np.rint))
        data[key] = (("bin", *AXES), codes.reshape(-1, *shape), attributes | packing)
    length = {"long_name": "length of the time bins", "units": "us"}
    data["bin_length"] = (AXES, bin_length.reshape(shape).astype(np.float32), length)
    axes = {key: (key, cube[key].values, COORDINATES[key]) for key in AXES}
    return xr.Dataset(data, axes).assign_attrs(
        Conventions="CF-1.11",
        title="Motion of each cell in brief",
        comment="bin n, from 0, begins n bin lengths after the start of the pulse",
        **provenance(json.loads(cube.attrs["config"])),
        second_equilibrium=device.beam.second_equilibrium,
        saddle=device.beam.rise + model.barrier.midpoint,
        barrier=model.barrier.energy,
    )


def _reach(device, *positions):
    """Range of positions, in whole um, that also holds both stable shapes."""
    beam = device.beam
    seen = [values[np.isfinite(values)] for values in positions]
    low = min(values.min(initial=beam.second_equilibrium) for values in seen)
    high = max(values.max(initial=beam.rise) for values in seen)
    return float(math.floor(low)), float(math.ceil(high))


def _pack(values, low, high, rounded):
    """Codes of values clipped to a range, and the attributes that say how to undo it."""
    scale = (high - low) / LEVELS
    codes = rounded((np.clip(values, low, high) - low) / scale)
    codes = np.where(np.isfinite(values), codes, LEVELS + 1).astype(np.uint8)
    reach = {"valid_range": np.array([0, LEVELS], np.uint8), "_FillValue": np.uint8(LEVELS + 1)}
    return codes, {"scale_factor": scale, "add_offset": low, **reach}

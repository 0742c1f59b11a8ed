"""Every cell's motion in brief: a band of w, z_M and the energy over time bins, two bytes each."""

import json
import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr

from ..axes import DEVICE, NAMES, PULSE_AXES, Grid, coordinates, make_grid
from ..beam.barrier import Barrier
from ..device import Device
from ..io.provenance import provenance
from ..pulse import HANDOUT_SHOCK, Shocks
from ..solver import simd_loop
from ..solver.adaptive import choose_model
from ..solver.cells import rows_of, to_cells
from ..solver.outcome import ABSENT, FAILED
from ..solver.settings import Settings
from ..solver.simd_kernel import LANES, SAMPLE

CELLS = 50_000
"""A larger grid is thinned along its longest axes by whole strides."""
BINS = 40, 200
"""Fewest and most time bins of a cell; between them, as many as BYTES allow."""
BYTES = 10_000_000
"""Of the page, which keeps one for each value."""
LEVELS = 65_534
"""Steps of a packed value over its range: weak shocks move little of it; 65 535 is missing."""
# ASSUME: energies above four times the saddle's are drawn as four times: what counts is near one,
# which lies halfway between two packed values, so that rounding moves nothing across it.
ENERGY_REACH = 4.0

VARIABLES = {
    "w_low": {"long_name": "least deflection of the beam's midpoint in the bin", "units": "um"},
    "w_high": {"long_name": "greatest deflection of the beam's midpoint in the bin", "units": "um"},
    "z_mass": {"long_name": "position of the mass at the start of the bin", "units": "um"},
    "energy": {
        "long_name": "energy over the saddle's, at the start of the bin",
        "units": "1",
        "clipped_at": ENERGY_REACH,
    },
    "beam_energy": {
        "long_name": "the beam's share of the energy",
        "units": "1",
        "clipped_at": ENERGY_REACH,
    },
}
_OUTWARD = {"w_low": np.floor, "w_high": np.ceil}


def trace(
    device: Device | Mapping[str, Device],
    cube: xr.Dataset,
    model: Mapping,
    settings: Settings,
    shocks: Shocks = HANDOUT_SHOCK,
) -> xr.Dataset:
    """Follow the cells of a cube again, at its steps, and keep their motion, packed as netCDF does.

    device: the nominal one, or several by name; the cube's axes say which values are others
    model: name and options, as the cube's; a cell of `auto` is followed by the level that decided
        it, and a cell of `reference` by the same elements in their modes
    Returns the variables of VARIABLES, (bin, *axes), which `xarray.decode_cf` unpacks, and the
    length of the bins, (*axes); values beyond their range are clipped, and there are none where
    there is no device.
    """
    cube = thin(cube.sortby([key for key in cube.outcome.dims if key not in NAMES]))
    grid = grid_of(device, cube, shocks)
    levels = _levels(grid.device, model, settings.threads)
    level = cube.level.values.ravel() if "level" in cube else np.zeros(cube.outcome.size, int)
    halvings = cube.halvings.values.ravel()
    rows, N = rows_of(grid), grid.axes["N"]
    columns = (np.repeat(column, N.size) for column in rows)
    device_of, f0, C, pulse = columns
    N = np.tile(N, rows.f0.size)
    cells = to_cells(grid.device, device_of, N, f0, C, settings.horizon, pulse)
    window = _window(grid.device, cube, cells, settings)
    bins = int(np.clip(BYTES // (len(VARIABLES) * f0.size), *BINS))
    values, bin_length = np.full((len(VARIABLES), bins, f0.size), np.nan), np.zeros(f0.size)
    for number, halved in np.unique([level, halvings], axis=1).T:
        some = np.flatnonzero((level == number) & (halvings == halved) & (device_of >= 0))
        stepped = levels[number].with_step(0.5**halved)
        for mine, part, row in stepped.split(device_of[some]):
            which = some[mine]
            alike = cells.some(which)._replace(device=row)
            found = _follow(part, grid.pulses, alike, window[which], bins, settings.threads)
            values[..., which], bin_length[which] = found
    named = dict(zip(VARIABLES, values, strict=True))
    return _dress(grid, cube, named, bin_length, window, levels[0])


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth value of the longest axes, so that no more than CELLS cells are left."""
    strides = dict.fromkeys(reversed(cube.outcome.dims), 1)

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while math.prod(map(left, strides)) > CELLS:
        # Where C is short, as it is, only f0 and N are thinned.
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def grid_of(
    device: Device | Mapping[str, Device], cube: xr.Dataset, shocks: Shocks = HANDOUT_SHOCK
) -> Grid:
    """Set out the points of a cube's axes again."""
    axes = {key: cube[key].values for key in cube.outcome.dims}
    shocks = shocks.some({key: axes.pop(key).tolist() for key in PULSE_AXES if key in axes})
    if isinstance(device, Mapping):
        device = {name: device[name] for name in axes.pop(DEVICE).tolist()}
    return make_grid(device, axes, skip=True, shocks=shocks)


def _levels(device, model, threads):
    """A model with modes for each level of the cube's."""
    name = "handout" if model["name"] == "reference" else model["name"]
    return choose_model(device, {**model, "name": name}, threads).levels


def _window(device, cube, cells, settings):
    """How long each cell is shown, us."""
    # ASSUME: a settled cell is shown for one swing of the mass beyond its proof, the others to
    # the horizon, as what follows there is open, or to the snap where the sweep ended there: its
    # step need not be fine enough for what comes after.
    swing = 2 * np.pi / device.own_frequency[cells.device]
    settled, snap = cube.t_settled.values.ravel(), cube.t_snap.values.ravel()
    ended = np.fmin(cells.t_end, snap) if settings.until == "snap" else cells.t_end
    return np.where(np.isnan(settled), ended, settled + swing)


def _follow(model, pulses, cells, window, bins, threads):
    """Values, (variables, bins, cells), and lengths of the bins, us; window: time followed, us."""
    height, barrier = model.device.beam.height[cells.device], model.barrier.energy[cells.device]
    origin = np.stack([height, height, height + model.device.gap[cells.device]])
    dt = model.dt[cells.device]
    width = SAMPLE * np.ceil(window / (bins * SAMPLE * dt)).astype(np.int64)
    values = np.empty((len(VARIABLES), bins, width.size))
    # Lanes run together to the end of the longest: those of one call should be of one length.
    order = np.argsort(width, kind="stable")

    def follow(some):
        loads = *(column[some] for column in cells[1:5]), width[some]
        w_range, instants = simd_loop.trace(model, cells.device[some], pulses, loads, bins)
        values[:3, :, some] = origin[:, np.newaxis, some] + np.concatenate([w_range, instants[:1]])
        values[3:, :, some] = instants[1:] / barrier[some]

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(LANES, order.size, LANES))))
    return values, width * dt


def _dress(grid, cube, values, bin_length, window, model):
    dims, beam = cube.outcome.dims, grid.device.beam
    known = ~np.isin(cube.outcome.values.ravel(), (FAILED, ABSENT))
    # Bins reach beyond the window, where a run that was believed may yet blow up.
    ends = (1 + np.arange(len(values["w_low"]))[:, np.newaxis]) * bin_length
    known = known & (ends <= window)
    w_reach = _reach(beam, values["w_low"][known], values["w_high"][known])
    ranges = {
        "w_low": w_reach,
        "w_high": w_reach,
        "z_mass": _reach(beam, values["z_mass"][known]),
        "energy": (0.0, ENERGY_REACH),
        "beam_energy": (0.0, ENERGY_REACH),
    }
    data = {}
    for key, attributes in VARIABLES.items():
        codes, packing = _pack(values[key], *ranges[key], _OUTWARD.get(key, np.rint))
        data[key] = (("bin", *dims), codes.reshape(-1, *grid.shape), attributes | packing)
    length = {"long_name": "length of the time bins", "units": "us"}
    data["bin_length"] = (dims, bin_length.reshape(grid.shape).astype(np.float32), length)
    of_device, barrier = dims[: grid.device_of.ndim], _barrier_of(model)
    shown = {
        "second_equilibrium": (barrier.second, "midpoint of the second stable shape"),
        "saddle": (beam.height + barrier.midpoint, "midpoint of the saddle between both"),
        "barrier": (barrier.energy, "energy of the saddle"),
    }
    for key, (column, name) in shown.items():
        spread = np.where(grid.device_of < 0, np.nan, column[np.maximum(grid.device_of, 0)])
        unit = "pJ" if key == "barrier" else "um"
        data[key] = (of_device, spread, {"long_name": name, "units": unit})
    return xr.Dataset(data, coordinates({key: cube[key].values for key in dims})).assign_attrs(
        Conventions="CF-1.11",
        title="Motion of each cell in brief",
        comment="bin n, from 0, begins n bin lengths after the start of the pulse",
        **provenance(json.loads(cube.attrs["config"])),
    )


def _barrier_of(model):
    """The barrier of each device, arrays (devices,)."""
    found = np.empty((len(Barrier._fields), len(model.device)))
    for mine, part, row in model.split(np.arange(found.shape[1])):
        found[:, mine] = [column[row] for column in part.barrier]
    return Barrier(*found)


def _reach(beam, *positions):
    """Range of positions, in whole um, that also holds both stable shapes."""
    seen = [values[np.isfinite(values)] for values in positions]
    low = min(values.min(initial=np.min(beam.second_equilibrium)) for values in seen)
    high = max(values.max(initial=np.max(beam.height)) for values in seen)
    return float(math.floor(low)), float(math.ceil(high))


def _pack(values, low, high, rounded):
    """Codes of values clipped to a range, and the attributes that say how to undo it."""
    scale = (high - low) / LEVELS
    codes = rounded((np.clip(values, low, high) - low) / scale)
    codes = np.where(np.isfinite(values), codes, LEVELS + 1).astype(np.uint16)
    reach = {"valid_range": np.array([0, LEVELS], np.uint16), "_FillValue": np.uint16(LEVELS + 1)}
    return codes, {"scale_factor": scale, "add_offset": low, **reach}

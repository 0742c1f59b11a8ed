"""Every cell's motion in brief: a band of w, z_M and the energy over time bins."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import xarray as xr

from ..axes import NAMES, Grid, coordinates, shared_points
from ..beam.equilibria import Barrier
from ..io.counting import count
from ..io.provenance import provenance, recipe
from ..io.variables import variables
from ..solver import simd_loop
from ..solver.adaptive import choose_model
from ..solver.cells import rows_of
from ..solver.kernel.rows import LANES
from ..solver.kernel.trace import SAMPLE
from ..solver.outcome import FAILED
from ..solver.settings import MOVE
from ..study import Study
from .history import warn_of_travel

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

VARIABLES = variables("traces")
VARIABLES["energy"]["clipped_at"] = VARIABLES["beam_energy"]["clipped_at"] = ENERGY_REACH
MOST = 1e30
"""Of what a failed run blew up to, all that is kept."""


def trace(study: Study, cube: xr.Dataset, earlier: xr.Dataset | None = None) -> xr.Dataset:
    """Follow the cells of a study's cube again, at its steps, and keep their motion.

    A cell of `auto` is followed by the level that decided it, and a cell of `reference` by the same
    elements in their modes.
    earlier: traces of the same study on other axes, from which cells are taken that the same code
        followed
    Returns the variables of VARIABLES, (bin, *axes), and the length of the bins, (*axes); NaN where
    there is no device.
    """
    cube = thin(cube.sortby([key for key in cube.outcome.dims if key not in NAMES]))
    grid, settings = grid_of(study, cube), study.settings
    levels = _levels(grid.device, study.model)
    level = cube.level.values.ravel() if "level" in cube else np.zeros(cube.outcome.size, int)
    halvings = cube.halvings.values.ravel()
    rows, N = rows_of(grid), grid.axes["N"]
    cells = rows.cells(grid.device, N, settings.horizon).flat()
    device_of = cells.device
    window = _window(grid.device, cube, cells, settings)
    bins = next((n for n in BINS if n * len(VARIABLES) * device_of.size <= BYTES), BINS[-1])
    made_by = recipe(json.loads(cube.attrs["config"]), grid.pulses, bins)
    values, bin_length, stress, known = _recall(earlier, grid, made_by, bins)
    new = ~known & (device_of >= 0)
    for number, halved in np.unique([level[new], halvings[new]], axis=1).T:
        some = np.flatnonzero(new & (level == number) & (halvings == halved))
        stepped = levels[number].with_step(0.5**halved)
        for mine, part in stepped.split(device_of[some]):
            which = some[mine]
            alike = cells.take(which)
            found = _follow(part, alike, window[which], bins, settings.threads)
            values[..., which], bin_length[which] = _shown(*found[:2], window[which])
            stress[which] = found[2]
    y = values[2] - values[2, 0]
    ran = np.isfinite(y).all(axis=0) & (cube.outcome.values.ravel() != FAILED)
    if ran.any():
        extremes = y[:, ran].min(axis=0), y[:, ran].max(axis=0)
        warn_of_travel(grid.device.pick(device_of[ran]), *extremes)
    named = dict(zip(VARIABLES, values, strict=True))
    if np.isfinite(grid.device.strength).any():
        named["stress_max"] = stress
    return _dress(grid, cube, named, bin_length, levels[0]).assign_attrs(recipe=made_by)


def thin(cube: xr.Dataset) -> xr.Dataset:
    """Keep every nth value of the longest axes, so that no more than CELLS cells are left."""
    strides = dict.fromkeys(reversed(cube.outcome.dims), 1)

    def left(key):
        return -(-cube.sizes[key] // strides[key])

    while math.prod(map(left, strides)) > CELLS:
        # Where C is short, as it is, only f0 and N are thinned.
        strides[max(strides, key=left)] += 1
    return cube.isel({key: slice(None, None, stride) for key, stride in strides.items()})


def grid_of(study: Study, cube: xr.Dataset) -> Grid:
    """Set out the points of a cube's axes again."""
    axes = {key: cube[key].values for key in cube.outcome.dims}
    names = {key: axes.pop(key).tolist() for key in NAMES if key in axes}
    return replace(study.part(names), skip=True).set_out(axes)


def _levels(device, model):
    """A model with modes for each level of the cube's."""
    name = "handout" if model["name"] == "reference" else model["name"]
    return choose_model(device, {**model, "name": name}).levels


def _window(device, cube, cells, settings):
    """How long each cell is shown, us."""
    # ASSUME: a settled cell is shown for one swing of the mass beyond its proof, the others to
    # the horizon, as what follows there is open, or to the snap where the sweep ended there: its
    # step need not be fine enough for what comes after.
    swing = 2 * np.pi / device.own_frequency[cells.device]
    settled, snap = cube.t_settled.values.ravel(), cube.t_snap.values.ravel()
    ended = np.fmin(cells.t_end, snap) if settings.until == "snap" else cells.t_end
    return np.where(np.isnan(settled), ended, settled + swing)


def _follow(model, cells, window, bins, threads):
    """Values, (variables, bins, cells), lengths of the bins, us, and the largest stress, MPa.

    window: time followed, us
    """
    first, barrier = model.barrier.first[cells.device], model.barrier.energy[cells.device]
    device = model.device
    gap = np.where(device.is_alone, np.nan, device.gap)
    origin = np.stack([first, first, first + gap[cells.device]])
    dt = model.steps.of(cells, MOVE)
    width = SAMPLE * np.ceil(window / (bins * SAMPLE * dt)).astype(np.int64)
    values, stress = np.empty((len(VARIABLES), bins, width.size)), np.full(width.size, np.nan)
    rows = None
    if np.isfinite(device.strength).any():
        rows = simd_loop.stress_rows(model)[cells.device]
    # Lanes run together to the end of the longest: those of one call should be of one length.
    order = np.argsort(width, kind="stable")

    def follow(some):
        asked = None if rows is None else rows[some]
        w_range, instants, stress[some] = simd_loop.trace(
            model, cells.take(some), dt[some], width[some], bins, asked
        )
        # Half way through the step in which it bounces the mass is beyond a stop.
        which = cells.device[some]
        np.clip(instants[0], -device.stop_toward[which], device.stop_away[which], instants[0])
        values[:3, :, some] = origin[:, np.newaxis, some] + np.concatenate([w_range, instants[:1]])
        with np.errstate(divide="ignore", invalid="ignore"):  # no barrier: nothing is below it
            values[3:, :, some] = instants[1:] / barrier[some]
        count(some.size)

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow, np.split(order, range(LANES, order.size, LANES))))
    return values, width * dt, stress


def _shown(values, bin_length, window):
    """Values as they are kept: beyond the window, where a run may blow up, as far as within it."""
    begins = np.arange(values.shape[1])[:, np.newaxis] * bin_length
    within = {"axis": 1, "keepdims": True, "where": begins < window}
    with np.errstate(invalid="ignore"):
        low, high = values.min(**within, initial=MOST), values.max(**within, initial=-MOST)
        low[3:], high[3:] = 0.0, np.fmin(high[3:], ENERGY_REACH)
        values = np.clip(values, np.fmax(low, -MOST), np.fmin(high, MOST))
    return np.where(np.isfinite(values), values, np.nan), bin_length


def _recall(earlier, grid, recipe, bins):
    """Values, lengths of bins and stress that earlier traces hold, and which cells they are of."""
    n_cells = math.prod(grid.shape)
    values = np.full((len(VARIABLES), bins, n_cells), np.nan, np.float32)
    bin_length, known = np.zeros(n_cells, np.float32), np.zeros(n_cells, bool)
    stress = np.full(n_cells, np.nan, np.float32)
    if earlier is None or earlier.attrs.get("recipe") != recipe:
        return values, bin_length, stress, known
    place, there = (np.ix_(*side) for side in shared_points(grid.axes, earlier))
    for whole, key in zip(values, VARIABLES, strict=True):
        whole.reshape(bins, *grid.shape)[:, *place] = earlier[key].values[:, *there]
    bin_length.reshape(grid.shape)[place] = earlier.bin_length.values[there]
    if "stress_max" in earlier:
        stress.reshape(grid.shape)[place] = earlier.stress_max.values[there]
    known.reshape(grid.shape)[place] = True
    return values, bin_length, stress, known


def _dress(grid, cube, values, bin_length, model):
    dims = cube.outcome.dims
    data = {}
    for key, attributes in VARIABLES.items():
        data[key] = (("bin", *dims), values[key].reshape(-1, *grid.shape), attributes, DIGITS)
    length = {"long_name": "length of the time bins", "units": "us"}
    data["bin_length"] = (dims, bin_length.reshape(grid.shape), length)
    if "stress_max" in values:
        told = {"long_name": "largest tensile stress in the beam", "units": "MPa"}
        data["stress_max"] = (dims, values["stress_max"].reshape(grid.shape), told)
    of_device, barrier = dims[: grid.device_of.ndim], _barrier_of(model)
    shown = {
        "second_equilibrium": (barrier.second, "midpoint of the second stable shape"),
        "saddle": (barrier.first + barrier.midpoint, "midpoint of the saddle between both"),
        "barrier": (barrier.energy, "energy of the saddle"),
    }
    if "stress_max" in values:
        strength = grid.device.strength + grid.device.strength_threshold
        shown["strength"] = (strength, "strength of the beam, if Weibull's, where 63 % break")
    for key, (column, name) in shown.items():
        spread = np.where(grid.device_of < 0, np.nan, column[np.maximum(grid.device_of, 0)])
        unit = {"barrier": "pJ", "strength": "MPa"}.get(key, "um")
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
    for mine, part in model.split(np.arange(found.shape[1])):
        found[:, mine] = [column[mine] for column in part.barrier]
    return Barrier(*found)

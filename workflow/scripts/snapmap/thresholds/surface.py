"""The threshold surface over damping and frequency as an xarray dataset."""

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Annotated, Unpack

import numpy as np
import xarray as xr

from ..device import argument
from ..device.quantities import plain
from ..pulse.pulse import blow_at
from ..solver.adaptive import Survey, choose_survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Settings
from ..study import arguments
from ..study.axes import PULSE_AXES, rows_of
from ..study.study import THRESHOLD_SETTINGS, Study, study_of
from ..study.variables import dress, flags
from .cost import tell_cost
from .search import nearby
from .settling import lowest_latched
from .slow import growth_rate, slow_factor
from .survey import (
    CLOSE_STEP,
    FOUND,
    ISLAND_STEP,
    ISLANDS_TO,
    NOT_FOLLOWED,
    NOTHING_SNAPS,
    RAGGED_STEP,
    STATUS,
    is_fast,
    is_ringing,
    look_closely,
    lowest,
    snap_times,
    survey,
    with_rows,
)
from .verified import SNAPS_AT, WITHIN, Expected, expected_labels, fill, initial_rows, surfaces

IMPULSE, IMPULSE_OF_BEAM = 100.0, 10.0
"""A pulse of so many times the device's own frequency, and the beam's, is as good as a jump in
velocity."""

SLOWNESS = 0.02
"""Frequency, over the device's own, of a pulse that stands for a long one where it jumps."""
NO_AREA = 1e-3
"""A pulse of less area leaves no change of velocity by which it could trip."""
ROWS = 4096
"""Rows looked at together: each takes some 70 kB."""

COMMENT = (
    f"in multiples of g; narrower stretches may lie below: than {2 * CLOSE_STEP:.2%} of N near a "
    f"clean threshold of a fast pulse, {RAGGED_STEP:.2%} near a ragged one, {ISLAND_STEP:.1%} "
    "elsewhere"
)


class SurfaceOptions(arguments.ThresholdOptions, arguments.AxisOptions, total=False):
    """Options of `threshold`."""


def threshold(
    device: arguments.Devices,
    f0: arguments.Frequencies | None,
    C: arguments.Dampers,
    model: arguments.Model = "auto",
    tolerance: arguments.Refinement = THRESHOLD_TOLERANCE,
    highest: Annotated[float, argument.number("(0, inf)", "multiples of g", "2000")] | None = None,
    **options: Unpack[SurfaceOptions],
) -> xr.Dataset:
    """Find the lowest N that snaps the beam, with error bars, over C (uN us/um) and f0 (Hz).

    tolerance: relative refinement of N
    highest: largest N searched for islands, multiples of g; None for twice the threshold
    options: horizon, energy_tolerance, threads, start, pulse, direction, skip,
        device axes, model options
    The Dataset holds `N_first`, `N_latched` and their errors over (..., C, f0). Only the digits
    that `N_error` allows count, as sharp thresholds lie on a lattice of relative step `tolerance`.
    `N_static` and `velocity_change` are the limits of slow and short pulses; `N_slow` is the
    threshold of slow pulses by their `dwell` (us) above N_static. A pulse changes the velocity by
    `area` N g / f0; `scale_first` is the factor on a record in known units. The words of `status`
    are `numpy.array(found.status.flag_meanings.split())[found.status]`.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> found = snapmap.threshold(device, [1500], [25], model="cosines", thickness=[1.9, 2.0])
    >>> found.N_first.squeeze().round().values.tolist()
    [893.0, 990.0]
    """
    study, axes = study_of(device, model, options, C=C, f0=f0)
    return thresholds_of(study, axes, tolerance, highest)


def thresholds_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
) -> xr.Dataset:
    """Find the thresholds of a study, as `threshold` returns them.

    axes: values of the device, C and f0, by name; tolerance, highest: as there
    """
    settings = study.settings
    document = study.document(THRESHOLD_SETTINGS)
    document["sweep"]["threshold_tolerance"] = tolerance
    grid, models, columns = _search(study, axes, tolerance, highest)
    rows = rows_of(grid)
    exists = rows.device >= 0
    columns["N_bound"] += np.nan if models.lawful else 0.0
    N_first, N_latched = columns["N_first"], np.full(exists.size, np.nan)
    first = N_first[exists]
    top = ISLANDS_TO * first if highest is None else highest
    top = np.where(np.isnan(first), np.nan, top)
    # A clean threshold is latched from the upper end of its bar: within it, steps to the end of a
    # run may not snap where those to a snap do.
    bar = np.where(columns["ragged"] == 0, columns["N_error"], 0.0)[exists]
    low = np.where(first + bar <= top, first + bar, np.nan)
    warn_of_bars(N_first, columns["N_error"], tolerance)
    latched = lowest_latched(models.decides, rows.take(exists), low, top, settings)
    N_latched[exists] = np.where(latched == low, first, latched)
    columns["N_latched"] = N_latched
    peak = np.array([pulse.peak for pulse in rows.pulses])
    if np.isfinite(peak).any():
        columns["scale_first"] = N_first * grid.device.gravity[rows.device] / peak[rows.pulse]
    data = _variables(grid, columns) | _limits(grid, models, settings, tolerance)
    data |= _slow(grid, rows, models.static, settings)
    data["status"] = *data["status"], flags(STATUS)
    data["N_first"] = *data["N_first"], {"comment": COMMENT}
    gravity = float(grid.device.gravity[0])
    return dress("threshold", xr.Dataset(data, grid.axes), document, gravity=gravity)


def first_snaps(
    study: Study, axes: Mapping[str, Sequence[float]], tolerance: float = THRESHOLD_TOLERANCE
) -> xr.Dataset:
    """Find the thresholds of a study alone, without limits and latching; arguments as above."""
    grid, _, columns = _search(study, axes, tolerance)
    return xr.Dataset(_variables(grid, columns), grid.axes)


def _search(study, axes, tolerance, highest=None):
    """Find the thresholds of a study: its grid, the models, and the variables, (rows, ...)."""
    settings, grid = study.settings, study.set_out(axes)
    models, rows = choose_survey(grid.device, study.model, settings.start), rows_of(grid)
    exists = rows.device >= 0
    rings = exists & is_ringing(grid.device, rows)
    slow = ~rings.reshape(-1, grid.axes["f0"].size).any(axis=0)
    numbers = np.where(exists, np.arange(exists.size), -1)
    parts = surfaces(grid.axes, numbers.reshape(grid.shape), slow)
    searched = _beside(exists, parts)
    searched[initial_rows(parts)] = True
    tell_cost(models, rows.take(searched), settings)
    return grid, models, find_thresholds(models, rows, parts, settings, tolerance, highest)


def _variables(grid, columns):
    """Give the dimensions of variables of a grid, (rows, ...), and their shapes."""
    dims, last = (*grid.axes, "island"), len(grid.shape) - 1
    return {
        key: (dims[: last + values.ndim], values.reshape(*grid.shape, *values.shape[1:]))
        for key, values in columns.items()
    }


def warn_of_bars(N: np.ndarray, error: np.ndarray, tolerance: float) -> None:
    """Warn, in one line, that bars stay wider than a tolerance below the default.

    N, error: multiples of g, (rows,), NaN where there is no threshold
    """
    bars = (error / N)[np.isfinite(N)]
    wider = bars[bars > 2 * tolerance]
    if tolerance < THRESHOLD_TOLERANCE and wider.size:
        warnings.warn(
            f"tolerance: {tolerance:g} bounds only the refinement; errors of model and step make "
            f"N_error wider in {wider.size} of {bars.size} rows, {np.median(wider):.1g} of "
            "N in the median",
            stacklevel=2,
        )


def find_thresholds(
    models: Survey,
    rows: Rows,
    parts: Sequence[tuple[np.ndarray, Sequence[np.ndarray]]],
    settings: Settings,
    tolerance: float,
    highest: float | None = None,
) -> dict[str, np.ndarray]:
    """Find the thresholds of all rows: variables by name, (rows, ...).

    parts: surfaces, as from `verified.surfaces`
    """
    columns = {}

    def add(which, new):
        for key, values in new.items():
            columns[key] = with_rows(rows.f0.size, which, values, columns.get(key))

    def search(which):
        for block in _blocks(which) if which.size or not columns else []:
            new = survey(models, rows.take(block), settings, tolerance, highest)
            add(block, new._asdict() | {"verified": np.zeros(block.size, np.int8)})
        N = columns["N_first"][which]
        alone = (columns["ragged"][which] == 0) & (columns["islands"][which] == 0)
        bar, level = columns["N_error"][which] / N, columns["level"][which]
        return Expected(N=N, bar=bar, level=level, clean=np.isfinite(N) & alone)

    def verify(which, expected):
        holds = np.zeros(which.size, bool)
        for block in _blocks(np.arange(which.size)):
            part, near = rows.take(which[block]), Expected(*(column[block] for column in expected))
            new = _verify(models, part, settings, tolerance, highest, near)
            holds[block] = here = np.isfinite(new["N_first"])
            add(which[block][here], {key: values[here] for key, values in new.items()})
        return holds

    search(np.flatnonzero(_beside(rows.device >= 0, parts)))
    for part in parts:
        fill(*part, search, verify)
    if any(pulse.blows.size for pulse in rows.pulses):
        columns["blow"] = blow_at(rows.pulses, rows.pulse, columns["t_snap"] * rows.f0 * 1e-6)
    most = columns["islands"].max(initial=0)
    return columns | {key: columns[key][:, :most] for key in ("island_from", "island_to")}


def _beside(exists, parts):
    """Tell which rows exist, but on no surface, (rows,)."""
    beside = exists.copy()
    for numbers, _ in parts:
        beside[numbers[numbers >= 0]] = False
    return beside


def _blocks(rows):
    return np.split(rows, range(ROWS, rows.size, ROWS))


def _verify(models, rows, settings, tolerance, highest, expected):
    """Find thresholds of rows where they are expected, by name; N_first is NaN for no such."""
    N_first, t_snap = np.full((2, rows.f0.size), np.nan)
    device, finest = models.decides.device, len(models.levels) - 1
    rings = is_ringing(device, rows)
    of_row = np.maximum(expected.level, np.minimum(is_fast(device, rows), finest))
    for number, level in enumerate(models.levels):
        which = np.flatnonzero(of_row == number)
        part, N = rows.take(which), expected.N[which]
        N = np.where(expected_labels(level.decides, part, settings, N), N, np.nan)
        ends = nearby(level.decides, part, settings, N, tolerance)
        ways = settings, tolerance, rings[which]
        close, begins, *_ = look_closely(level.decides, part, *ways, *ends)
        once = ~begins & (np.bincount(close.row, minlength=N.size) == 1)
        close = close.take(once[close.row])
        first = np.full(N.size, np.nan)
        first[close.row] = close.high
        holds = abs(first - N) <= max(WITHIN, tolerance) * N
        N_first[which] = N = np.where(holds, first, np.nan)
        t_snap[which] = snap_times(level.decides, part, settings, N)
    top = np.inf if highest is None else highest
    none = np.zeros(rows.f0.size, np.int8)
    error = (expected.bar + tolerance) * N_first + abs(N_first - expected.N)
    return {
        "status": none + np.int8(FOUND),
        "N_bound": least_amplitudes(models.decides, rows, settings.start),
        "N_looked": expected.N * SNAPS_AT[-1],
        "N_first": N_first,
        "N_error": error,
        "ragged": none,
        "N_always": np.where(N_first <= top, N_first, np.nan),
        "t_snap": t_snap,
        "level": of_row.astype(np.int8),
        "islands": none.astype(int),
        "island_from": np.empty((none.size, 0)),
        "island_to": np.empty((none.size, 0)),
        "verified": none + np.int8(1),
    }


def _lowest_of(grid, models, settings, tolerance, omega, which, is_short):
    """Find N_first, (..., pulses, C), of short or long pulses of a frequency, rad/us, (devices,).

    Of short ones beside surfaces the finest models find it; on these, only in rows searched first.
    """
    grid = grid._replace(axes=grid.axes | {"f0": np.ones(1)})
    rows = rows_of(grid)
    rows = rows._replace(f0=omega[rows.device] / (2 * np.pi) * 1e6)
    exists, N = (rows.device >= 0) & np.isin(rows.pulse, which), np.full(rows.f0.size, np.nan)
    numbers = np.where(exists, np.arange(N.size), -1).reshape(grid.shape)
    parts = surfaces(grid.axes, numbers, np.zeros(1, bool))
    beside = _beside(exists, parts)
    best = models.levels[-1] if is_short else models
    N[beside] = lowest(best, rows.take(beside), settings, tolerance)
    surface = np.sort(initial_rows(parts)) if is_short else np.flatnonzero(exists & ~beside)
    N[surface] = lowest(models, rows.take(surface), settings, tolerance)
    return N.reshape(grid.shape[:-1])


def _limits(grid, models, settings, tolerance):
    """Find thresholds of slow and short pulses, of trains their strongest blow; and their area."""
    device, exists = grid.device, grid.device_of >= 0
    frequency, of_beam = device.own_frequency, device.beam.bending_frequency
    fast, slow = np.maximum(IMPULSE * frequency, IMPULSE_OF_BEAM * of_beam), SLOWNESS * frequency
    alone = grid._replace(pulses=tuple(pulse.alone for pulse in grid.pulses))
    of_pulse = {key: grid.axes[key] for key in PULSE_AXES if key in grid.axes}
    sizes = tuple(values.size for values in of_pulse.values())
    of_device = tuple(grid.axes)[: exists.ndim]

    def spread(values):
        """Spread values of devices, (devices,), over their axes and those of the pulse."""
        values = np.where(exists, values[grid.device_of], np.nan)
        return values.reshape(exists.shape + (1,) * len(sizes))

    area = np.array([pulse.area for pulse in alone.pulses])
    # A force shakes no frame.
    pushes = np.flatnonzero((abs(area) > NO_AREA) & np.all(device.force == 0))
    options = models, settings, tolerance
    change = _lowest_of(alone, *options, fast, pushes, is_short=True)
    scale = spread(device.gravity * (2 * np.pi / fast)) * abs(area).reshape(sizes)
    change *= scale[..., np.newaxis]
    impact = np.array([pulse.impact for pulse in grid.pulses])
    ahead = [pulse if settings.start == FIRST else pulse.reversed() for pulse in grid.pulses]
    presses = np.array([pulse.highest for pulse in ahead])
    static = spread(models.static * (np.nan if models.lawful else 1.0)) / np.where(
        presses > 0, presses, np.nan
    ).reshape(sizes)
    jumps = np.flatnonzero([any(pulse.ends) for pulse in grid.pulses])
    if jumps.size:
        at_least = alone._replace(axes=grid.axes | {"C": grid.axes["C"][:1]})
        slowly = _lowest_of(at_least, *options, slow, jumps, is_short=False)[..., 0]
        static = np.where(np.isin(np.arange(presses.size), jumps).reshape(sizes), slowly, static)
    return {
        "N_static": ((*of_device, *of_pulse), static),
        "velocity_change": ((*of_device, *of_pulse, "C"), change),
        "area": (tuple(of_pulse), abs(impact).reshape(sizes)),
    }


def _slow(grid, rows, static, settings):
    """Find for how long devices withstand more than the static threshold; slow thresholds by it."""
    of_C = growth_rate(grid.device, grid.axes["C"][:, np.newaxis]).T
    of_C = of_C if settings.start == FIRST else np.nan * of_C
    rate = np.where((grid.device_of >= 0)[..., np.newaxis], of_C[grid.device_of], np.nan)
    C = np.arange(of_C.shape[1])[:, np.newaxis]
    swings = 1e6 * of_C[rows.device.reshape(grid.shape), C].ravel() / rows.f0
    factor = np.full(swings.shape, np.nan)
    for number, pulse in enumerate(rows.pulses):
        which = (rows.pulse == number) & (rows.device >= 0) & np.isfinite(swings)
        factor[which] = slow_factor(pulse, swings[which])
    N = factor * static[rows.device]
    of_device = tuple(grid.axes)[: grid.device_of.ndim]
    return {
        "dwell": ((*of_device, "C"), 2 / rate),
        "N_slow": (tuple(grid.axes), N.reshape(grid.shape)),
    }


def to_digits(N: float, error: float) -> str:
    """Write a threshold to the digits that its bar allows, at most four; to all if it has none."""
    known = math.floor(math.log10(N)) - math.floor(math.log10(error)) if error > 0 else 3
    return plain(N, min(max(known, 0), 3) + 1)


def summary(thresholds: xr.Dataset, lowest: float = -np.inf, highest: float = np.inf) -> str:
    """Sum up thresholds in one line: their range, ragged ones, errors, and the weaker side.

    lowest, highest: N of a grid; the line says where they are on one side of all thresholds
    """
    N_first, status = thresholds.N_first, thresholds.status
    there = np.isfinite(N_first.values)
    N, error = N_first.values[there], thresholds.N_error.values[there]
    ends = [to_digits(N[i], error[i]) for i in (N.argmin(), N.argmax())] if N.size else []
    ends = f"from N = {' to '.join(ends)}, " if N.size else ""
    known = (error / N)[np.isfinite(error)]
    typical = f"{np.median(known):.2%}" if known.size else "unknown"
    ragged = int(thresholds.ragged.where(N_first.notnull(), 0).sum())
    line = (
        f"{N.size} of {N_first.size} thresholds found, {ends}"
        f"{ragged} of them ragged, {int((known > 0.01).sum())} with an error above 1 %, "
        f"median {typical}"
    )
    for number in (NOTHING_SNAPS, NOT_FOLLOWED):
        if count := int((status == number).sum()):
            line += f"; {STATUS[number].replace('_', ' ')} in {count}"
    beyond = {
        "above": N_first < lowest,
        "below": (N_first > highest) | (status == NOTHING_SNAPS) & (highest < np.inf),
    }
    for side, rows in beyond.items():
        maps = rows.all("f0")
        if maps.any():
            where = f" in {int(maps.sum())} of {maps.size} maps" if maps.size > 1 else ""
            line += f"; the grid lies wholly {side} the threshold{where}"
    if thresholds.sizes.get("direction", 1) < 2:
        return line
    # Where nothing snaps, the other side is the weaker one.
    weaker = N_first.fillna(np.inf).idxmin("direction").where(N_first.notnull().any("direction"))
    sides = [f"{side} in {int((weaker == side).sum())} rows" for side in N_first.direction.values]
    return f"{line}; weaker along {', '.join(sides)}"

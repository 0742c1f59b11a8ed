"""The threshold surface over damping and frequency as an xarray dataset."""

import math
import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Annotated, Unpack

import numpy as np
import xarray as xr

from ..device import argument
from ..files.text import plain
from ..pulse.pulse import blow_at
from ..solver.adaptive import Survey, choose_survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.kept import kept
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Run
from ..study import arguments
from ..study.axes import Grid, rows_of
from ..study.study import OF_THRESHOLDS, Study, study_of
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
    is_single,
    look_closely,
    lowest,
    snap_times,
    survey,
    with_rows,
)
from .verified import SNAPS_AT, WITHIN, Expected, expected_labels, fill, initial_rows, surfaces

IMPULSE, IMPULSE_OF_BEAM = 100.0, 10.0
"""Frequency, over the device's own and over the beam's, of a pulse that stands for a jump in
velocity."""

SLOWNESS = 0.02
"""Frequency, over the device's own, of a pulse that stands for a long one, if pulses jump."""
NO_AREA = 1e-3
"""Area below which a pulse leaves no change of velocity that could trip."""
ROWS = 4096
"""Number of rows that are searched together; each takes some 70 kB."""

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
    The Dataset holds `N_first`, its error `N_error`, and `N_latched` over (..., C, f0). Thresholds
    are places on a lattice of relative step `tolerance`: only the digits that `N_error` allows
    count. `N_static` and `velocity_change` (m/s) are the limits of slow and short pulses. `N_slow`
    is the law of slow pulses, by their `dwell` (us) above N_static. A pulse changes the velocity by
    `area` N g / f0. `scale_first` is the factor on a record in known units. `status` is an index
    into the words `thresholds.status.flag_meanings.split()`.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> thresholds = snapmap.threshold(device, [1500], [25], model="cosines", thickness=[1.9, 2.0])
    >>> thresholds.N_first.squeeze().round().values.tolist()
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

    axes: values of the device, C and f0, by name; tolerance, highest: as for `threshold`
    """
    settings = study.run
    document = study.document(OF_THRESHOLDS)
    document["sweep"]["threshold_tolerance"] = tolerance
    grid, rows, models, columns = _search(study, axes, tolerance, highest)
    columns["N_bound"][least_amplitudes(models.decides, rows, settings.start) == 0] = np.nan
    warn_of_bars(columns["N_first"], columns["N_error"], tolerance)
    columns["N_latched"] = _find_latched(models.decides, rows, columns, settings, highest)
    peak = np.array([pulse.peak for pulse in rows.pulses])
    if np.isfinite(peak).any():
        acceleration = columns["N_first"] * grid.device.gravity[rows.device]
        columns["scale_first"] = acceleration / peak[rows.pulse]
    data = _variables(grid, columns) | _limits(grid, study, models, tolerance)
    data |= _slow(grid, rows, models, settings)
    data["status"] = *data["status"], flags(STATUS)
    data["N_first"] = *data["N_first"], {"comment": COMMENT}
    gravity = float(grid.device.gravity[0])
    return dress("threshold", xr.Dataset(data, grid.axes), document, gravity=gravity)


def first_snaps(
    study: Study, axes: Mapping[str, Sequence[float]], tolerance: float = THRESHOLD_TOLERANCE
) -> xr.Dataset:
    """Find the thresholds of a study as `thresholds_of` does, but no limits and no N_latched."""
    grid, _, _, columns = _search(study, axes, tolerance)
    return xr.Dataset(_variables(grid, columns), grid.axes)


def _search(study, axes, tolerance, highest=None):
    """Find the thresholds of a study; returns grid, rows, models and variables, (rows, ...)."""
    settings, grid = study.run, study.set_out(axes)
    models, rows = choose_survey(grid.device, study.model, settings.start), rows_of(grid)
    parts, searched = split_rows(grid, rows)
    tell_cost(models, rows.take(searched), settings)
    return grid, rows, models, find_thresholds(models, rows, parts, settings, tolerance, highest)


def split_rows(
    grid: Grid, rows: Rows
) -> tuple[list[tuple[np.ndarray, Sequence[np.ndarray]]], np.ndarray]:
    """Find the surfaces of a grid, and which of its rows are searched at first, (rows,).

    The thresholds of the other rows are expected between those, and verified.
    """
    exists = rows.device >= 0
    rings = exists & is_ringing(grid.device, rows)
    slow = ~rings.reshape(-1, grid.axes["f0"].size).any(axis=0)
    numbers = np.where(exists, np.arange(exists.size), -1)
    parts = surfaces(grid.axes, numbers.reshape(grid.shape), slow)
    searched = _beside(exists, parts)
    searched[initial_rows(parts)] = True
    return parts, searched


def _find_latched(model, rows, columns, settings, highest):
    """Find N_latched, (rows,), from the thresholds up; highest: as for `threshold`."""
    exists = rows.device >= 0
    first, error, ragged = (columns[key][exists] for key in ("N_first", "N_error", "ragged"))
    top = np.where(np.isnan(first), np.nan, ISLANDS_TO * first if highest is None else highest)
    # The search begins at the upper end of a clean threshold's bar: within it, the time steps of a
    # whole run may not snap where those of a run to the snap do.
    low = first + np.where(ragged == 0, error, 0.0)
    low = np.where(low <= top, low, np.nan)
    latched = lowest_latched(model, rows.take(exists), low, top, settings)
    N_latched = np.full(exists.size, np.nan)
    N_latched[exists] = np.where(latched == low, first, latched)
    return N_latched


def _variables(grid, columns):
    """Give variables, (rows, ...), the shape of the grid, each with its dimensions."""
    dims, last = (*grid.axes, "island"), len(grid.shape) - 1
    return {
        key: (dims[: last + values.ndim], values.reshape(*grid.shape, *values.shape[1:]))
        for key, values in columns.items()
    }


def warn_of_bars(N: np.ndarray, error: np.ndarray, tolerance: float) -> None:
    """Warn, in one line, that error bars are wider than a tolerance below the default one.

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
    settings: Run,
    tolerance: float,
    highest: float | None = None,
) -> dict[str, np.ndarray]:
    """Find the thresholds of all rows; returns variables by name, (rows, ...).

    parts: surfaces, as `verified.surfaces` returns them; highest: as for `survey`
    """
    columns = {}

    def add(which, new):
        for key, values in new.items():
            columns[key] = with_rows(rows.f0.size, which, values, columns.get(key))

    def search(which):
        # The first search makes the columns, even if it is of no rows.
        for block in _blocks(which) if which.size or not columns else []:
            new = survey(models, rows.take(block), settings, tolerance, highest)
            add(block, new._asdict() | {"verified": np.zeros(block.size, np.int8)})
        N = columns["N_first"][which]
        clean = (columns["ragged"][which] == 0) & (columns["islands"][which] == 0)
        bar, level = columns["N_error"][which] / N, columns["level"][which]
        return Expected(N=N, bar=bar, level=level, clean=np.isfinite(N) & clean)

    def verify(which, expected):
        holds = np.zeros(which.size, bool)
        for block in _blocks(np.arange(which.size)):
            near = Expected(*(values[block] for values in expected))
            new = _verify(models, rows.take(which[block]), settings, tolerance, highest, near)
            holds[block] = verified = np.isfinite(new["N_first"])
            add(which[block][verified], {key: values[verified] for key, values in new.items()})
        return holds

    search(np.flatnonzero(_beside(rows.device >= 0, parts)))
    for part in parts:
        fill(*part, search, verify)
    if any(pulse.blows.size for pulse in rows.pulses):
        columns["blow"] = blow_at(rows.pulses, rows.pulse, columns["t_snap"] * rows.f0 * 1e-6)
    most = columns["islands"].max(initial=0)
    return columns | {key: columns[key][:, :most] for key in ("island_from", "island_to")}


def _beside(exists, parts):
    """Tell which rows exist but lie on no surface, (rows,)."""
    beside = exists.copy()
    for numbers, _ in parts:
        beside[numbers[numbers >= 0]] = False
    return beside


def _blocks(rows):
    return np.split(rows, range(ROWS, rows.size, ROWS))


def _verify(models, rows, settings, tolerance, highest, expected):
    """Verify thresholds where they are expected; returns variables by name, (rows, ...).

    N_first is NaN where no threshold is within WITHIN of the expected one.
    """
    N_first, t_snap = np.full((2, rows.f0.size), np.nan)
    device, finest = models.decides.device, len(models.levels) - 1
    rings = is_ringing(device, rows)
    level_of = np.maximum(expected.level, np.minimum(is_fast(device, rows), finest))
    for number, level in enumerate(models.levels):
        which = np.flatnonzero(level_of == number)
        model, part, N = level.decides, rows.take(which), expected.N[which]
        N = np.where(expected_labels(model, part, settings, N), N, np.nan)
        ends = nearby(model, part, settings, N, tolerance)
        seen = look_closely(model, part, settings, tolerance, rings[which], *ends)
        single = seen.edges.take(is_single(seen.edges, seen.begins)[seen.edges.row])
        first = np.full(N.size, np.nan)
        first[single.row] = single.high
        holds = abs(first - N) <= max(WITHIN, tolerance) * N
        N_first[which] = N = np.where(holds, first, np.nan)
        t_snap[which] = snap_times(model, part, settings, N)
    top = np.inf if highest is None else highest
    zero = np.zeros(rows.f0.size, np.int8)
    return {
        "status": zero + np.int8(FOUND),
        "N_bound": least_amplitudes(models.decides, rows, settings.start),
        "N_looked": expected.N * SNAPS_AT[-1],
        "N_first": N_first,
        "N_error": (expected.bar + tolerance) * N_first + abs(N_first - expected.N),
        "ragged": zero,
        "N_always": np.where(N_first <= top, N_first, np.nan),
        "t_snap": t_snap,
        "level": level_of.astype(np.int8),
        "islands": zero.astype(int),
        "island_from": np.empty((zero.size, 0)),
        "island_to": np.empty((zero.size, 0)),
        "verified": zero + np.int8(1),
    }


def _lowest_of(grid, models, settings, tolerance, omega, which, is_short):
    """Find N_first, (..., pulses, C), of pulses of a frequency omega, rad/us, (devices,).

    which: indices of the pulses; is_short: whether these are short, or else long
    Short pulses are searched by the finest models, but on surfaces only in the initial rows.
    """
    grid = grid._replace(axes=grid.axes | {"f0": np.ones(1)})
    rows = rows_of(grid)
    rows = rows._replace(f0=omega[rows.device] / (2 * np.pi) * 1e6)
    exists, N = (rows.device >= 0) & np.isin(rows.pulse, which), np.full(rows.f0.size, np.nan)
    numbers = np.where(exists, np.arange(N.size), -1).reshape(grid.shape)
    parts = surfaces(grid.axes, numbers, np.zeros(1, bool))
    beside = _beside(exists, parts)
    level = models.levels[-1] if is_short else models
    N[beside] = lowest(level, rows.take(beside), settings, tolerance)
    surface = np.sort(initial_rows(parts)) if is_short else np.flatnonzero(exists & ~beside)
    N[surface] = lowest(models, rows.take(surface), settings, tolerance)
    return N.reshape(grid.shape[:-1])


def _limits(grid, study, models, tolerance):
    """Find areas of pulses, and limits of slow and short ones; of a train's strongest blow."""
    first, last = grid.device_of.ndim, len(grid.axes) - 2
    dims, sizes = tuple(grid.axes), grid.shape[first:last]
    single = grid._replace(pulses=tuple(pulse.alone for pulse in grid.pulses))
    options = models, study.run, tolerance
    velocity = _find_velocity_change(single, study.model, *options, sizes)
    impact = np.array([pulse.impact for pulse in grid.pulses])
    return {
        "N_static": (dims[:last], _find_static(grid, single, *options, sizes)),
        "velocity_change": ((*dims[:last], "C"), velocity),
        "area": (dims[first:last], abs(impact).reshape(sizes)),
    }


def _spread(grid, values, sizes):
    """Spread values of devices, (devices,), over axes of the device, and add axes of the pulse."""
    values = np.where(grid.device_of >= 0, values[grid.device_of], np.nan)
    return values.reshape(values.shape + (1,) * len(sizes))


def _find_velocity_change(grid, model, models, settings, tolerance, sizes):
    """Find the velocity change that snaps, by short pulses, m/s, (..., *sizes, C).

    It is kept, as it takes half the time of a single threshold, and f0 does not matter.
    """
    device, area = grid.device, np.array([pulse.area for pulse in grid.pulses])
    frequency, of_beam = device.own_frequency, device.beam.bending_frequency
    fast = np.maximum(IMPULSE * frequency, IMPULSE_OF_BEAM * of_beam)
    # A force does not shake the frame, and so changes no velocity of it.
    pushes = np.flatnonzero((abs(area) > NO_AREA) & np.all(device.force == 0))
    find = partial(_lowest_of, grid, models, settings, tolerance, fast, pushes, is_short=True)
    axes = [(key, tuple(values)) for key, values in grid.axes.items() if key != "f0"]
    others = *axes, grid.device_of.tobytes(), grid.pulses, settings, tolerance
    N = kept(find, device, model, "short pulses", *others)
    scale = _spread(grid, device.gravity * (2 * np.pi / fast), sizes) * abs(area).reshape(sizes)
    return N * scale[..., np.newaxis]


def _find_static(grid, single, models, settings, tolerance, sizes):
    """Find the limit of long pulses, multiples of g, (..., *sizes); single: grid of single blows.

    A pulse that jumps has another limit than the static threshold; the least C gives it.
    """
    ahead = [pulse if settings.start == FIRST else pulse.reversed() for pulse in grid.pulses]
    press = np.array([pulse.highest for pulse in ahead])
    static = _spread(grid, models.static * (np.nan if models.lawful else 1.0), sizes)
    static = static / np.where(press > 0, press, np.nan).reshape(sizes)
    jumps = np.array([any(pulse.ends) for pulse in grid.pulses])
    if not jumps.any():
        return static
    single = single._replace(axes=grid.axes | {"C": grid.axes["C"][:1]})
    slow, which = SLOWNESS * grid.device.own_frequency, np.flatnonzero(jumps)
    N = _lowest_of(single, models, settings, tolerance, slow, which, is_short=False)[..., 0]
    return np.where(jumps.reshape(sizes), N, static)


def _slow(grid, rows, models, settings):
    """Give `dwell` and `N_slow`, the law of slow pulses."""
    of_C = growth_rate(grid.device, grid.axes["C"][:, np.newaxis]).T
    of_C = np.nan * of_C if models.lawful or settings.start != FIRST else of_C
    rate = np.where((grid.device_of >= 0)[..., np.newaxis], of_C[grid.device_of], np.nan)
    C = np.arange(of_C.shape[1])[:, np.newaxis]
    swings = 1e6 * of_C[rows.device.reshape(grid.shape), C].ravel() / rows.f0
    factor = np.full(swings.shape, np.nan)
    for number, pulse in enumerate(rows.pulses):
        which = (rows.pulse == number) & (rows.device >= 0) & np.isfinite(swings)
        factor[which] = slow_factor(pulse, swings[which])
    N = factor * models.static[rows.device]
    of_device = tuple(grid.axes)[: grid.device_of.ndim]
    return {
        "dwell": ((*of_device, "C"), 2 / rate),
        "N_slow": (tuple(grid.axes), N.reshape(grid.shape)),
    }


def to_digits(N: float, error: float) -> str:
    """Write a threshold to the digits that its error allows, at most four."""
    known = math.floor(math.log10(N)) - math.floor(math.log10(error)) if error > 0 else 3
    return plain(N, min(max(known, 0), 3) + 1)


def summary(thresholds: xr.Dataset, lowest: float = -np.inf, highest: float = np.inf) -> str:
    """Sum up thresholds in one line: their range, errors, ragged ones, and the weaker direction.

    lowest, highest: ends of a grid's N; the line says which maps lie on one side of the threshold
    """
    N_first, status = thresholds.N_first, thresholds.status
    exists = np.isfinite(N_first.values)
    N, error = N_first.values[exists], thresholds.N_error.values[exists]
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
    # If nothing snaps in one direction, the other is the weaker one.
    weaker = N_first.fillna(np.inf).idxmin("direction").where(N_first.notnull().any("direction"))
    sides = [f"{side} in {int((weaker == side).sum())} rows" for side in N_first.direction.values]
    return f"{line}; weaker along {', '.join(sides)}"

"""The threshold surface over damping and frequency as an xarray dataset, with its limits."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import xarray as xr

from ..pulse.pulse import make_pulse
from ..solver.adaptive import choose_survey
from ..solver.bounds import least_amplitudes
from ..solver.cost import steps_and_seconds
from ..solver.kept import kept
from ..solver.options import Chosen
from ..solver.outcome import LATCHED, REPEATED_STEP, label
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE
from ..study.arguments import AnyStudy, Axes
from ..study.axes import Grid, frequencies, rows_of
from ..study.study import OF_THRESHOLDS, Study
from ..study.variables import as_dataset, dress, flags
from ..values.quantities import Dampers, Frequencies, Positive, PulseTimes, Refinement
from .effort import CLOSE_STEP, ISLAND_STEP, RAGGED_STEP
from .population import nominal_thresholds
from .probe import Probe, amplitudes, walk
from .search import ISLANDS_TO, Search
from .slow import fall, growth_rate, is_slow, slow_factor
from .survey import STATUS, lowest, tell_cost
from .verified import find_thresholds, initial_rows, off_surfaces, split_rows, surfaces

JUMP, AT_ONCE = make_pulse("trapezoid", rise=0.0, fall=0.0), 1e4
"""A pulse that is constant, and so fast, over the beam's bending frequency, that it is over within
a time step: a jump in velocity."""
SLOWNESS = 0.02
"""Frequency, over the device's own, of a pulse that stands for a long one, if pulses jump."""
NO_AREA = 1e-3
"""Area below which a pulse leaves no change of velocity that could trip."""


def limits_of(search: Search, grid: Grid, chosen: Chosen) -> dict[str, tuple]:
    """Find areas of pulses, and limits of slow and short ones; of a train's strongest blow.

    chosen: the model of the search
    Returns variables with their dimensions. What short pulses need does not depend on f0, and is
    kept for the next calls with the same device and C.
    """
    first, last = grid.device_of.ndim, len(grid.axes) - 2
    dims, sizes = tuple(grid.axes), grid.shape[first:last]
    single = grid._replace(pulses=tuple(pulse.alone for pulse in grid.pulses))
    ways = tuple(float(np.sign(p.area) * (abs(p.area) > NO_AREA)) for p in single.pulses)
    find = partial(_find_velocity_change, search, single, sizes, ways)
    places = single.device_of.shape, single.device_of.tobytes(), tuple(grid.axes["C"].tolist())
    asked = "velocity", sizes, ways, *places, search.settings, search.tolerance, search.highest
    return {
        "N_static": (dims[:last], _find_static(search, grid, single, sizes)),
        "velocity_change": ((*dims[:last], "C"), kept(find, grid.device, chosen, *asked).copy()),
        "area": (dims[first:last], np.reshape([abs(p.impact) for p in grid.pulses], sizes)),
    }


def _find_static(search, grid, single, sizes):
    """Find the limit of long pulses, multiples of g, (..., *sizes); single: grid of single blows.

    A pulse that jumps has another limit than the static threshold; the least C gives it.
    """
    models, start = search.models, search.settings.start
    ahead = [pulse if start == FIRST else pulse.reversed() for pulse in grid.pulses]
    press = np.array([pulse.highest for pulse in ahead])
    static = _spread(grid, models.static * (np.nan if models.lawful else 1.0), sizes)
    static = static / np.where(press > 0, press, np.nan).reshape(sizes)
    jumps = np.array([any(pulse.ends) for pulse in grid.pulses])
    if not jumps.any():
        return static
    single = single._replace(axes=grid.axes | {"C": grid.axes["C"][:1]})
    slow, which = SLOWNESS * grid.device.own_frequency, np.flatnonzero(jumps)
    N = _lowest_of(search, single, slow, which, is_short=False)[..., 0]
    return np.where(jumps.reshape(sizes), N, static)


def _find_velocity_change(search, grid, sizes, ways):
    """Find the velocity change that snaps, m/s, (..., *sizes, C), by jumps in velocity.

    ways: 1 for pulses that jump forward, -1 backward, 0 for those without a change
    """
    device, jumps = grid.device, tuple(JUMP if way > 0 else JUMP.reversed() for way in ways)
    fast = AT_ONCE * device.beam.bending_frequency
    # A force does not shake the frame, and so changes no velocity of it.
    pushes = np.flatnonzero(np.array(ways) * np.all(device.force == 0))
    N = _lowest_of(search, grid._replace(pulses=jumps), fast, pushes, is_short=True)
    return N * _spread(grid, device.gravity * (2 * np.pi / fast), sizes)[..., np.newaxis]


def _lowest_of(search, grid, omega, which, is_short):
    """Find N_first, (..., pulses, C), of pulses of a frequency omega, rad/us, (devices,).

    which: indices of the pulses; is_short: whether these are short, or else long
    Short pulses are sought by the finest models, but on surfaces only in the initial rows; where
    labels change back and forth, a search for islands may find a lower one.
    """
    grid = grid._replace(axes=grid.axes | {"f0": np.ones(1)})
    rows = rows_of(grid)
    rows = rows._replace(f0=omega[rows.device] / (2 * np.pi) * 1e6)
    exists, N = (rows.device >= 0) & np.isin(rows.pulse, which), np.full(rows.f0.size, np.nan)
    numbers = np.where(exists, np.arange(N.size), -1).reshape(grid.shape)
    parts = surfaces(grid.axes, numbers, np.zeros(1, bool))
    alone = np.flatnonzero(off_surfaces(exists, parts))
    search, models = search._replace(rows=rows), search.models
    if is_short:
        for part, level in (alone, models.levels[-1]), (initial_rows(parts), models):
            of_part = search.take(part)._replace(models=level)
            N[part], ragged = nominal_thresholds(of_part.probe(level.ragged), search.tolerance)
            N[part[ragged]] = np.fmin(N[part[ragged]], lowest(of_part.take(ragged)))
    else:
        N[exists] = lowest(search.take(exists))
    return N.reshape(grid.shape[:-1])


def _spread(grid, values, sizes):
    """Spread values of devices, (devices,), over axes of the device, and add axes of the pulse."""
    values = np.where(grid.device_of >= 0, values[grid.device_of], np.nan)
    return values.reshape(values.shape + (1,) * len(sizes))


def slow_law(search: Search, grid: Grid) -> dict[str, tuple]:
    """Give `dwell` and `N_slow`, the law of slow pulses, with their dimensions."""
    models, rows = search.models, search.rows
    of_C = growth_rate(grid.device, grid.axes["C"][:, np.newaxis], models.static).T
    of_C = np.nan * of_C if models.lawful or search.settings.start != FIRST else of_C
    rate = np.where((grid.device_of >= 0)[..., np.newaxis], of_C[grid.device_of], np.nan)
    C = np.arange(of_C.shape[1])[:, np.newaxis]
    swings = 1e6 * of_C[rows.device.reshape(grid.shape), C].ravel() / rows.f0
    factor, falls = np.full(swings.shape, np.nan), fall(grid.device, models.static)[rows.device]
    for number, pulse in enumerate(rows.pulses):
        which = (rows.pulse == number) & (rows.device >= 0) & is_slow(pulse, swings, falls)
        factor[which] = slow_factor(pulse, swings[which])
    N = factor * models.static[rows.device]
    of_device = tuple(grid.axes)[: grid.device_of.ndim]
    return {
        "dwell": ((*of_device, "C"), 2 / rate),
        "N_slow": (tuple(grid.axes), N.reshape(grid.shape)),
    }


LATCHED_STEP = 0.01
"""Relative step of the amplitudes that are followed to their end."""
RUN_STEPS = 2e6
"""Most time steps of a run to its end; rows of slower pulses are left out."""


def lowest_latched(probe: Probe, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Find the lowest N from which on all cells tried latch, (rows,); NaN if the highest does not.

    low, high: range of N that is tried, multiples of g, (rows,), NaN for none
    Runs go to their end, whatever the probe asks. The search goes down from the highest N, which
    must latch in the REPEATED_STEP, too, as ringing beams may do so by chance.
    """
    model, rows, settings, *_ = probe
    cells = rows.cells(model.device, 0.0, settings.horizon)
    steps = (cells.t_end / steps_and_seconds(model, cells, settings)[0])[:, 0]
    N = amplitudes(np.where(steps <= RUN_STEPS, low, np.nan), high, LATCHED_STEP)
    size = np.count_nonzero(np.isfinite(N), axis=1)
    every = np.arange(len(N))

    def leaves(model, which, below):
        """Tell whether cells some places below the highest do not latch, (rows, n)."""
        # A model may need N ascending; the lowest stands for places below it.
        places = np.maximum(size[which, np.newaxis] - 1 - below, 0)[:, ::-1]
        ascending = N[which[:, np.newaxis], places]
        cells = rows.take(which).cells(model.device, ascending, settings.horizon)
        runs = model.follow(cells, settings)
        return (label(runs, settings.energy_tolerance) != LATCHED)[:, ::-1]

    highest = walk(partial(leaves, model.with_step(REPEATED_STEP)), every, 0, np.minimum(size, 1))
    down = walk(partial(leaves, model), every, 0, highest * size)
    return np.where(down > 0, N[every, size - np.maximum(down, 1)], np.nan)


UNSEEN = (
    "in multiples of g; narrower stretches may lie below: than "
    f"{2 * CLOSE_STEP:.2%} of N near a clean threshold of a fast pulse, "
    f"{RAGGED_STEP:.2%} near a ragged one, {ISLAND_STEP:.1%} elsewhere"
)
"""How wide stretches may be that a search does not see."""


def threshold(
    study: AnyStudy,
    f0: Frequencies | None,
    C: Dampers,
    *,
    duration: PulseTimes | None = None,
    tolerance: Refinement = THRESHOLD_TOLERANCE,
    highest: Positive | None = None,
    axes: Axes | None = None,
) -> xr.Dataset:
    """Find the lowest N that snaps the beam, with error bars.

    Parameters
    ----------
    study
        Devices, model, shocks, and how each cell is followed; or a Device.
    f0
        Frequencies of the pulse, Hz, each once; None for a recorded shock.
    C
        Dampings of the mass, uN us/um, each once.
    duration
        Durations of the pulse, us, in place of f0.
    tolerance
        Relative step of N at which the search ends; only the digits that `N_error` allows count.
    highest
        Largest N searched for islands, multiples of g; by default twice the threshold.
    axes
        Values of the device, internal units, by name.

    Returns
    -------
    Dataset
        Over (..., C, f0): `N_first` is the threshold, `N_error` its error, `status` why there is
        none. Above `N_always` every run seen snaps, above `N_latched` each latches; below `N_bound`
        nothing snaps. `N_static` and `velocity_change` (m/s) are the limits of long and short
        pulses. docs/thresholds.md describes all variables.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, for a device without a second stable shape.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines")
    >>> thresholds = snapmap.threshold(study, 1500, 25, axes={"thickness": ["1.9 um", "2 um"]})
    >>> thresholds.N_first.squeeze().round().values.tolist()
    [893.0, 990.0]
    """
    axes = {**(axes or {}), "C": C, "f0": frequencies(f0, duration)}
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
    document = study.document(OF_THRESHOLDS)
    document["sweep"] = {"threshold_tolerance": tolerance}
    grid = study.set_out(axes)
    search = search_of(study, grid)._replace(tolerance=tolerance, highest=highest)
    columns, rows, decides = _search(search, grid), search.rows, search.models.decides
    columns["N_bound"][least_amplitudes(decides, rows, study.start) == 0] = np.nan
    columns["N_latched"] = _find_latched(search, columns)
    peak = np.array([pulse.peak for pulse in rows.pulses])
    if np.isfinite(peak).any():
        acceleration = columns["N_first"] * grid.device.gravity[rows.device]
        columns["scale_first"] = acceleration / peak[rows.pulse]
    data = _variables(grid, columns) | limits_of(search, grid, study.model) | slow_law(search, grid)
    data["status"] = *data["status"], flags(STATUS)
    data["N_first"] = *data["N_first"], {"comment": UNSEEN}
    gravity = float(grid.device.gravity[0])
    return dress("threshold", as_dataset(data, grid.axes), document, gravity=gravity)


def first_snaps(
    study: Study, axes: Mapping[str, Sequence[float]], tolerance: float = THRESHOLD_TOLERANCE
) -> xr.Dataset:
    """Find the thresholds of a study as `thresholds_of` does, but no limits and no N_latched."""
    grid = study.set_out(axes)
    columns = _search(search_of(study, grid)._replace(tolerance=tolerance), grid)
    return as_dataset(_variables(grid, columns), grid.axes)


def search_of(study: Study, grid: Grid) -> Search:
    """Make the search for the thresholds of a grid of a study."""
    models = choose_survey(grid.device, study.model, study.start)
    return Search(models, rows_of(grid), study.run)


def _search(search, grid):
    """Find the thresholds of a grid; returns variables by name, (rows, ...)."""
    parts, searched = split_rows(grid, search.rows)
    tell_cost(search.take(searched))
    return find_thresholds(search, parts)


def _find_latched(search, columns):
    """Find N_latched, (rows,), from the thresholds up."""
    exists, highest = search.rows.device >= 0, search.highest
    first, error, ragged = (columns[key][exists] for key in ("N_first", "N_error", "ragged"))
    top = np.where(np.isnan(first), np.nan, ISLANDS_TO * first if highest is None else highest)
    # The search begins at the upper end of a clean threshold's bar: within it, the time steps of a
    # whole run may not snap where those of a run to the snap do.
    low = first + np.where(ragged == 0, error, 0.0)
    low = np.where(low <= top, low, np.nan)
    latched = lowest_latched(search.take(exists).probe(search.models.decides), low, top)
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

"""Limits of thresholds: of slow pulses and of short ones, and the law of slow ones."""

from functools import partial

import numpy as np

from ..solver.kept import kept
from ..solver.options import Chosen
from ..solver.settings import FIRST
from ..study.axes import Grid, rows_of
from .search import Search
from .slow import fall, growth_rate, is_slow, slow_factor
from .survey import lowest
from .verified import initial_rows, off_surfaces, surfaces

IMPULSE, IMPULSE_OF_BEAM = 100.0, 10.0
"""Frequency, over the device's own and over the beam's, of a pulse that stands for a jump in
velocity."""
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
    impact = np.array([pulse.impact for pulse in grid.pulses])
    find = partial(_find_velocity_change, search, single, sizes)
    places = single.device_of.shape, single.device_of.tobytes(), tuple(grid.axes["C"].tolist())
    pulses = tuple((pulse.pieces.tobytes(), pulse.ends) for pulse in single.pulses)
    how = search.settings, search.tolerance, search.highest, search.from_bound
    others = "velocity change", sizes, *places, pulses, how
    return {
        "N_static": (dims[:last], _find_static(search, grid, single, sizes)),
        "velocity_change": ((*dims[:last], "C"), kept(find, grid.device, chosen, *others).copy()),
        "area": (dims[first:last], abs(impact).reshape(sizes)),
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


def _find_velocity_change(search, grid, sizes):
    """Find the velocity change that snaps, by short pulses, m/s, (..., *sizes, C)."""
    device, area = grid.device, np.array([pulse.area for pulse in grid.pulses])
    frequency, of_beam = device.own_frequency, device.beam.bending_frequency
    fast = np.maximum(IMPULSE * frequency, IMPULSE_OF_BEAM * of_beam)
    # A force does not shake the frame, and so changes no velocity of it.
    pushes = np.flatnonzero((abs(area) > NO_AREA) & np.all(device.force == 0))
    N = _lowest_of(search, grid, fast, pushes, is_short=True)
    scale = _spread(grid, device.gravity * (2 * np.pi / fast), sizes) * abs(area).reshape(sizes)
    return N * scale[..., np.newaxis]


def _lowest_of(search, grid, omega, which, is_short):
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
    alone = off_surfaces(exists, parts)
    search, models = search._replace(rows=rows), search.models
    level = models.levels[-1] if is_short else models
    N[alone] = lowest(search.take(alone)._replace(models=level))
    surface = np.sort(initial_rows(parts)) if is_short else np.flatnonzero(exists & ~alone)
    N[surface] = lowest(search.take(surface))
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

"""The search for where rows begin to snap, and where their labels change.

It has five steps:
1. The cheap model scans N upwards until a cell snaps (`scan_upwards`).
2. It scans a window about this N for islands (`scan_for_islands`).
3. The deciding model locates a single change of label, and refines it (`locate_change`).
4. It looks closely beside that change where the device rings (`look_closely`). Rows in which any
   step saw more changes are ragged, and are scanned around all of them (`ragged.scan_ragged`).
5. Other time steps and models make the error bar (`survey.make_bars`).
"""

import math
from typing import NamedTuple

import numpy as np

from ..device.device import Device
from ..solver.adaptive import Survey
from ..solver.bounds import least_amplitudes
from ..solver.cells import Rows
from ..solver.models import Follows
from ..solver.settings import FIRST, THRESHOLD_TOLERANCE, Run
from .edges import Edges, Seen, Window, around, edges_of, joined, outermost, scan, stretches
from .effort import CLOSE_PLACES, CLOSE_STEP, ISLAND_STEP, LANES, RAGGED_STEP, SCAN_STEP, TOGETHER
from .probe import Probe, amplitudes, first_snap, refine
from .ragged import CLEAN_REACH, RAGGED_REACH, scan_ragged

ISLANDS_FROM, ISLANDS_TO = 0.7, 2.0
"""Ends of the window that is scanned for islands, as multiples of the first N that snaps."""
RINGING = 0.25
"""Least time of a device's response, over that of the pulse's steepest rise, with which the device
rings after the pulse; islands then lie close to its threshold."""
FAST_PULSE = 0.7
"""Least frequency of a pulse, over the device's own, at which the finer models take its rows."""
STEP_RATIO = math.sqrt(2.0)
"""Factor on the deciding time step, of the runs that show its error: as that is of second order,
it doubles, and the difference is the error itself."""
SLACK = 0.99
"""Share of the bound by energy at which scans may begin, as a model may itself be off."""


class Search(NamedTuple):
    """The search for the thresholds of rows, to a relative tolerance.

    highest: largest N at which islands count, multiples of g; by default ISLANDS_TO times the
        threshold
    from_bound: whether islands count from the bound by energy on, not from ISLANDS_FROM times the
        threshold on
    """

    models: Survey
    rows: Rows
    settings: Run
    tolerance: float = THRESHOLD_TOLERANCE
    highest: float | None = None
    from_bound: bool = False

    def take(self, which: np.ndarray | slice) -> "Search":
        """Take some rows, by a mask, indices or a slice."""
        return self._replace(rows=self.rows.take(which))

    def probe(self, model: Follows, until: str = "edge") -> Probe:
        """Ask a model about the rows; until: as in `settings.QUESTION`."""
        return Probe(model, self.rows, self.settings, until)

    @property
    def bound(self) -> np.ndarray:
        """N below which nothing can snap, (rows,): by energy, or by a share of the static one."""
        bound = least_amplitudes(self.models.decides, self.rows, self.settings.start)
        return np.maximum(bound, 1e-4 * self.models.static[self.rows.device])

    @property
    def rings(self) -> np.ndarray:
        """Whether the device rings after the pulse, (rows,)."""
        return is_ringing(self.models.decides.device, self.rows)

    @property
    def others(self) -> tuple[Follows, ...]:
        """The models to compare clean rows with, the deciding one in another step first."""
        models = self.models
        return models.decides.with_step(STEP_RATIO), *models.others, *models.judges

    @property
    def others_of_ragged(self) -> tuple[Follows, ...]:
        """The models to compare ragged rows with: those of clean rows, and the finest."""
        return *self.others, self.models.finest or self.models.decides


class Changes(NamedTuple):
    """Where the deciding model changes its label; edges apart, arrays are (rows,).

    edges: the changes, refined in clean rows
    is_open: whether a ragged row does not snap at the highest N, and so has no N_always
    limits: window in which islands count
    ragged: whether labels change back and forth
    firsts: N at which each of the other models begins to snap in ragged rows, (others, rows)
    bound: N below which nothing can snap; highest: the largest N tried
    quiet: whether all runs of the first scan succeeded without a snap
    """

    edges: Edges
    is_open: np.ndarray
    limits: Window
    ragged: np.ndarray
    firsts: np.ndarray
    bound: np.ndarray
    highest: np.ndarray
    quiet: np.ndarray

    @property
    def N_first(self) -> np.ndarray:
        """The lowest N seen to snap, (rows,)."""
        return stretches(self.edges, self.is_open)[0]


def find_changes(search: Search) -> Changes:
    """Find the changes of label of rows by the first four steps."""
    models, bound = search.models, search.bound
    cheap, decides = search.probe(models.scans, "snap"), search.probe(models.decides)
    first, highest, quiet = scan_upwards(cheap, models.static, bound)
    limits = island_limits(search, first, bound)
    window, ragged = scan_for_islands(cheap, limits)
    low, high = locate_change(decides, window.of(~ragged), search.tolerance)
    seen = look_closely(decides, search.rings, low, high)
    clean = is_single(seen.edges, seen.begins)
    ragged = np.isfinite(first) & ~clean
    window = around(limits, window.low, window.high, RAGGED_REACH, RAGGED_STEP).of(ragged)
    others = [search.probe(model, "snap") for model in search.others_of_ragged]
    lowest = np.minimum(limits.low, SLACK * bound)
    of_ragged = search.probe(models.ragged)
    scanned, firsts = scan_ragged(of_ragged, others, window, lowest, seen.of(ragged))
    return Changes(
        edges=joined(seen.of(clean).edges, scanned.edges),
        is_open=ragged & ~scanned.ends,
        limits=limits,
        ragged=ragged,
        firsts=firsts,
        bound=bound,
        highest=np.where(np.isnan(first), highest, limits.high),
        quiet=quiet,
    )


def scan_upwards(
    probe: Probe, static: np.ndarray, bound: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the first N that snaps, upwards in the steps of the first scan.

    static, bound: as for `scan_range`; the scan goes down to the bound where the first N snaps
    Returns N, NaN where nothing snaps, the highest N of the range, and whether nothing snaps, false
    where a run failed; all (rows,).
    """
    N = amplitudes(*scan_range(probe, static, bound), SCAN_STEP)
    t_snap = np.full(N.shape, np.nan)
    count, together = N.shape[1], max(TOGETHER, LANES // max(1, len(N)))
    for part in np.split(np.arange(count), range(together, count, together)):
        quiet = ~np.isfinite(t_snap).any(axis=1, keepdims=True)
        t_snap[:, part] = probe(np.where(quiet, N[:, part], np.nan))
    first = first_snap(N, np.isfinite(t_snap))[1]
    quiet = np.isnan(t_snap).all(axis=1) & np.isfinite(N[:, 0])
    begins = np.isfinite(t_snap[:, 0])
    if begins.any():
        lower = amplitudes(np.where(begins, SLACK * bound, np.nan), N[:, 0], SCAN_STEP)
        first = np.where(begins, first_snap(lower, probe.snaps(lower))[1], first)
    return first, np.fmax.reduce(N, axis=1), quiet


def scan_range(
    probe: Probe, static: np.ndarray, bound: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Choose the lowest and the highest N of the first scan, (rows,): around any threshold.

    static: threshold of slow pulses, multiples of g, (devices,)
    bound: N below which nothing can snap, (rows,)
    A pulse amplifies by at most its variation (2 or more): the scan begins at two thirds of the
    static threshold over that. It ends at five times the static threshold, and higher for short
    pulses, by their change of velocity, and damped masses. A record that goes back and forth counts
    as a change of at least 2 % of peak times duration, and a pulse that pulls counts as pressing
    with at least a quarter of its peak.
    """
    device, rows, start = probe.model.device, probe.rows, probe.settings.start
    ahead = [pulse if start == FIRST else pulse.reversed() for pulse in rows.pulses]
    columns = static, device.own_frequency, device.mass
    static, frequency, mass = (column[rows.device] for column in columns)
    facts = [(p.variation, max(abs(p.impact), 0.02 * p.swing), max(p.highest, 0.25)) for p in ahead]
    variation, area, press = (column[rows.pulse] for column in np.array(facts).T)
    fast = 1e-6 * np.pi * rows.f0 / (frequency * area)
    damped = np.divide(rows.C, 2 * frequency * mass, out=np.zeros(mass.shape), where=mass > 0)
    low = static / (1.5 * np.fmax(variation, 2))
    # A flying mass strikes with energy that a far weaker shock can give it. A beam that leaves a
    # mass at its stop may swing further than a lasting push moves it.
    from_bound = np.isfinite(device.stop_toward) | (start != FIRST) & ~device.is_alone
    low = np.where(from_bound[rows.device], np.minimum(low, SLACK * bound), low)
    flat = np.array([pulse.is_flat for pulse in ahead])[rows.pulse]
    low = np.where(flat, np.maximum(low, SLACK * bound), low)
    return low, 5 * static / press * (1 + fast) * (1 + damped)


def scan_for_islands(probe: Probe, limits: Window) -> tuple[Window, np.ndarray]:
    """Find the window around the cheap model's changes, and the rows that are ragged, (rows,).

    A row is ragged where labels of the cheap model change more than once: then they do in every
    model, in each at other N.
    """
    n_rows = limits.low.size
    edges, *_ = scan(probe, limits.N)
    ends = outermost(edges.row, edges.high, n_rows)
    ragged = np.bincount(edges.row, minlength=n_rows) > 1
    window = around(limits, *ends, CLEAN_REACH, limits.step)
    # Large steps reach farther.
    low = np.fmin(window.low, outermost(edges.row, edges.low, n_rows)[0])
    return window._replace(low=low), ragged


def island_limits(search: Search, first: np.ndarray, bound: np.ndarray) -> Window:
    """Choose the window that is scanned for islands, around the first N that snaps, (rows,).

    Where a pulse is too slow for ringing, islands lie within RAGGED_REACH.
    """
    slow = ~is_ringing(search.models.decides.device, search.rows, RINGING / 5)
    near = first / RAGGED_REACH, first * RAGGED_REACH
    low = np.where(slow, near[0], ISLANDS_FROM * first)
    low = SLACK * bound if search.from_bound else low
    high = ISLANDS_TO * first if search.highest is None else np.fmax(search.highest, near[1])
    high = np.where(np.isfinite(first), np.where(slow, near[1], high), np.nan)
    return Window(low, high, np.full(first.size, ISLAND_STEP))


def locate_change(probe: Probe, window: Window, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the ends of the change of label in rows that have a single one, refined.

    Returns low and high, (rows,), NaN for other rows.
    """
    edges, begins, _ = scan(probe, window.N)
    single = edges.take(is_single(edges, begins)[edges.row])
    low, high = np.full((2, begins.size), np.nan)
    low[single.row], high[single.row] = single.low, single.high
    return refine(probe, low, high, tolerance)


def is_single(edges: Edges, begins: np.ndarray) -> np.ndarray:
    """Tell which rows have one edge alone, from quiet to snap, (rows,); begins: as in `Seen`."""
    return ~begins & (np.bincount(edges.row, minlength=begins.size) == 1)


def look_closely(probe: Probe, rings: np.ndarray, low: np.ndarray, high: np.ndarray) -> Seen:
    """Find further edges close to the single one of rows, where the device rings.

    rings: whether it does, (rows,)
    low, high: ends of the edge, refined, (rows,), NaN for rows that are skipped
    """
    seen = close_edges(probe, *(np.where(rings, end, np.nan) for end in (low, high)))
    others = np.flatnonzero(~rings & np.isfinite(high))
    rising = np.ones(others.size, bool)
    edges = joined(seen.edges, Edges(others, low[others], high[others], rising))
    low, high = np.where(rings, [seen.low, seen.high], [low, high])
    return Seen(edges, seen.begins, np.where(rings, seen.ends, np.isfinite(high)), low, high)


def close_edges(
    probe: Probe,
    low: np.ndarray,
    high: np.ndarray,
    sides: tuple[int, ...] = (-1, 1),
    reach: float = np.inf,
) -> Seen:
    """Find further edges close to a refined one, as a scan in CLOSE_STEP would, by fewer runs.

    low, high: ends of the edge, (rows,), NaN for rows that are skipped
    sides: sides that are looked at, -1 below and 1 above
    reach: largest relative distance of the places
    Below a single threshold, runs come nearer to a snap as N grows; above, they snap later the
    closer N is to it. A stretch of the other label disturbs this order far beyond its own ends, as
    runs beside it dwell at the saddle, too. Where the order is broken, all steps in between are
    tried, above every second one, unless a run has shown another label already.
    """
    steps = np.array(CLOSE_PLACES)
    steps = steps[reach >= CLOSE_STEP * steps]
    between = np.setdiff1d(np.arange(2, steps[-1]), steps)
    inside = np.searchsorted(steps, between) - 1
    runs = [probe.observe(_beside(low, high, side, steps)) for side in sides]
    others = [np.isfinite(run.t_snap) == (side < 0) for side, run in zip(sides, runs, strict=True)]
    alone = ~np.any(np.hstack(others), axis=1, keepdims=True)
    N, t_snap = [low, high], [np.full(low.size, np.nan), np.zeros(low.size)]
    for side, run in zip(sides, runs, strict=True):
        nearer = -run.lowest if side < 0 else run.t_snap
        # Above the threshold a gap of one step does not matter.
        wanted = alone & _out_of_order(nearer)[:, inside] & ((side < 0) | (between % 2 == 0))
        more = np.where(wanted, _beside(low, high, side, between), np.nan)
        N += _beside(low, high, side, steps), more
        t_snap += run.t_snap, probe(more)
    N, t_snap = np.column_stack(N), np.column_stack(t_snap)
    order = np.argsort(N, axis=1)
    N, t_snap = (np.take_along_axis(a, order, axis=1) for a in (N, t_snap))
    return Seen(*edges_of(N, t_snap), np.fmin.reduce(N, axis=1), np.fmax.reduce(N, axis=1))


def _beside(low, high, side, steps):
    """Give N at some numbers of steps below or above an edge, (rows, steps)."""
    return np.multiply.outer(low if side < 0 else high, 1 + CLOSE_STEP * side * steps)


def _out_of_order(nearer):
    """Find intervals, (rows, n), in which values do not fall outward, or two beside such.

    docs/thresholds.md, "Width of islands", has what this misses.
    """
    with np.errstate(invalid="ignore"):
        rises = ~(nearer[:, 1:] < nearer[:, :-1])
    padded = np.pad(rises, ((0, 0), (2, 2)))
    return np.any([padded[:, i : i + rises.shape[1]] for i in range(5)], axis=0)


def is_fast(device: Device, rows: Rows) -> np.ndarray:
    """Tell whether a pulse excites more than the first modes of the beam, (rows,)."""
    swings = np.array([pulse.swings for pulse in rows.pulses])[rows.pulse]
    return 2e-6 * np.pi * rows.f0 * swings > FAST_PULSE * device.own_frequency[rows.device]


def is_ringing(device: Device, rows: Rows, least: float = RINGING) -> np.ndarray:
    """Tell whether the device rings after a pulse, (rows,); least: the share that RINGING is."""
    frequency, spring = device.own_frequency[rows.device], device.spring[rows.device]
    steepest = np.array([pulse.steepest for pulse in rows.pulses])[rows.pulse]
    C = np.where(device.is_alone[rows.device], 0.0, rows.C)
    return 2e-6 * np.pi * rows.f0 * steepest * (1 / frequency + C / spring) >= least

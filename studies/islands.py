"""Where thresholds are ragged, and which snaps their search misses, for docs/thresholds.md.

./run python -m studies islands [--small]
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from snapmap import Study
from snapmap.device.device import Device
from snapmap.solver.settings import Run
from snapmap.study.axes import Grid
from snapmap.thresholds.probe import amplitudes
from snapmap.thresholds.search import Search
from snapmap.thresholds.surface import search_of
from snapmap.thresholds.survey import Thresholds, survey

from .common import command_device, few
from .random_devices import draw_device, draw_shocks
from .tables import Table, write

F0, DAMPINGS = np.geomspace(100, 3e4, 250), [0.025, 0.43, 1.8, 4.5, 30.0, 200.0]
SEED, DEVICES = 67, 40
STEP, REACH = 1.25e-4, np.array([0.02, 0.05])
"""Relative step of the scans below the bars, and how far below clean and ragged thresholds they
begin."""
RUN = Run(horizon=1500.0)


class Seen(NamedTuple):
    """Rows of a kind: whether they are ragged; the widest stretch that snaps below the bar.

    width: relative; depth: of the lowest snap below the threshold, in bars; 0 without a snap
    """

    ragged: np.ndarray
    width: np.ndarray
    depth: np.ndarray


def main():
    device = command_device()
    search = search_of(*planned(device, few(F0, 3), few(DAMPINGS, 2)))
    found = survey(search)
    seen = {"the example": [below(search, found)], "random": [*of_random()]}
    write("islands", ragged_rows(search, found), missed(seen))


def planned(device: Device, f0: Sequence[float], C: Sequence[float]) -> tuple[Study, Grid]:
    """Set out a study of thresholds over f0 and C."""
    study = Study(device, **vars(RUN))
    return study, study.set_out({"f0": f0, "C": C})


def of_random() -> Iterator[Seen]:
    """Scan rows of random devices."""
    draw = np.random.default_rng(SEED)
    for _ in range(few(DEVICES)):
        device = draw_device(draw)
        search = search_of(*planned(device, *draw_shocks(draw, device)))
        yield below(search, survey(search))


def below(search: Search, found: Thresholds) -> Seen:
    """Scan below the bars by the models that decided."""
    top = found.N_first - found.N_error
    low = (1 - REACH[found.ragged]) * found.N_first
    N = amplitudes(np.where(low < top, low, np.nan), top, STEP)
    snapped = np.zeros(N.shape, bool)
    for level, models in enumerate(search.models.levels):
        for is_ragged, model in enumerate((models.decides, models.ragged)):
            rows = np.flatnonzero((found.level == level) & (found.ragged == is_ragged))
            if rows.size:
                snapped[rows] = search.take(rows).probe(model).snaps(N[rows])
    known = np.isfinite(top)
    lowest = np.where(snapped, N, found.N_first[:, np.newaxis]).min(axis=1)
    depth = (found.N_first - lowest) / found.N_error
    return Seen(found.ragged[known], longest(snapped)[known] * STEP, depth[known])


def longest(labels: np.ndarray) -> np.ndarray:
    """Count the longest run of true labels in each row, (rows,)."""
    run = most = np.zeros(len(labels), int)
    for column in labels.T:
        run = np.where(column, run + 1, 0)
        most = np.maximum(most, run)
    return most


def ragged_rows(search: Search, found: Thresholds) -> Table:
    """Make a table of the share of rows that are ragged, by C."""
    rows = []
    for C in np.unique(search.rows.C):
        of_C = search.rows.C == C
        f0 = search.rows.f0[of_C & (found.ragged == 1)] / 1e3
        rows.append([f"{C:g}", f"{f0.size / np.sum(of_C):.0%}", f"{min(f0, default=np.nan):.1f}"])
    return Table("islands_ragged", ["C, uN us/um", "ragged", "from, kHz"], rows)


def missed(seen: dict[str, list[Seen]]) -> Table:
    """Make a table of the rows with snaps below their bar."""
    rows = []
    for whose, scans in seen.items():
        ragged, width, depth = map(np.concatenate, zip(*scans, strict=True))
        for name, which in (("clean", ragged == 0), ("ragged", ragged == 1)):
            wide, deep = width[which].max(initial=0), depth[which].max(initial=0)
            counts = np.sum(which), np.sum(width[which] > 0)
            rows.append([f"{whose}, {name}", *map(str, counts), f"{wide:.3%}", f"{deep:.1f}"])
    head = ["thresholds", "number", "with snaps below the error", "widest stretch"]
    head += ["deepest, over the error"]
    return Table("islands_missed", head, rows)

"""How many cells a second, by whom and on how many threads, and how soon: docs/accuracy.md.

./run python -m studies speed [--small]

Workload A: 16 x 16 cells of the handout's device, N = 600 to 2400, f0 = 300 Hz to 20 kHz, each
followed to its snap or to 1500 us past the pulse. Times are the least of rounds in turns.
"""

import os
import subprocess
import sys
from dataclasses import replace
from functools import partial
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from snapmap.device.device import Device
from snapmap.files.text import DASH, table
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.settings import Settings

from .common import ROOT, command_device, few, machine, number, rate, ratio, take_turns, versions
from .scipy_solver import Follow, by_scipy

SETTINGS = Settings(1500.0, until="snap", repeat=False)
SIDE, FEWEST, DAMPING, ROUNDS = 16, 4, 0.025, 5
N_RANGE, F0_RANGE = (600.0, 2400.0), (300.0, 20e3)
PLAIN, HANDOUT = "reference (plain loop)", "5 elements (9 modes)"
MODELS = {PLAIN: {"name": "reference"}, HANDOUT: {"name": "elements"}}
MODELS |= {f"cosines, {n} modes": {"name": "cosines", "modes": n} for n in (3, 5, 11)}
FEW = slice(4, None, 29)
"""Cells for SciPy: nine, strewn over the map."""
COUNTS = 1_000, 100_000, 1_000_000
FIRST = """
import sys, snapmap
device = snapmap.load_device(sys.argv[1])
print(snapmap.threshold(device, [1500], [25]).N_first.item())
"""
HEAD = ["", "cells", "cells/s", "to the plain loop", "same labels", "with proofs", "ns per step"]


def main() -> None:
    device = command_device()
    print(f"{machine()}; {versions('numpy', 'numba', 'scipy')}; one thread.\n")
    print(table(HEAD, by_everyone(device)))
    print(table(["cells, 5 cosines", "cells/s, 1 thread", "2 threads", "gain"], by_threads(device)))
    print(table(["first threshold in a new process", "s"], starts()))


def map_cells(device: Device) -> Cells:
    """The cells of workload A."""
    N, f0 = (np.linspace(*N_RANGE, few(SIDE, FEWEST)), np.geomspace(*F0_RANGE, few(SIDE, FEWEST)))
    N, f0 = (values.ravel() for values in np.meshgrid(N, f0))
    return to_cells(device, 0, N, f0, DAMPING, SETTINGS.horizon)


def without_proofs(model: Model) -> Model:
    """Under a barrier of no height nothing is proven: each cell goes on to its snap or horizon."""
    return replace(model, barrier=model.barrier._replace(energy=0.0, midpoint=0.0))


def by_model(model: Model) -> Follow:
    """Follow cells as a sweep does: t_snap, us, NaN for a cell that does not snap."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def by_everyone(device: Device) -> list[list[str]]:
    """A row for each of our models and of the others'."""
    cells = map_cells(device)
    models = {name: build_model(device, **options) for name, options in few(MODELS, 3).items()}
    modal = models[HANDOUT].modal
    tasks = {name: partial(by_model(without_proofs(one)), cells) for name, one in models.items()}
    tasks |= {(name, "proven"): partial(by_model(one), cells) for name, one in models.items()}
    take_turns(tasks, 1)  # compiles
    runs = take_turns(tasks, few(ROUNDS))
    scipy = {"SciPy DOP853": partial(by_scipy(device, modal, "DOP853"), cells.take(FEW))}
    runs |= take_turns(scipy, 1)
    plain = runs[PLAIN].result
    each = runs[PLAIN].seconds / plain.size
    rows = []
    for name in (name for name in runs if isinstance(name, str)):
        t_snap, seconds = runs[name]
        known = plain if t_snap.size == plain.size else plain[FEW]
        same = int(np.sum(np.isnan(t_snap) == np.isnan(known)))
        row = [name, str(t_snap.size), rate(t_snap.size, seconds)]
        row += [ratio(each * t_snap.size / seconds), f"{same}/{t_snap.size}", DASH, DASH]
        if name in models:
            steps = count_steps(models[name], cells, t_snap)
            row[-2:] = (
                rate(t_snap.size, runs[name, "proven"].seconds),
                number(1e9 * seconds / steps),
            )
        rows.append(row)
    return rows


def count_steps(model: Model, cells: Cells, t_snap: np.ndarray) -> float:
    """Steps that the cells need to their snaps or horizons."""
    dt = model.steps.of(cells, SETTINGS.question)
    return float(np.sum(np.where(np.isnan(t_snap), cells.t_end, t_snap) / dt))


def by_threads(device: Device) -> list[list[str]]:
    """Rows by number of cells, strewn over the map, on one thread and on two."""
    model, rows = build_model(device, "cosines", modes=5), []
    for count in few(COUNTS):
        draw = np.random.default_rng(count)
        N, f0 = draw.uniform(*N_RANGE, count), np.exp(draw.uniform(*np.log(F0_RANGE), count))
        cells = to_cells(device, 0, N, f0, DAMPING, SETTINGS.horizon)
        tasks = {n: partial(model.follow, cells, SETTINGS._replace(threads=n)) for n in (1, 2)}
        one, two = (run.seconds for run in take_turns(tasks, min(5, 10**6 // count)).values())
        rows.append([number(count), rate(count, one), rate(count, two), ratio(one / two)])
    return rows


def starts() -> list[list[str]]:
    """Seconds from a process's start to its first threshold, nothing compiled and compiled."""
    with TemporaryDirectory() as cache:
        return [[name, number(start(cache))] for name in ("nothing compiled", "compiled")]


def start(cache: str) -> float:
    """Run a new process with its kernels in a folder; s."""
    paths = {"PYTHONPATH": str(ROOT / "workflow" / "scripts"), "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", FIRST, str(ROOT / "config" / "config.yaml")]
    begun = perf_counter()
    subprocess.run(command, env=os.environ | paths, check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - begun


if __name__ == "__main__":
    main()

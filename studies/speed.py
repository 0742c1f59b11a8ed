"""Cells per second by solver, and the time of a first threshold, for docs/accuracy.md.

./run python -m studies speed [--small]

Workload A: 16 x 16 cells of the handout's device, N = 600 to 2400, f0 = 300 Hz to 20 kHz, each
followed to its snap or to 1500 us after the pulse. Rounds run in turns, and the least processor
time counts.
"""

import os
import subprocess
import sys
from dataclasses import replace
from functools import partial
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from snapmap.device.device import Device
from snapmap.files.text import DASH
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines, Elements, Reference
from snapmap.solver.settings import Run

from .common import ROOT, command_device, few, number, rate, ratio, take_turns
from .scipy_solver import Follow, by_scipy
from .tables import Table, write

SETTINGS = Run(1500.0, until="snap", repeat=False)
SIDE, FEWEST, DAMPING, ROUNDS = 16, 4, 0.025, 5
N_RANGE, F0_RANGE = (600.0, 2400.0), (300.0, 20e3)
PLAIN, HANDOUT = "reference (plain loop)", "5 elements (9 modes)"
MODELS = {PLAIN: Reference(), HANDOUT: Elements()}
MODELS |= {f"cosines, {n} modes": Cosines(modes=n) for n in (3, 5, 11)}
FEW = slice(4, None, 29)
"""Nine cells for SciPy, spread over the map."""
FIRST = """
import sys, snapmap
device = snapmap.load_device(sys.argv[1])
print(snapmap.threshold(device, [1500], [25]).N_first.item())
"""
HEAD = ["", "cells", "cells/s", "to the plain loop", "same labels", "until settled", "ns per step"]


def main() -> None:
    device = command_device()
    of_starts = Table("speed_starts", ["first threshold in a new process", "s"], starts())
    write("speed", Table("speed", HEAD, by_everyone(device)), of_starts)


def map_cells(device: Device) -> Cells:
    """Make the cells of workload A."""
    N, f0 = (np.linspace(*N_RANGE, few(SIDE, FEWEST)), np.geomspace(*F0_RANGE, few(SIDE, FEWEST)))
    N, f0 = (values.ravel() for values in np.meshgrid(N, f0))
    return to_cells(device, 0, N, f0, DAMPING, SETTINGS.horizon)


def without_settling(model: Model) -> Model:
    """Return the model with a barrier of 0, so that no cell settles before snap or horizon."""
    return replace(model, barrier=model.barrier._replace(energy=0.0, midpoint=0.0))


def by_model(model: Model) -> Follow:
    """Make a function that follows cells as a sweep does."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def by_everyone(device: Device) -> list[list[str]]:
    """Make a row for each model and for SciPy."""
    cells, tasks = map_cells(device), {}
    models = {name: build_model(device, chosen) for name, chosen in few(MODELS, 3).items()}
    for name, model in models.items():
        tasks[name] = partial(by_model(without_settling(model)), cells)
        tasks[name, "settled"] = partial(by_model(model), cells)
    take_turns(tasks, 1)  # compiles
    runs = take_turns(tasks, few(ROUNDS), process_time)
    scipy = by_scipy(device, models[HANDOUT].modal, "DOP853")
    runs |= take_turns({"SciPy DOP853": partial(scipy, cells.take(FEW))}, 1, process_time)
    plain = runs[PLAIN].result
    each = runs[PLAIN].seconds / plain.size
    rows = []
    for name in (name for name in runs if isinstance(name, str)):
        (t_snap, seconds), settled, per_step = runs[name], DASH, DASH
        size, labels = t_snap.size, plain if name in models else plain[FEW]
        same = int(np.sum(np.isnan(t_snap) == np.isnan(labels)))
        if name in models:
            settled = rate(size, runs[name, "settled"].seconds)
            per_step = number(1e9 * seconds / count_steps(models[name], cells, t_snap))
        times = ratio(each * size / seconds)
        rows.append(
            [name, str(size), rate(size, seconds), times, f"{same}/{size}", settled, per_step]
        )
    return rows


def count_steps(model: Model, cells: Cells, t_snap: np.ndarray) -> float:
    """Count the time steps of the cells to their snaps or horizons."""
    dt = model.steps.of(cells, SETTINGS.question)
    return float(np.sum(np.where(np.isnan(t_snap), cells.t_end, t_snap) / dt))


def starts() -> list[list[str]]:
    """Make rows of the processor time to a first threshold, cold and compiled, s."""
    with TemporaryDirectory() as cache:
        return [[name, number(start(cache))] for name in ("nothing compiled", "compiled")]


def start(cache: str) -> float:
    """Return the processor time of a new process that keeps its kernels in `cache`, s."""
    paths = {"PYTHONPATH": str(ROOT / "workflow" / "scripts"), "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", FIRST, str(ROOT / "config" / "config.yaml")]
    begin = sum(os.times()[2:4])
    subprocess.run(command, env=os.environ | paths, check=True, stdout=subprocess.DEVNULL)
    return sum(os.times()[2:4]) - begin


if __name__ == "__main__":
    main()

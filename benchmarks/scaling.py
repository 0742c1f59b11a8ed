"""Cells per second by their number and that of threads: docs/performance.md.

PYTHONPATH=workflow/scripts ./run python benchmarks/scaling.py [--small]
"""

from functools import partial
from pathlib import Path

import numpy as np
from kernel import FOUR, KERNELS
from timing import take_turns

from snapmap import load_device
from snapmap.device import Device
from snapmap.io.markdown import number, rate, ratio, table
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from studies.few import few

ROOT = Path(__file__).resolve().parents[1]
COUNTS = 1_000, 10_000, 100_000, 1_000_000
SETTINGS = Settings(until="snap", repeat=False)


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    model, rows = build_model(device, **KERNELS[FOUR]), []
    for count in few(COUNTS):
        cells = random_cells(device, count)
        tasks = {n: partial(model.follow, cells, SETTINGS._replace(threads=n)) for n in (1, 2)}
        one, two = (run.seconds for run in take_turns(tasks, min(5, 10**6 // count)).values())
        rows.append([number(count), rate(count, one), rate(count, two), ratio(one / two)])
    print(f"{FOUR}, random cells, with proofs\n")
    print(table(["cells", "sims/s, 1 thread", "2 threads", "gain"], rows))


def random_cells(device: Device, count: int) -> Cells:
    """As many cells as wished, strewn over a map."""
    rng = np.random.default_rng(count)
    N = rng.uniform(600.0, 2400.0, count)
    f0 = np.exp(rng.uniform(*np.log([300.0, 20e3]), count))
    return to_cells(device, 0, N, f0, 0.025, SETTINGS.horizon)


if __name__ == "__main__":
    main()

"""From the start of a process to its first result: docs/performance.md.

PYTHONPATH=workflow/scripts ./run python benchmarks/start.py [--small]
"""

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from snapmap.io.markdown import number, table
from studies.few import few

ROOT = Path(__file__).resolve().parents[1]

SWEEP = """
import sys, snapmap
device = snapmap.load_device(sys.argv[1])
cube = snapmap.sweep(device, N=[1000], f0=[1500], C=[0.025], model=sys.argv[2], repeat=False)
print(cube.t_snap.item())
"""
FOLLOW = """
import sys
from snapmap import load_device
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
device = load_device(sys.argv[1])
cells = to_cells(device, [0], [1000], [1500], [0.025], 1500)
print(build_model(device, sys.argv[2]).follow(cells, Settings()).t_snap.item())
"""


class Start(NamedTuple):
    """Seconds from a process's start to its first result, one cell.

    cold: of `sweep`, with an empty kernel cache
    sweep, follow: of `sweep` and of `Model.follow`, which needs no xarray; with a full one
    """

    cold: float
    sweep: float
    follow: float


def main():
    rows = [[name, *map(number, time_start(name))] for name in few(("cosines", "handout"))]
    head = ["one cell", "`sweep`, nothing cached, s", "`sweep`, s", "`Model.follow`, s"]
    print(table(head, rows))


def time_start(model: str, rounds: int = 3) -> Start:
    """Run a new process for each figure; the last two are the best of `rounds`."""
    with TemporaryDirectory() as cache:
        cold = _one_process(SWEEP, model, cache)
        programs = SWEEP, FOLLOW
        warm = (min(_one_process(p, model, cache) for _ in range(few(rounds))) for p in programs)
        return Start(cold, *warm)


def _one_process(program, model, cache):
    paths = {"PYTHONPATH": str(ROOT / "workflow" / "scripts"), "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-u", "-c", program, str(ROOT / "config" / "config.yaml"), model]
    start = perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=os.environ | paths) as process:
        first = process.stdout.readline()
        seconds = perf_counter() - start
    if not first or process.returncode:
        raise RuntimeError(f"the first result of {model} did not come")
    return seconds


if __name__ == "__main__":
    main()

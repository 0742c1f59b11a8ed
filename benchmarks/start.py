"""From the start of a process to its first result."""

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

SWEEP = """
import sys, snapmap
device = snapmap.load_device(sys.argv[1])
cube = snapmap.sweep(device, N=[1000], f0=[1500], C=[0.025], model=sys.argv[2], repeat=False)
print(cube.t_snap.item())
"""
FOLLOW = """
import sys
from snapmap.cells import follow_cells, to_cells
from snapmap.config import load_device
from snapmap.models import build_model
from snapmap.protocol import Protocol
device = load_device(sys.argv[1])
cells = to_cells(device, [1000], [1500], [0.025], 1500)
print(follow_cells(build_model(device, sys.argv[2]), cells, Protocol()).t_snap.item())
"""


class Start(NamedTuple):
    """Seconds from a process's start to its first result, one cell.

    cold: of `sweep`, with an empty kernel cache
    sweep, follow: of `sweep` and of `follow_cells`, which needs no xarray; with a full one
    """

    cold: float
    sweep: float
    follow: float


def time_start(model: str, rounds: int = 3) -> Start:
    """Run a new process for each figure; the last two are the best of `rounds`."""
    with TemporaryDirectory() as cache:
        cold = _one_process(SWEEP, model, cache)
        programs = SWEEP, FOLLOW
        warm = (min(_one_process(p, model, cache) for _ in range(rounds)) for p in programs)
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

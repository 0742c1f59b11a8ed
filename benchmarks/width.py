"""What one core can do, and how near the kernel comes, with vectors of either width.

PYTHONPATH=workflow/scripts ./run python benchmarks/width.py [--small]

Each width is measured in processes of its own, as a kernel is compiled for one.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from snapmap import load_device
from snapmap.io.markdown import number, table
from snapmap.numerics import kernels
from studies.few import few

ROOT = Path(__file__).resolve().parents[1]
WIDTHS = 512, 256
ROUNDS = 2
"""Processes of each width, in turns; the best of each figure counts."""


class Width(NamedTuple):
    """Of one core: multiply-adds, FLOP/s; time of a lane-step, s, and its FLOP, by model."""

    peak: float
    seconds: dict[str, float]
    flops: dict[str, int]


def measure_widths() -> dict[int, Width]:
    """Start the processes, one at a time; a machine without vectors so wide gives one width."""
    runs = [(bits, _run(bits)) for _ in range(few(ROUNDS)) for bits in WIDTHS]
    found = {}
    for bits in WIDTHS:
        mine = [run for asked, run in runs if asked == bits]
        if mine[0]["bits"] == bits:
            names = mine[0]["seconds"]
            seconds = {name: min(run["seconds"][name] for run in mine) for name in names}
            found[bits] = Width(max(run["peak"] for run in mine), seconds, mine[0]["flops"])
    return found


def width_table(widths: dict[int, Width]) -> str:
    """The bare kernel, all lanes full, against the larger of the peaks."""
    peak = max(width.peak for width in widths.values())
    head = ["", "FLOP per lane-step"]
    for bits in widths:
        head += [f"{bits} bits: ns per lane-step", "GFLOP/s", "of peak"]
    rows = []
    for name, flops in next(iter(widths.values())).flops.items():
        rows.append([name, number(flops)])
        for width in widths.values():
            speed = flops / width.seconds[name]
            rows[-1] += [number(1e9 * width.seconds[name]), number(speed / 1e9)]
            rows[-1] += [f"{speed / peak:.0%}"]
    rows.append(["multiply-adds alone", ""])
    for width in widths.values():
        rows[-1] += ["", number(width.peak / 1e9), f"{width.peak / peak:.0%}"]
    return table(head, rows)


def _run(bits):
    with TemporaryDirectory() as cache:
        paths = {"NUMBA_CACHE_DIR": cache}
        command = [sys.executable, __file__, *sys.argv[1:], str(bits)]
        done = subprocess.run(command, env=os.environ | paths, stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def _measure(bits):
    kernels.VECTOR_BITS = bits  # before anything is compiled
    from kernel import KERNELS, block_seconds, peak_flops, step_flops, vector_bits

    from snapmap.solver.models import build_model

    device = load_device(ROOT / "config" / "config.yaml")
    models = {name: build_model(device, **options) for name, options in few(KERNELS).items()}
    return {
        "peak": peak_flops(),
        "bits": vector_bits(),
        "seconds": {name: block_seconds(model) for name, model in models.items()},
        "flops": {name: step_flops(model) for name, model in models.items()},
    }


def main():
    if sys.argv[-1].isdigit():
        print(json.dumps(_measure(int(sys.argv[-1]))))
    else:
        print(width_table(measure_widths()))


if __name__ == "__main__":
    main()

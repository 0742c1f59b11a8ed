"""The report, section by section."""

import os
import platform
import re
from collections.abc import Iterator
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from contenders import FOUR, MODELS, build
from errors import error_section
from markdown import number, rate, ratio, table
from speed import speed_section
from start import time_start
from width import measure_widths, width_table
from workload import by_model, random_cells, take_turns

from snapmap.device import Device
from snapmap.models import Model

COUNTS = 1_000, 10_000, 100_000, 1_000_000


def sections(device: Device) -> Iterator[str]:
    """Measure one after the other."""
    widths = measure_widths()
    peak = max(width.peak for width in widths.values())
    models = {name: build(device, name) for name in MODELS}
    yield header(max(widths), peak)
    yield speed_section(device, models, peak)
    yield error_section(device)
    yield f"\n## The bare kernel, all lanes full\n\n{width_table(widths)}"
    yield scaling_section(device, models[FOUR])
    yield start_section()


def header(bits: int, peak: float) -> str:
    """The machine and the versions."""
    packages = ("numpy", "numba", "llvmlite", "scipy", "heyoka")
    versions = ", ".join(
        f"{name} {version(name)}" if find_spec(name) else f"no {name}" for name in packages
    )
    return f"""# Speed and error, measured

{cpu_name()}, {os.cpu_count()} cores, vectors of {bits} bits; one core was seen to do
{peak / 1e9:.0f} GFLOP/s of multiply-adds.
Python {platform.python_version()}, {versions}.
numbalsoda is left out: it comes as source only and needs a Fortran compiler.
One process and one thread unless a column says otherwise, kernels compiled beforehand.
"""


def cpu_name() -> str:
    """The processor's name as Linux gives it, else its architecture."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return found[1] if found else platform.machine()


def scaling_section(device: Device, model: Model) -> str:
    """Cells and threads."""
    rows = []
    for count in COUNTS:
        cells = random_cells(device, count)
        tasks = {n: partial(by_model(model, threads=n), cells) for n in (1, 2)}
        one, two = (run.seconds for run in take_turns(tasks, min(5, 10**6 // count)).values())
        rows.append([number(count), rate(count, one), rate(count, two), ratio(one / two)])
    head = ["cells", "sims/s, 1 thread", "2 threads", "gain"]
    return f"\n## {FOUR}: random cells of the same map, with proofs\n\n{table(head, rows)}"


def start_section() -> str:
    """New processes."""
    rows = [[name, *map(number, time_start(name))] for name in ("handout", "cosines")]
    head = ["one cell", "`sweep`, nothing cached, s", "`sweep`, s", "`follow_cells`, s"]
    return f"\n## From the start of a process to its first result\n\n{table(head, rows)}"

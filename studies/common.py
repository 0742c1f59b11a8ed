"""Functions that studies share: options of the command, files, thresholds, times and numbers."""

import argparse
import json
import platform
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple

import numpy as np

from snapmap import load_device, threshold
from snapmap.config.devices import read_device
from snapmap.device.device import Device
from snapmap.files.text import plain
from snapmap.solver.cells import to_cells
from snapmap.solver.models import Model
from snapmap.solver.steps import fixed
from snapmap.thresholds.probe import refine

ROOT = Path(__file__).resolve().parents[1]
SMALL = "--small"


def is_small() -> bool:
    """Whether the command asks for a small run, which only shows that the study works."""
    return SMALL in sys.argv[1:]


def few(values: Sequence | Mapping | int, count: int = 1) -> Sequence | Mapping | int:
    """Return the values, or their number, and in a small run only the first `count`."""
    if not is_small():
        return values
    if isinstance(values, int):
        return min(values, count)
    return dict(islice(values.items(), count)) if isinstance(values, Mapping) else values[:count]


def command_device() -> Device:
    """Read the device of the option --device, a config in JSON, or the handout's device."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--device", type=json.loads)
    config = parser.parse_known_args()[0].device
    return read_device(config["device"]) if config else load_device(ROOT / "config" / "config.yaml")


def results(name: str) -> Path:
    """Return the path of a result, and make its folder."""
    path = Path("results") / name
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def with_beam(device: Device, **values: float) -> Device:
    """Return the device with other values of its beam."""
    return replace(device, beam=replace(device.beam, **values))


def stepped(model: Model, dt: float) -> Model:
    """Return the model of one device with the fixed time step dt, us."""
    return replace(model, steps=fixed(np.array([dt])))


def bending_limit(model: Model) -> float:
    """Return 2/omega_max, us, of linear bending and of the mass on its spring, of one device."""
    return float(min(2 / np.sqrt(model.modal.stiffness[-1]), 2 / model.device.mass_frequency))


def asking(
    device: Device, follow: Callable, rows: tuple[np.ndarray, np.ndarray], horizon: float
) -> Callable:
    """Make a function of N, (rows, n), that returns t_snap, us; NaN where N is NaN.

    follow: function of cells, (cells,), that returns t_snap; rows: f0 (Hz) and C, each (rows,)
    """

    def ask(N):
        f0, C = (np.broadcast_to(a[:, np.newaxis], N.shape) for a in rows)
        t_snap, known = np.full(N.shape, np.nan), np.isfinite(N)
        t_snap[known] = follow(to_cells(device, 0, N[known], f0[known], C[known], horizon))
        return t_snap

    return ask


def clean_rows(device: Device, f0: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Find f0 (Hz), C (uN us/um) and the threshold of rows that are not ragged, (3, rows)."""
    rows = threshold(device, f0, C)[["N_first", "ragged"]].stack(row=("C", "f0"))
    rows = rows.isel(row=(rows.ragged.values == 0) & np.isfinite(rows.N_first.values))
    return np.array([rows.f0.values, rows.C.values, rows.N_first.values])


def threshold_near(ask: Callable, N: np.ndarray, factor: float, tolerance: float) -> np.ndarray:
    """Find the threshold of each row within a factor of N, (rows,); NaN if it is not there.

    ask: function of N, (rows, n), that returns t_snap; tolerance: relative
    """
    low, high = N / factor, N * factor
    snapped = np.isfinite(ask(np.column_stack([low, high])))
    is_near = ~snapped[:, 0] & snapped[:, 1]
    return refine(ask, *(np.where(is_near, end, np.nan) for end in (low, high)), tolerance)[1]


class Timed(NamedTuple):
    """The result of a task, and its time, s."""

    result: Any
    seconds: float


def take_turns(
    tasks: dict, rounds: int, clock: Callable = perf_counter, of_rounds: Callable = min
) -> dict[Any, Timed]:
    """Run tasks in turns, A B C A B C ..., `rounds` times; by default the shortest time counts."""
    results, times = {}, {name: [] for name in tasks}
    for _ in range(rounds):
        for name, task in tasks.items():
            start = clock()
            results[name] = task()
            times[name].append(clock() - start)
    return {name: Timed(result, of_rounds(times[name])) for name, result in results.items()}


def cpu_seconds(task: Callable, rounds: int) -> float:
    """Measure the CPU time of a task, s, the least of rounds."""
    return take_turns({0: task}, rounds, process_time)[0].seconds


def machine() -> str:
    """Return the processor's name from Linux, or else its architecture."""
    info = Path("/proc/cpuinfo")
    name = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return name[1] if name else platform.machine()


def number(value: float) -> str:
    """Write three significant digits."""
    return plain(value, 3)


def ratio(value: float) -> str:
    """Write a ratio, or its inverse if that is larger: 12.3, 1/420."""
    return number(value) if value >= 1 else f"1/{number(1 / value)}"

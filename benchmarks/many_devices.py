"""Cells of many devices against cells of one: how many a second, with the set-up of the models.

PYTHONPATH=workflow/scripts ./run python benchmarks/many_devices.py [--small]
"""

from functools import partial
from itertools import product
from pathlib import Path
from time import perf_counter

import numpy as np
from timing import take_turns

from snapmap import load_device, threshold
from snapmap.axes import make_grid
from snapmap.io.markdown import number, rate, table
from snapmap.numerics.portable import linear
from snapmap.solver.adaptive import choose_model
from snapmap.solver.outcome import count
from snapmap.solver.settings import Settings
from snapmap.sweeps.grid import follow_grid
from studies.few import few

ROOT = Path(__file__).resolve().parents[1]
DEVICES, FEWEST, ROUNDS, THREADS, SIDE = 10_000, 16, 3, 2, 21
N, SHOCK = 1000.0, {"C": [25.0], "f0": [1500.0]}
VARIED = np.linspace(0.9, 1.1, DEVICES)
"""Thickness over the nominal one."""
EXPONENT = -2.18
"""Of N over the threshold as a function of it: docs/limits.md."""
MODELS = {
    "handout": {"name": "handout"},
    "cosines, 3 modes": {"name": "cosines", "modes": 3},
    "cosines, 5 modes": {"name": "cosines", "modes": 5},
}
HEAD = [
    *("model", "repeated", "devices/s", "cells/s", "ratio", "set-up of the devices, s"),
    *("outcomes, devices", "outcomes, cells"),
]


def main():
    device, rows = load_device(ROOT / "config" / "config.yaml"), []
    for (name, model), repeat in product(few(MODELS).items(), few((False, True))):
        settings = Settings(repeat=repeat, threads=THREADS)
        rows.append([name, "yes" if repeat else "no", *_compare(device, model, settings)])
    print(f"{few(DEVICES, FEWEST)} devices with one cell each, and as many cells of one device\n")
    print(table(HEAD, rows))
    print(f"\n{_threshold_map(device)}")


def _threshold_map(device):
    """Time and error bars of thresholds over thickness and spring, pulses of 1 ms."""
    axes = {"thickness": few(linear(1.8, 2.2, SIDE)), "spring": few(linear(4, 7, SIDE))}
    begin = perf_counter()
    found = threshold(device, [1000.0], [25.0], threads=THREADS, **axes)
    seconds, relative = perf_counter() - begin, (found.N_error / found.N_first).values
    return (
        f"{found.N_first.size} thresholds of `auto`: {seconds:.0f} s, error bars "
        f"{np.median(relative):.3%} (median), {relative.max():.2%} (largest)"
    )


def _compare(device, model, settings):
    many, one = of_many(device), of_one()
    tasks = {
        "devices": partial(_follow, device, many, model, settings),
        "cells": partial(_follow, device, one, model, settings),
        "set-up": partial(_build, device, many, model),
    }
    take_turns(tasks, 1)  # compiles
    runs = take_turns(tasks, ROUNDS)
    outcomes = [_words(count(runs[name].result)) for name in ("devices", "cells")]
    devices, cells, setup = (run.seconds for run in runs.values())
    rates = [rate(few(DEVICES, FEWEST), seconds) for seconds in (devices, cells)]
    return [*rates, f"{cells / devices:.2f}", number(setup), *outcomes]


def of_many(device):
    """Axes of devices, no two of which share a barrier, under one shock."""
    return {"thickness": device.beam.thickness * few(VARIED, FEWEST), **SHOCK, "N": [N]}


def of_one():
    """Axes of as many cells, as far below and above the threshold as those of the devices."""
    return SHOCK | {"N": N * few(VARIED, FEWEST) ** EXPONENT}


def _build(device, axes, model):
    grid = make_grid(device, axes)
    return grid, choose_model(grid.device, model)


def _follow(device, axes, model, settings):
    grid, built = _build(device, axes, model)
    return follow_grid(built, grid, settings)["outcome"]


def _words(counts):
    return ", ".join(f"{cells} {name}" for name, cells in counts.items())


if __name__ == "__main__":
    main()

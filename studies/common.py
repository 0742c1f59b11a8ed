"""What the studies share: how much is run, on which device and machine, where results go, times."""

import argparse
import json
import platform
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple

import numpy as np

from snapmap import load_device
from snapmap.config.devices import read_device
from snapmap.device.device import Device
from snapmap.solver.models import Model
from snapmap.solver.steps import fixed

ROOT = Path(__file__).resolve().parents[1]
SMALL = "--small"


def is_small() -> bool:
    """Whether the command asks for a small run, which just shows that the study runs."""
    return SMALL in sys.argv[1:]


def few(values: Sequence | Mapping | int, count: int = 1) -> Sequence | Mapping | int:
    """All values, or how many there are; in a small run the first `count`."""
    if not is_small():
        return values
    if isinstance(values, int):
        return min(values, count)
    return dict(islice(values.items(), count)) if isinstance(values, Mapping) else values[:count]


def command_device() -> Device:
    """The device of the section that the command gives as JSON, or the handout's."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--device", type=json.loads)
    given = parser.parse_known_args()[0].device
    return read_device(given["device"]) if given else load_device(ROOT / "config" / "config.yaml")


def results(name: str) -> Path:
    """Path of a result in the folder of the run, which is made."""
    path = Path("results") / name
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def stepped(model: Model, dt: float) -> Model:
    """The model of one device with a step of dt, us, whatever its rule says."""
    return replace(model, steps=fixed(np.array([dt])))


def bending_limit(model: Model) -> float:
    """2/omega_max, us, of linear bending and of the mass on its spring, of one device."""
    return float(min(2 / np.sqrt(model.modal.stiffness[-1]), 2 / model.device.mass_frequency))


class Run(NamedTuple):
    """A task's result, and the time that it took, s."""

    result: Any
    seconds: float


def take_turns(
    tasks: dict, rounds: int, clock: Callable = perf_counter, of_rounds: Callable = min
) -> dict[Any, Run]:
    """Run every task `rounds` times, in turns, A B C A B C ...; by default the shortest counts."""
    results, times = {}, {name: [] for name in tasks}
    for _ in range(rounds):
        for name, task in tasks.items():
            start = clock()
            results[name] = task()
            times[name].append(clock() - start)
    return {name: Run(result, of_rounds(times[name])) for name, result in results.items()}


def cpu_seconds(task: Callable, rounds: int) -> float:
    """CPU time of a task, s, the least of rounds."""
    return take_turns({0: task}, rounds, process_time)[0].seconds


def versions(*packages: str) -> str:
    """Python's and those of packages, as far as they are installed."""
    known = (f"{name} {version(name)}" if find_spec(name) else f"no {name}" for name in packages)
    return ", ".join([f"Python {platform.python_version()}", *known])


def machine() -> str:
    """The processor's name as Linux gives it, else its architecture."""
    info = Path("/proc/cpuinfo")
    name = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return name[1] if name else platform.machine()


def number(value: float) -> str:
    """Write three significant digits, thousands apart: 5 140, 0.61."""
    return f"{float(f'{value:.3g}'):,}".removesuffix(".0").replace(",", " ")


def rate(count: int, seconds: float) -> str:
    """Write how many there are in a second."""
    return number(count / seconds)


def ratio(value: float) -> str:
    """Write how many times as much it is, or by its inverse: 12.3, 1/420."""
    return number(value) if value >= 1 else f"1/{number(1 / value)}"

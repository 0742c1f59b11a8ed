"""How long tasks take, one after the other in turns."""

from time import perf_counter
from typing import Any, NamedTuple

import numpy as np


class Run(NamedTuple):
    """A task's result, and the shortest time that it took, s."""

    result: Any
    seconds: float


def take_turns(tasks: dict, rounds: int) -> dict[Any, Run]:
    """Run every task `rounds` times, in turns, A B C A B C ..."""
    runs = {}
    for _ in range(rounds):
        for name, task in tasks.items():
            start = perf_counter()
            result = task()
            seconds = perf_counter() - start
            runs[name] = Run(result, min(seconds, runs[name].seconds if name in runs else np.inf))
    return runs

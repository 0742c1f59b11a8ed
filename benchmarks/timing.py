"""How long tasks take, one after the other in turns."""

from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple


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

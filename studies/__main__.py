"""Run a study by its name: ./run python -m studies NAME [--small]."""

import sys
import time
from collections.abc import Callable
from importlib import import_module
from multiprocessing import Process
from pathlib import Path

TABLES = Path("results", "studies")

NAMES = (
    *("accuracy", "stability", "steps", "coverage", "motion", "tolerances"),
    *("convergence", "labels", "validation", "measured", "laws", "laws_speed", "peers"),
    *("clamps", "limits", "islands", "calibration", "impacts"),
)
SLOW = ("coverage", "stability", "steps")
"""Studies that take more than ten minutes of a processor."""


def main() -> None:
    """Run the study that the command names, with the rest of its arguments."""
    if len(sys.argv) < 2 or sys.argv[1] not in NAMES:
        sys.exit(f"python -m studies: name one of {', '.join(NAMES)}")
    name = sys.argv.pop(1)
    if fault := fault_of(run, name):
        sys.exit(f"python -m studies {name}: {fault}")


def run(name: str) -> None:
    """Run a study in this process."""
    is_package = Path(__file__).with_name(name).is_dir()
    import_module(f"studies.{name}{'.__main__' if is_package else ''}").main()


def fault_of(task: Callable, *arguments: object) -> str:
    """Run a task in a process of its own; return what is wrong unless it ends with a table.

    A library that it calls may end the process without a word.
    """
    begin, process = time.time(), Process(target=task, args=arguments)
    process.start()
    process.join()
    made = [path for path in TABLES.glob("*.csv") if path.stat().st_mtime >= begin - 1]
    if process.exitcode:
        return f"ended with status {process.exitcode} (a signal if negative)"
    return "" if made else f"ended without a table in {TABLES}"


if __name__ == "__main__":
    main()

"""Run a study by its name: ./run python -m studies NAME [--small]."""

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

NAMES = (
    *("accuracy", "stability", "steps", "coverage", "ends", "motion", "tolerances"),
    *("convergence", "labels", "validation", "measured", "laws", "peers"),
    *("clamps", "limits", "islands", "calibration", "impacts"),
)
SLOW = ("coverage", "stability", "steps")
"""Studies that take more than ten minutes of a processor."""
TABLES = Path("results", "studies")


RUN = "from studies.__main__ import run; run()"


def main() -> None:
    """Run the study that the command names, with the rest of its arguments."""
    if len(sys.argv) < 2 or sys.argv[1] not in NAMES:
        sys.exit(f"python -m studies: name one of {', '.join(NAMES)}")
    if fault := fault_of([sys.executable, "-c", RUN, *sys.argv[1:]]):
        sys.exit(f"python -m studies {sys.argv[1]}: {fault}")


def run() -> None:
    """Run the study in this process."""
    name = sys.argv.pop(1)
    is_package = Path(__file__).with_name(name).is_dir()
    import_module(f"studies.{name}{'.__main__' if is_package else ''}").main()


def fault_of(command: Sequence[str]) -> str:
    """Run a command; return what is wrong unless it ends well and has made a table.

    A library that a study calls may end its process without a word.
    """
    begin, paths = time.time(), {"PYTHONPATH": os.pathsep.join(sys.path)}
    status = subprocess.run(command, env=os.environ | paths).returncode
    if status:
        return f"ended with status {status}; below 0 it is a signal, such as -9 for lack of memory"
    is_made = any(path.stat().st_mtime > begin - 1 for path in TABLES.glob("*.csv"))
    return "" if is_made else f"ended without a table in {TABLES}"


if __name__ == "__main__":
    main()

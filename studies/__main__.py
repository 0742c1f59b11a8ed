"""Run a study by its name: ./run python -m studies NAME [--small]."""

import runpy
import sys

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
    runpy.run_module(f"studies.{sys.argv.pop(1)}", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()

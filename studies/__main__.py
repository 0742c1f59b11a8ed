"""Run a study by its name: ./run python -m studies NAME [--small]."""

import sys
from importlib import import_module
from pathlib import Path

NAMES = (
    *("accuracy", "stability", "steps", "coverage", "ends", "motion", "tolerances"),
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
    is_package = Path(__file__).with_name(name).is_dir()
    import_module(f"studies.{name}{'.__main__' if is_package else ''}").main()


if __name__ == "__main__":
    main()

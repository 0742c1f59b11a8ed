"""The first threshold of a new process, with kernels to compile and with compiled ones."""

import os
import subprocess
import sys
from collections.abc import Iterator
from tempfile import TemporaryDirectory

from snapmap.files.text import DASH

from ..common import ROOT, number

FIRST = """
import sys, snapmap
device = snapmap.load_device(sys.argv[1])
print(snapmap.threshold(device, [1500], [25]).N_first.item())
"""


def starts() -> Iterator[list[str]]:
    """Yield rows of the processor time from the start of a process to its first threshold."""
    with TemporaryDirectory() as cache:
        for state in ("nothing compiled", "compiled"):
            words = number(1e3 * start(cache)), *[DASH] * 4
            yield ["snapmap.threshold", f"new process, {state}", "auto", *words]


def start(cache: str) -> float:
    """Return the processor time of a new process that keeps its kernels in `cache`, s."""
    paths = {"PYTHONPATH": str(ROOT / "workflow" / "scripts"), "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", FIRST, str(ROOT / "config" / "config.yaml")]
    begin = sum(os.times()[2:4])
    subprocess.run(command, env=os.environ | paths, check=True, stdout=subprocess.DEVNULL)
    return sum(os.times()[2:4]) - begin

"""The report, section by section."""

import os
import platform
import re
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from contenders import FEWEST, MODELS, build
from errors import error_section
from kernel import peak_flops, vector_bits
from speed import speed_section

from snapmap.device import Device
from studies.few import few


def sections(device: Device) -> Iterator[str]:
    """Measure one after the other."""
    peak = peak_flops()
    yield header(vector_bits(), peak)
    yield speed_section(device, {name: build(device, name) for name in few(MODELS, FEWEST)}, peak)
    yield error_section(device)


def header(bits: int, peak: float) -> str:
    """The machine and the versions."""
    return f"""# Speed and error, measured

{cpu_name()}, {os.cpu_count()} cores, vectors of {bits} bits; one core was seen to do
{peak / 1e9:.0f} GFLOP/s of multiply-adds.
{versions("numpy", "numba", "llvmlite", "scipy", "heyoka")}.
numbalsoda is left out: it comes as source only and needs a Fortran compiler.
One process and one thread unless a column says otherwise, kernels compiled beforehand.
"""


def versions(*packages: str) -> str:
    """Python's and those of packages, as far as they are installed."""
    found = (f"{name} {version(name)}" if find_spec(name) else f"no {name}" for name in packages)
    return ", ".join([f"Python {platform.python_version()}", *found])


def cpu_name() -> str:
    """The processor's name as Linux gives it, else its architecture."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return found[1] if found else platform.machine()

"""Recorded shocks: files of acceleration over time are read, checked and made pulses."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from ..files.named import naming, read_named
from ..files.tables import read_table
from ..files.text import NAME, is_name
from ..values.kinds import Fitting
from ..values.quantities import ExistingPath
from .pulse import G, Pulse, sampled

MOST_SAMPLES = 1_000_000
RECORD = 200_000_000, f"write at most {MOST_SAMPLES} samples"
"""Most bytes of a record, and the remedy for more: no shock needs so many samples."""
TIMES = {"s": 1e6, "ms": 1e3, "us": 1.0, "µs": 1.0, "μs": 1.0}
ACCELERATIONS = {"g": G, "m/s^2": 1e-6, "m/s2": 1e-6, "m/s²": 1e-6, "m/s**2": 1e-6}
"""Factors to us and um/us^2, by unit."""


def _is_hash(value):
    return isinstance(value, str) and re.fullmatch("([0-9a-f]{64})?", value)


_HASH = Fitting("the 64 hexadecimal digits of a SHA-256", _is_hash)
Hash = Annotated[str, _HASH]


def read_pulse(path: ExistingPath, sha256: Hash = "") -> Pulse:
    """Read a recorded shock; it keeps its duration, and N scales its largest acceleration.

    Parameters
    ----------
    path
        CSV of time (s, ms or us) and acceleration (g or m/s^2), with units in the header, as
        `time (ms),acceleration (g)`.
    sha256
        Expected hash of the file, 64 hexadecimal digits; empty for any.

    Returns
    -------
    Pulse
        The shock, for `Study(device, pulse=...)`; f0 is then None.

    Raises
    ------
    ValueError
        One line with the path, for a file that is no such record.

    Examples
    --------
    >>> snapmap.read_pulse("config/half_sine.csv").duration
    500.0
    """
    path = Path(path)
    with naming(path):
        content = read_named(path, *RECORD, sha256)
        columns = {"time": TIMES, "acceleration": ACCELERATIONS}
        table = read_table(content, columns, most=MOST_SAMPLES, rising="time")
        time, acceleration = table.values()
        if not is_name(path.stem):
            raise ValueError(f"its name stands in tables; rename it, in {NAME}")
        pulse = sampled(time, acceleration, path.stem)
        section = {"file": str(path)} | ({"sha256": sha256} if sha256 else {})
        return replace(pulse, peak=abs(acceleration).max(), section=section)

"""Recorded shocks: files of acceleration over time, read, checked and made pulses."""

from dataclasses import replace
from pathlib import Path
from tempfile import NamedTemporaryFile

import numpy as np

from ..checks import NAME, is_name
from ..pulse import Pulse, sampled
from .extras import needing
from .named import naming, read_named
from .tables import read_table

MOST_SAMPLES = 1_000_000
RECORD = 200_000_000, f"write at most {MOST_SAMPLES} samples"
"""Longer records are refused: a shock is over sooner, or is sampled far finer than it needs."""
UFF = (".uff", ".unv", ".uf")
TIMES = {"s": 1e6, "ms": 1e3, "us": 1.0, "µs": 1.0, "μs": 1.0}
ACCELERATIONS = {"g": 9.80665e-6, "m/s^2": 1e-6, "m/s2": 1e-6, "m/s²": 1e-6, "m/s**2": 1e-6}
"""Units by the words for them, in us and um/us^2."""


def read_pulse(path: str | Path, sha256: str = "") -> Pulse:
    """Read a recorded shock; N scales its largest acceleration, and it keeps its own duration.

    path: CSV of two columns, time (s, ms or us) and acceleration (g or m/s^2), whose header names
        the units, as in `time (ms),acceleration (g)`; or UFF with a dataset 58
    sha256: expected hash of the file, hex digits; empty for any
    Between samples the acceleration is linear. Raises ValueError, one line, naming file and fault.

    >>> snapmap.read_pulse("config/half_sine.csv").duration
    500.0
    """
    path = Path(path)
    with naming(path):
        content = read_named(path, *RECORD, sha256)
        if path.suffix.lower() in UFF:
            time, acceleration = _read_uff(content)
        else:
            columns = {"time": TIMES, "acceleration": ACCELERATIONS}
            time, acceleration = read_table(content, columns, most=MOST_SAMPLES).values()
        if not is_name(path.stem):
            raise ValueError(f"its name stands in tables; rename it, in {NAME}")
        pulse = sampled(time, acceleration, path.stem)
        return replace(pulse, peak=abs(acceleration).max(), given={"file": str(path)})


def _read_uff(content):
    """The first dataset 58 of acceleration over time, SI unless it names its units."""
    with needing("a universal file"):
        import pyuff

    try:
        with NamedTemporaryFile(suffix=".uff") as file:  # pyuff takes a path alone
            file.write(content)
            file.flush()
            sets = pyuff.UFF(file.name).read_sets()
    except Exception as error:  # pyuff lets errors of many types through
        raise ValueError(f"is no universal file ({error})") from None
    needed = {"type": 58, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 12}
    for held in sets if isinstance(sets, list) else [sets]:
        if needed.items() <= held.items():
            break
    else:
        raise ValueError("holds no dataset 58 of acceleration (12) over time (17)")
    if held["data"].size > MOST_SAMPLES:
        raise ValueError(f"has more than {MOST_SAMPLES} samples; write fewer")
    scales = []
    for axis, units, of_SI in (("abscissa", TIMES, "s"), ("ordinate", ACCELERATIONS, "m/s^2")):
        unit = str(held.get(f"{axis}_axis_units_lab") or "").strip().strip("()[]")
        unit = of_SI if unit in ("", "NONE") else unit
        if unit not in units:
            raise ValueError(f"{axis}: {unit!r} is not one of {', '.join(units)}")
        scales.append(units[unit])
    return np.asarray(held["x"], float) * scales[0], np.real(np.asarray(held["data"])) * scales[1]
